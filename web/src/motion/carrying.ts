import type { Kinematics } from "./kinematics.ts";
import type { Carry, Mode, Node, Pose } from "../data/page_data.ts";
import { compose, inverse } from "./pose.ts";

/** Displacement in the planning frame of each body that is not at its pose in the scenario, by name. */
export type Moved = ReadonlyMap<string, Pose>;

/** Stage of a plan over time; "close" and "open" while the robot stands and its hand moves. */
export interface Stretch extends Mode {
  /** Index, among the plan's carried objects, of the one to which this belongs. */
  step: number;
}

/** Motion over time of the objects that a plan carries, one after the other. */
export class Carrying {
  /** Consecutive stages, except those in which the hand closes or opens. */
  readonly modes: Stretch[];
  /** All stages, including those in which the hand closes or opens. */
  readonly stretches: Stretch[];
  /** Names of the carried objects. */
  readonly objects: ReadonlySet<string>;
  readonly stepCount: number;
  private readonly stops: Stretch[];
  private readonly transfers: Transfer[];

  /** An object whose name matches no node is the target. */
  constructor(carries: Carry[], kinematics: Kinematics, nodes: Node[]) {
    const target = nodes.find(({ role }) => role === "target")?.name ?? "";
    const bodies = new Set(nodes.flatMap(({ name, role }) => (role === "link" ? [] : [name])));
    this.transfers = carries.map(
      (carry) => new Transfer(carry, bodies.has(carry.object) ? carry.object : target, kinematics),
    );
    const stretches = (of: (transfer: Transfer) => Mode[]): Stretch[] =>
      this.transfers.flatMap((transfer, step) =>
        of(transfer).map((mode) => ({ ...mode, step })),
      );
    this.modes = stretches(({ modes }) => modes);
    this.stops = stretches(({ stops }) => stops);
    this.stretches = [...this.modes, ...this.stops].sort((a, b) => a.from_s - b.from_s);
    this.objects = new Set(this.transfers.map(({ object }) => object));
    this.stepCount = carries.length;
  }

  /** Closed fraction of the fingers, from 0 (open) to 1. */
  closingAt(time_s: number): number {
    return Math.max(...this.transfers.map((transfer) => transfer.closingAt(time_s)));
  }

  /** Total time in seconds, up to `time_s`, during which the robot stood while its hand moved. */
  stoodUntil(time_s: number): number {
    return this.stops.reduce((sum, stop) => sum + stood(stop, time_s), 0);
  }

  movedAt(time_s: number, worldFromGripper: Pose): Moved {
    const moved = new Map<string, Pose>();
    for (const transfer of this.transfers) {
      const motion = transfer.motionAt(time_s, worldFromGripper);
      if (!motion) continue;
      const before = moved.get(transfer.object);
      moved.set(transfer.object, before ? compose(motion, before) : motion);
    }
    return moved;
  }

  at(time_s: number): Stretch {
    const stop = this.stops.find(({ from_s, until_s }) => time_s > from_s && time_s < until_s);
    return stop ?? this.modes.findLast(({ from_s }) => from_s <= time_s) ?? this.modes[0];
  }
}

/** Transport of one object: it is picked up and perhaps put down. */
class Transfer {
  readonly object: string;
  readonly modes: Mode[];
  /** Stops of the robot while its hand closes, and while it opens again if the object is put down. */
  readonly stops: Mode[];
  private readonly closing: number;
  private readonly graspFromWorld: Pose;
  private readonly placed: Pose | null;

  constructor(carry: Carry, object: string, kinematics: Kinematics) {
    this.object = object;
    this.modes = carry.modes;
    // During a stop, a posture is judged as on the segment before it.
    this.stops = carry.modes.slice(1).flatMap(({ holds, from_s }, index) => {
      const before = carry.modes[index];
      if (before.holds === holds) return [];
      return [{ ...before, name: holds ? "close" : "open", from_s: before.until_s, until_s: from_s }];
    });
    this.closing = carry.closing;
    this.graspFromWorld = inverse(kinematics.worldFromGripper(carry.grasp));
    this.placed = carry.placed ? compose(kinematics.worldFromGripper(carry.placed), this.graspFromWorld) : null;
  }

  closingAt(time_s: number): number {
    const share = (stop: Mode | undefined): number => (stop ? stood(stop, time_s) / (stop.until_s - stop.from_s) : 0);
    return this.closing * share(this.stops[0]) * (1 - share(this.stops[1]));
  }

  /** Displacement of the object by this transfer, in the planning frame; null until it has moved. */
  motionAt(time_s: number, worldFromGripper: Pose): Pose | null {
    const [close, open] = this.stops;
    if (!close || time_s < close.until_s) return null;
    return open && this.placed && time_s >= open.from_s ? this.placed : compose(worldFromGripper, this.graspFromWorld);
  }
}

/** Names of all objects that any of several plans carries. */
export function carriedBy(plans: { carrying: Carrying | null }[]): ReadonlySet<string> {
  return new Set(plans.flatMap(({ carrying }) => [...(carrying?.objects ?? [])]));
}

function stood({ from_s, until_s }: Mode, time_s: number): number {
  return Math.min(Math.max(time_s - from_s, 0), until_s - from_s);
}
