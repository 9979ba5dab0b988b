import type { Kinematics } from "./kinematics.ts";
import type { Carry, Mode, Node, Pose } from "../data/page_data.ts";
import { compose, inverse } from "./pose.ts";

/** By how much each body has moved that does not stand where the scenario has it, by name, in the planning frame. */
export type Moved = ReadonlyMap<string, Pose>;

/** What the robot does from when to when; "close" and "open" while it stands and its hand moves. */
export interface Stretch extends Mode {
  /** Which of the objects that its plan carries this belongs to. */
  step: number;
}

/** What becomes of the objects that a plan carries away, one after the other, over time. */
export class Carrying {
  /** What the robot does, one after the other, but for when its hand moves. */
  readonly modes: Stretch[];
  /** The same with when the hand moves. */
  readonly stretches: Stretch[];
  /** What is carried, by name. */
  readonly objects: ReadonlySet<string>;
  readonly stepCount: number;
  private readonly stops: Stretch[];
  private readonly transfers: Transfer[];

  /** What no node is called is the target. */
  constructor(carries: Carry[], kinematics: Kinematics, nodes: Node[]) {
    const target = nodes.find(({ role }) => role === "target")?.name ?? "";
    this.transfers = carries.map((carry) => {
      const isThere = nodes.some(({ name, role }) => name === carry.object && role !== "link");
      return new Transfer(carry, isThere ? carry.object : target, kinematics);
    });
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

  /** How far the fingers have closed, from 0, open, to 1. */
  closingAt(time_s: number): number {
    return Math.max(...this.transfers.map((transfer) => transfer.closingAt(time_s)));
  }

  /** So long the robot has stood while its hand moved, in seconds. */
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

/** One object that is taken, and perhaps put down. */
class Transfer {
  readonly object: string;
  readonly modes: Mode[];
  /** When the robot stands and its hand moves: it closes, and opens again if the object is put down. */
  readonly stops: Mode[];
  private readonly closing: number;
  private readonly graspFromWorld: Pose;
  private readonly placed: Pose | null;

  constructor(carry: Carry, object: string, kinematics: Kinematics) {
    this.object = object;
    this.modes = carry.modes;
    // Postures are judged as along the segment before.
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

  /** By how much this has moved the object, in the planning frame; null as long as it has not. */
  motionAt(time_s: number, worldFromGripper: Pose): Pose | null {
    const [close, open] = this.stops;
    if (!close || time_s < close.until_s) return null;
    return open && this.placed && time_s >= open.from_s ? this.placed : compose(worldFromGripper, this.graspFromWorld);
  }
}

/** What any of several plans carries, by name. */
export function carriedBy(plans: { carrying: Carrying | null }[]): ReadonlySet<string> {
  return new Set(plans.flatMap(({ carrying }) => [...(carrying?.objects ?? [])]));
}

function stood({ from_s, until_s }: Mode, time_s: number): number {
  return Math.min(Math.max(time_s - from_s, 0), until_s - from_s);
}
