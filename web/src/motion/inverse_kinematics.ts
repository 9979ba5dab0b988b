import type { Kinematics } from "./kinematics.ts";
import type { Point, Pose } from "../data/page_data.ts";
import { compose, inverse } from "./pose.ts";

/** Iterations of one search; while the hand is dragged, the next search continues from the last result. */
const MOST_STEPS = 60;

/** Error at which the search ends, in metres and weighted radians together. */
const CLOSE_ENOUGH = 1e-7;

/** Initial damping; it shortens iterations near singular postures. */
const DAMPING = 0.02;

/** Weight of a radian relative to a metre. */
const RADIAN_M = 0.3;

/** Change of a joint for the numerical derivative. */
const DIFFERENCE = 1e-6;

/** A configuration within the limits that brings the gripper to a pose, or as close to it as a descent from `q` gets:
 * damped least squares (Buss 2009, "Introduction to Inverse Kinematics", §6), joints clamped to their limits. */
export function broughtTo(kinematics: Kinematics, target: Pose, q: number[]): number[] {
  const limits = kinematics.variables.map(({ lower, upper }) => [lower ?? -Infinity, upper ?? Infinity]);
  let best = [...q];
  let error = twist(kinematics.worldFromGripper(best), target);
  let damping = DAMPING;
  for (let step = 0; step < MOST_STEPS && length(error) > CLOSE_ENOUGH; step += 1) {
    const columns = best.map((value, joint) => {
      const moved = best.with(joint, value + DIFFERENCE);
      const after = twist(kinematics.worldFromGripper(moved), target);
      return after.map((each, row) => (error[row] - each) / DIFFERENCE);
    });
    const next = best.map((value, joint) => value + dot(columns[joint], damped(columns, error, damping)));
    const within = next.map((value, joint) => Math.min(Math.max(value, limits[joint][0]), limits[joint][1]));
    const left = twist(kinematics.worldFromGripper(within), target);
    if (length(left) < length(error)) {
      [best, error, damping] = [within, left, Math.max(damping / 2, 1e-5)];
    } else {
      damping *= 4;
      if (damping > 10) break;
    }
  }
  return best;
}

/** Translation (m) and rotation (rad, as a vector, scaled to metres) from one pose to another. */
function twist(from: Pose, to: Pose): number[] {
  const turn = compose(to, inverse(from));
  const sine = Math.hypot(turn[3], turn[4], turn[5]);
  const sign = turn[6] < 0 ? -1 : 1;
  const scale = sine < 1e-12 ? 2 : (2 * Math.atan2(sine, Math.abs(turn[6]))) / sine;
  const axis: Point = [turn[3], turn[4], turn[5]];
  return [to[0] - from[0], to[1] - from[1], to[2] - from[2], ...axis.map((value) => sign * scale * RADIAN_M * value)];
}

/** `(J Jᵀ + λ² 1)⁻¹ e`, by elimination. */
function damped(columns: number[][], error: number[], damping: number): number[] {
  const rows = error.map((value, i) => [
    ...error.map((_, j) =>
      columns.reduce((sum, column) => sum + column[i] * column[j], i === j ? damping * damping : 0),
    ),
    value,
  ]);
  rows.forEach((pivot, i) => {
    // The matrix is positive definite: no pivot is zero, so no pivoting is needed.
    rows.forEach((row, j) => {
      if (j === i) return;
      const factor = row[i] / pivot[i];
      for (let k = i; k < row.length; k += 1) row[k] -= factor * pivot[k];
    });
  });
  return rows.map((row, i) => row[error.length] / row[i]);
}

function dot(a: number[], b: number[]): number {
  return a.reduce((sum, value, i) => sum + value * b[i], 0);
}

function length(vector: number[]): number {
  return Math.hypot(...vector);
}
