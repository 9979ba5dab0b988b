import type { Carrying } from "./carrying.ts";
import type { Clearance, Plan, SearchTree } from "../data/page_data.ts";
import { floats32, floats64, unsigned32 } from "../data/numbers.ts";

/** Index of the last of ascending `times` that is not after `time`; 0 if all are after it. */
export function indexAt(times: ArrayLike<number>, time: number): number {
  let low = 0;
  let high = times.length;
  while (high - low > 1) {
    const middle = (low + high) >> 1;
    if (times[middle] <= time) low = middle;
    else high = middle;
  }
  return low;
}

/** Configurations of the robot over time. */
export class Trajectory {
  readonly times_s: Float64Array;
  readonly waypointTimes_s: Float64Array;
  private readonly rows: Float64Array;
  private readonly width: number;

  /** `width`: number of variables in a configuration. */
  constructor(plan: Plan, width: number) {
    this.times_s = floats64(plan.times_s);
    this.rows = floats64(plan.configurations);
    this.waypointTimes_s = floats64(plan.waypoint_times_s);
    this.width = width;
    if (this.rows.length !== this.times_s.length * width) {
      throw new Error(
        `${plan.name}: ${this.times_s.length} instants of ${width} joints, but ${this.rows.length} numbers`,
      );
    }
  }

  get isEmpty(): boolean {
    return this.times_s.length === 0;
  }

  get duration_s(): number {
    return this.times_s.at(-1) ?? 0;
  }

  row(index: number): Float64Array {
    return this.rows.subarray(index * this.width, (index + 1) * this.width);
  }

  /** The configuration at a time; constant before the start and after the end. */
  at(time_s: number): Float64Array {
    const index = indexAt(this.times_s, time_s);
    const next = Math.min(index + 1, this.times_s.length - 1);
    const step_s = this.times_s[next] - this.times_s[index];
    const share = step_s > 0 ? Math.min(Math.max((time_s - this.times_s[index]) / step_s, 0), 1) : 0;
    const [a, b] = [this.row(index), this.row(next)];
    // Gives exactly b at share 1.
    return a.map((value, i) => value * (1 - share) + b[i] * share);
  }
}

/** Clearance of the robot over time. */
export class ClearanceCurve {
  readonly times_s: Float64Array;
  readonly distances_m: Float64Array;
  /** Distances from the world, and between the robot's own links. */
  readonly world_m: Float64Array;
  readonly own_m: Float64Array;
  private readonly closest: Uint32Array;
  private readonly points: Float32Array;
  private readonly pairs: Clearance["pairs"];

  constructor(clearance: Clearance) {
    this.times_s = floats64(clearance.times_s);
    this.distances_m = floats64(clearance.distances_m);
    this.world_m = floats64(clearance.world_m);
    this.own_m = floats64(clearance.own_m);
    this.closest = unsigned32(clearance.closest);
    this.points = floats32(clearance.points);
    this.pairs = clearance.pairs;
  }

  /** The closest pair at the measured instant nearest to a time. */
  at(time_s: number): Closest | null {
    if (this.times_s.length === 0) return null;
    const before = indexAt(this.times_s, time_s);
    const after = Math.min(before + 1, this.times_s.length - 1);
    const isAfter = this.times_s[after] - time_s < time_s - this.times_s[before];
    return this.row(isAfter ? after : before);
  }

  /** The instant with the least clearance. */
  get least(): Closest | null {
    if (this.times_s.length === 0) return null;
    return this.row(this.distances_m.reduce((least, x, i) => (x < this.distances_m[least] ? i : least), 0));
  }

  private row(index: number): Closest {
    const pair = this.pairs[this.closest[index]];
    return {
      time_s: this.times_s[index],
      distance_m: this.distances_m[index],
      first: pair?.first ?? "",
      second: pair?.second ?? "",
      points: this.points.subarray(6 * index, 6 * index + 6),
    };
  }
}

export interface Closest {
  time_s: number;
  distance_m: number;
  first: string;
  second: string;
  /** ax, ay, az, bx, by, bz */
  points: Float32Array;
}

/** A plan with decoded numbers. */
export interface ShownPlan {
  index: number;
  plan: Plan;
  trajectory: Trajectory;
  clearance: ClearanceCurve | null;
  /** Null unless the plan carries its object. */
  carrying: Carrying | null;
  tree: SearchTree | null;
  /** `#rrggbb` */
  colour: string;
  /** Reason that blocked each grasp, by index. */
  reasons: Map<number, string>;
}
