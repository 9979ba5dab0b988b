import assert from "node:assert/strict";
import { test } from "node:test";
import { ghostInstants } from "../../src/views/ghost_view.ts";
import { Kinematics } from "../../src/motion/kinematics.ts";
import { ClearanceCurve, type ShownPlan, Trajectory, indexAt } from "../../src/motion/trajectory.ts";
import { ROBOT, twoJointPage } from "../fixtures/two_joint_page.ts";

const [plan] = twoJointPage().plans;
const trajectory = new Trajectory(plan, 3);

test("the trajectory ends exactly at its last row and rests there", () => {
  const last = trajectory.row(trajectory.times_s.length - 1);
  assert.deepEqual(trajectory.at(trajectory.duration_s), last);
  assert.deepEqual(trajectory.at(1e9), last);
  assert.deepEqual(trajectory.at(-1), trajectory.row(0));
});

test("between two rows it is straight", () => {
  const [a, b] = [trajectory.row(3), trajectory.row(4)];
  const middle_s = (trajectory.times_s[3] + trajectory.times_s[4]) / 2;
  trajectory.at(middle_s).forEach((value, i) => assert.ok(Math.abs(value - (a[i] + b[i]) / 2) < 1e-12));
});

test("rows that do not fit the robot are refused", () => {
  assert.throws(() => new Trajectory(plan, 4), /61 instants of 4 joints, but 183 numbers/);
});

test("an index is that of the last instant that is not after a time", () => {
  const times = [0, 1, 1, 2];
  assert.deepEqual(
    [-1, 0, 0.5, 1, 1.5, 2, 3].map((time) => indexAt(times, time)),
    [0, 0, 0, 2, 2, 3, 3],
  );
});

test("the least clearance is found, and the pair of the nearest instant", () => {
  assert.ok(plan.clearance);
  const curve = new ClearanceCurve(plan.clearance);
  assert.ok(Math.abs((curve.least?.distance_m ?? 0) - 0.01) < 1e-12);
  assert.deepEqual([curve.at(0.4)?.first, curve.at(0.4)?.second], ["gripper", "table"]);
});

test("ghosts stand at the start, at the end, and equally far between", () => {
  const shown: ShownPlan = {
    index: 0,
    plan,
    trajectory,
    clearance: null,
    carrying: null,
    tree: null,
    colour: "#000000",
    reasons: new Map(),
  };
  const instants = ghostInstants(shown, new Kinematics(ROBOT), 5);
  assert.equal(instants.length, 5);
  assert.deepEqual([instants[0], instants.at(-1)], [0, trajectory.times_s.length - 1]);
});
