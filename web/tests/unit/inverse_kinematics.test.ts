import assert from "node:assert/strict";
import { test } from "node:test";
import { broughtTo } from "../../src/motion/inverse_kinematics.ts";
import { Kinematics } from "../../src/motion/kinematics.ts";
import { angleBetween, compose, distanceBetween } from "../../src/motion/pose.ts";
import { ROBOT } from "../fixtures/two_joint_page.ts";

const kinematics = new Kinematics(ROBOT);

test("the gripper comes to a pose near by, as a hand drags it", () => {
  for (let k = 0; k < 200; k += 1) {
    const at = (slope: number, most: number): number => most * Math.sin(1 + slope * k);
    const end = [at(1.3, 0.7), at(2.1, 1.2), 0.5 + Math.abs(at(0.7, 1.5))];
    const begin = end.map((value, joint) => value + at(0.9 + joint, 0.2));
    const there = kinematics.worldFromGripper(end);
    const here = kinematics.worldFromGripper(broughtTo(kinematics, there, begin));
    assert.ok(distanceBetween(here, there) < 1e-6 && angleBetween(here, there) < 1e-5, `${k}: ${end.join(", ")}`);
  }
});

test("out of reach it comes as near as it gets, within the limits", () => {
  const begin = [0, 0.4, 0.5];
  const far = compose([3, 0.5, 4, 0, 0, 0, 1], kinematics.worldFromGripper(begin));
  const q = broughtTo(kinematics, far, begin);
  q.forEach((value, joint) => {
    const { lower, upper } = kinematics.variables[joint];
    assert.ok(value >= (lower ?? -Infinity) && value <= (upper ?? Infinity));
  });
  const [before, after] = [begin, q].map((each) => distanceBetween(kinematics.worldFromGripper(each), far));
  assert.ok(after < before - 0.5, `${before} to ${after}`);
});

test("a pose that is there already changes nothing", () => {
  const q = [0.1, 0.9, 0.85];
  assert.deepEqual(broughtTo(kinematics, kinematics.worldFromGripper(q), q), q);
});
