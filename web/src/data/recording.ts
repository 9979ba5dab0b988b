import { floats64 } from "./numbers.ts";
import type * as data from "./page_data.ts";
import type { Pose } from "./page_data.ts";
import { indexAt } from "../motion/trajectory.ts";

/** Recorded motion of bodies, from any source. */
export class Recording {
  readonly times_s: Float64Array;
  private readonly tracks: { node: number; poses: Float64Array }[];

  constructor(recording: data.Recording) {
    this.times_s = floats64(recording.times_s);
    this.tracks = recording.tracks.map(({ node, poses }) => ({ node, poses: floats64(poses) }));
    const short = this.tracks.find(({ poses }) => poses.length !== 7 * this.times_s.length);
    if (short) throw new Error(`node ${short.node} has ${short.poses.length} numbers for ${this.times_s.length} poses`);
  }

  get duration_s(): number {
    return this.times_s.at(-1) ?? 0;
  }

  /** Poses of the moving nodes, by node, at a time; constant before the first and after the last instant. */
  at(time_s: number): Map<number, Pose> {
    const index = indexAt(this.times_s, time_s);
    const next = Math.min(index + 1, this.times_s.length - 1);
    const step_s = this.times_s[next] - this.times_s[index];
    const share = step_s > 0 ? Math.min(Math.max((time_s - this.times_s[index]) / step_s, 0), 1) : 0;
    return new Map(
      this.tracks.map(({ node, poses }) => {
        const row = (instant: number): Pose => Array.from(poses.subarray(7 * instant, 7 * instant + 7)) as Pose;
        return [node, between(row(index), row(next), share)];
      }),
    );
  }
}

/** Interpolates linearly from a to b and rotates the shorter way; nearly at constant speed. */
function between(a: Pose, b: Pose, share: number): Pose {
  const isOpposite = a[3] * b[3] + a[4] * b[4] + a[5] * b[5] + a[6] * b[6] < 0;
  const mixed = a.map((value, i) => value * (1 - share) + (i > 2 && isOpposite ? -b[i] : b[i]) * share) as Pose;
  const length = Math.hypot(mixed[3], mixed[4], mixed[5], mixed[6]);
  return mixed.map((value, i) => (i > 2 ? value / length : value)) as Pose;
}
