import assert from "node:assert/strict";
import { test } from "node:test";
import { Kinematics } from "../../src/motion/kinematics.ts";
import type { Pose } from "../../src/data/page_data.ts";
import { angleBetween, compose, distanceBetween, inverse, rotation, transformed } from "../../src/motion/pose.ts";
import { LOWER_M, ROBOT, UPPER_M } from "../fixtures/two_joint_page.ts";

const kinematics = new Kinematics(ROBOT);

test("the gripper of a planar arm is where trigonometry has it", () => {
  for (const q of [ROBOT.start, [0.3, 1.1, -0.7], [0, 0, 0], [-1, 2.5, 2.8]]) {
    const [x, y, z] = kinematics.worldFromGripper(q);
    const elbow = q[1] + q[2];
    assert.ok(Math.abs(x - (q[0] + UPPER_M * Math.sin(q[1]) + LOWER_M * Math.sin(elbow))) < 1e-12);
    assert.ok(Math.abs(y) < 1e-12);
    assert.ok(Math.abs(z - (0.6 + UPPER_M * Math.cos(q[1]) + LOWER_M * Math.cos(elbow))) < 1e-12);
  }
});

test("a joint that follows another turns by its share and its offset", () => {
  const poses = kinematics.worldFromLinks([0, 0, 0.8]);
  assert.ok(Math.abs(angleBetween(poses[4], poses[5]) - (0.5 * 0.8 + 0.1)) < 1e-12);
});

test("variables have the names and limits of the joints that they move", () => {
  assert.deepEqual(
    kinematics.variables.map(({ name, kind, upper }) => [name, kind, upper]),
    [
      ["base_x", "prismatic", 1],
      ["shoulder", "revolute", 2.5],
      ["elbow", "revolute", 2.8],
    ],
  );
});

test("links may come in any order, but not in a circle", () => {
  const circle = {
    ...ROBOT,
    links: [
      { name: "a", parent: 1 },
      { name: "b", parent: 0 },
    ],
    joints: [],
  };
  assert.throws(() => new Kinematics({ ...circle, start: [] }), /circle/);
});

/** With a search through all joints or links for each of them, this would take minutes. */
test("a chain of very many links, each before its parent, has all of them", () => {
  const count = 200_000;
  const links = Array.from({ length: count }, (_, link) => ({
    name: `link ${link}`,
    parent: link + 1 < count ? link + 1 : null,
  }));
  const joints = links.slice(1).map((_, child) => ({ ...ROBOT.joints[0], kind: "fixed" as const, child }));
  const chain = new Kinematics({ ...ROBOT, links, joints, tip: 0, start: [] });
  assert.equal(chain.worldFromLinks([]).length, count);
});

test("a pose and its inverse cancel, and composing is applying one after the other", () => {
  const a: Pose = compose([0.3, -1, 2, 0, 0, 0, 1], rotation([0.6, 0, 0.8], 1.3));
  const b: Pose = compose([-2, 0.1, 0.7, 0, 0, 0, 1], rotation([0, 1, 0], -2.2));
  assert.ok(distanceBetween(compose(a, inverse(a)), [0, 0, 0, 0, 0, 0, 1]) < 1e-12);
  const once = transformed(compose(a, b), [0.5, 0.25, -3]);
  const twice = transformed(a, transformed(b, [0.5, 0.25, -3]));
  once.forEach((value, i) => assert.ok(Math.abs(value - twice[i]) < 1e-12));
});
