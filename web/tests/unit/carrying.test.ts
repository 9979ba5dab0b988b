import assert from "node:assert/strict";
import { test } from "node:test";
import { Carrying } from "../../src/motion/carrying.ts";
import { Kinematics } from "../../src/motion/kinematics.ts";
import type { Carry, Pose } from "../../src/data/page_data.ts";
import { angleBetween, compose, distanceBetween, inverse } from "../../src/motion/pose.ts";
import { postureAlong, postureOf } from "../../src/motion/posture.ts";
import { Recording } from "../../src/data/recording.ts";
import { type ShownPlan, Trajectory } from "../../src/motion/trajectory.ts";
import { INITIAL } from "../../src/data/view_state.ts";
import { CLOSED_S, CLOSES_S, ENDS_S, GRIPPING, LIFTED_S, RISING, carriedPage } from "../fixtures/carried_page.ts";

const page = carriedPage();
const [plan] = page.plans;
const kinematics = new Kinematics(GRIPPING);
const carrying = new Carrying(plan.carries, kinematics, page.nodes);
const shown: ShownPlan = {
  index: 0,
  plan,
  trajectory: new Trajectory(plan, 3),
  clearance: null,
  carrying,
  tree: null,
  colour: "#000000",
  reasons: new Map(),
};
const movers = { nodes: page.nodes, plans: [shown], kinematics, recording: null };
const target = page.nodes.findIndex(({ role }) => role === "target");
const standing = page.nodes[target].parent_from_node;

test("modes follow each other, and between the first two the hand closes evenly", () => {
  const modes = [0, CLOSES_S, CLOSES_S + 0.1, CLOSED_S, LIFTED_S, ENDS_S].map((time) => carrying.at(time).name);
  assert.deepEqual(modes, ["reach", "reach", "close", "lift-off", "carry", "carry"]);
  for (const [time, closing] of [
    [0, 0],
    [CLOSES_S, 0],
    [(CLOSES_S + CLOSED_S) / 2, 0.25],
    [CLOSED_S, 0.5],
    [ENDS_S, 0.5],
  ]) {
    assert.ok(Math.abs(carrying.closingAt(time) - closing) < 1e-12);
  }
  assert.ok(Math.abs(carrying.stoodUntil(ENDS_S) - (CLOSED_S - CLOSES_S)) < 1e-12);
});

test("the object stands, and from when the hand has closed it stays in it", () => {
  const grasp = postureAlong(shown, CLOSES_S, movers);
  const held = compose(inverse(grasp.worldFromGripper!), standing);
  for (let time = 0; time <= ENDS_S; time += 0.05) {
    const { worldFromNodes, worldFromGripper, during } = postureAlong(shown, time, movers);
    if (time < CLOSED_S) {
      assert.deepEqual([worldFromNodes[target], during], [standing, null]);
    } else {
      const expected = compose(worldFromGripper!, held);
      assert.ok(distanceBetween(worldFromNodes[target], expected) < 1e-9, `at ${time}`);
      assert.ok(angleBetween(worldFromNodes[target], expected) < 1e-6, `at ${time}`);
      assert.deepEqual(during, { plan: 0, segment: carrying.at(time).segment });
    }
  }
});

test("fingers go by as much of their stroke as the hand has closed", () => {
  const finger = page.robot.links.findIndex(({ name }) => name === "finger");
  const along = (time: number): number => {
    const { worldFromLinks, worldFromGripper } = postureAlong(shown, time, movers);
    return compose(inverse(worldFromGripper!), worldFromLinks[finger])[1];
  };
  assert.ok(Math.abs(along(0) - 0.02) < 1e-12);
  assert.ok(Math.abs(along(CLOSED_S) - 0.01) < 1e-12);
});

test("who poses the robot by hand has an empty one", () => {
  const { worldFromNodes, during, moved } = postureOf({ ...INITIAL, time_s: ENDS_S, q: [0, 0, 0] }, movers);
  assert.deepEqual([worldFromNodes[target], during, moved.size], [standing, null, 0]);
});

test("between two instants of a recording a body goes straight, and turns the shorter way", () => {
  const recording = new Recording(RISING);
  const [x, y, z, , , qz, qw] = recording.at(0.25).get(1)!;
  assert.deepEqual([x, y], [0, 0]);
  assert.ok(Math.abs(z - 0.525) < 1e-12 && Math.abs(2 * Math.atan2(qz, qw) - Math.PI / 4) < 1e-9);
  // The negated quaternion of the same rotation.
  const [, , , , , later, rest] = recording.at(0.75).get(1)!;
  assert.ok(Math.abs(2 * Math.atan2(Math.abs(later), Math.abs(rest)) - (3 * Math.PI) / 4) < 1e-9);
  assert.deepEqual([recording.at(-1).get(1), recording.at(9).get(1)], [
    [0, 0, 0.5, 0, 0, 0, 1],
    [0, 0, 0.6, 0, 0, -1, 0],
  ]);
  assert.equal(recording.duration_s, 1);
  assert.throws(() => new Recording({ ...RISING, tracks: [{ node: 1, poses: "" }] }), /node 1 has 0 numbers/);
});

test("what one step has put down stays there while the next carries it on or something else", () => {
  const turned = [0.1, 1.2, 0.4];
  const step = (from_s: number, object: string, grasp: number[], placed: number[]): Carry => ({
    object,
    grasp,
    closing: 0.5,
    placed,
    modes: ["reach", "carry", "retreat"].map((name, i) => {
      const properties = { holds: i === 1, touches: false, leaves: i === 2, segment: from_s + i };
      return { name, ...properties, from_s: from_s + i, until_s: from_s + i + 0.8 };
    }),
  });
  const [there, here] = [[0.1, 0.9, 0.85], turned];
  const steps = [step(0, "target", there, here), step(3, "table", there, here), step(6, "target", here, there)];
  const several = new Carrying(steps, kinematics, page.nodes);
  const pose = (q: number[]): Pose => kinematics.worldFromGripper(q);
  const at = (time: number, q: number[]): [string, Pose][] => [...several.movedAt(time, pose(q))];
  const motion = compose(pose(here), inverse(pose(there)));
  const isNear = (a: Pose, b: Pose): boolean => distanceBetween(a, b) < 1e-9 && angleBetween(a, b) < 1e-6;
  assert.deepEqual(at(0.5, there), []);
  const [[name, once]] = at(3.5, there);
  assert.ok(name === "target" && isNear(once, motion));
  assert.deepEqual(at(5, here).map(([name]) => name), ["target", "table"]);
  const back = new Map(at(9, there)).get("target")!;
  assert.ok(isNear(compose(back, standing), standing), "brought back to where it stood");
  assert.deepEqual([several.at(3.5).step, several.at(3.5).name, several.at(7.5).step], [1, "reach", 2]);
  assert.equal(several.stretches.filter(({ name }) => name === "open").length, 3);
  assert.ok(several.closingAt(5) === 0 && Math.abs(several.closingAt(4.5) - 0.5) < 1e-12);
});
