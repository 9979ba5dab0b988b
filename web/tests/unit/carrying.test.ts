import assert from "node:assert/strict";
import { test } from "node:test";
import { Carrying } from "../../src/carrying.ts";
import { Kinematics } from "../../src/kinematics.ts";
import { angleBetween, compose, distanceBetween, inverse } from "../../src/pose.ts";
import { postureAlong, postureOf } from "../../src/posture.ts";
import { Recording } from "../../src/recording.ts";
import { type ShownPlan, Trajectory } from "../../src/trajectory.ts";
import { INITIAL } from "../../src/view_state.ts";
import { CLOSED_S, CLOSES_S, ENDS_S, GRIPPING, LIFTED_S, RISING, carriedPage } from "../fixtures/carried_page.ts";

const page = carriedPage();
const [plan] = page.plans;
const kinematics = new Kinematics(GRIPPING);
const carrying = new Carrying(plan.carry!, kinematics);
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
  const modes = [0, CLOSES_S, CLOSES_S + 0.1, CLOSED_S, LIFTED_S, ENDS_S].map((time) => carrying.modeAt(time));
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
    const { worldFromNodes, worldFromGripper, held: what } = postureAlong(shown, time, movers);
    if (time < CLOSED_S) {
      assert.deepEqual([worldFromNodes[target], what], [standing, null]);
    } else {
      const expected = compose(worldFromGripper!, held);
      assert.ok(distanceBetween(worldFromNodes[target], expected) < 1e-9, `at ${time}`);
      assert.ok(angleBetween(worldFromNodes[target], expected) < 1e-6, `at ${time}`);
      assert.equal(what?.plan, 0);
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
  const { worldFromNodes, held, moved } = postureOf({ ...INITIAL, time_s: ENDS_S, q: [0, 0, 0] }, movers);
  assert.deepEqual([worldFromNodes[target], held, moved], [standing, null, null]);
});

test("between two instants of a recording a body goes straight, and turns the shorter way", () => {
  const recording = new Recording(RISING);
  const [x, y, z, , , qz, qw] = recording.at(0.25).get(1)!;
  assert.deepEqual([x, y], [0, 0]);
  assert.ok(Math.abs(z - 0.525) < 1e-12 && Math.abs(2 * Math.atan2(qz, qw) - Math.PI / 4) < 1e-9);
  // The same turn, written as its negative.
  const [, , , , , later, rest] = recording.at(0.75).get(1)!;
  assert.ok(Math.abs(2 * Math.atan2(Math.abs(later), Math.abs(rest)) - (3 * Math.PI) / 4) < 1e-9);
  assert.deepEqual([recording.at(-1).get(1), recording.at(9).get(1)], [
    [0, 0, 0.5, 0, 0, 0, 1],
    [0, 0, 0.6, 0, 0, -1, 0],
  ]);
  assert.equal(recording.duration_s, 1);
  assert.throws(() => new Recording({ ...RISING, tracks: [{ node: 1, poses: "" }] }), /node 1 has 0 numbers/);
});
