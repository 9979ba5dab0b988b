import type { Kinematics } from "./kinematics.ts";
import type { Carry, Mode, Pose } from "./page_data.ts";
import { compose, inverse } from "./pose.ts";

/** What becomes of an object that a plan carries away, over time. */
export class Carrying {
  readonly object: string;
  readonly modes: Mode[];
  /** When the robot stands and its hand moves: it closes, and opens again if the object is put down. */
  readonly stops: Mode[];
  private readonly closing: number;
  private readonly graspFromWorld: Pose;
  private readonly placed: Pose | null;

  constructor(carry: Carry, kinematics: Kinematics) {
    this.object = carry.object;
    this.modes = carry.modes;
    this.stops = carry.modes.slice(1).flatMap(({ name, from_s }, index) => {
      const before = carry.modes[index];
      if (HOLDING.has(before.name) === HOLDING.has(name)) return [];
      return [{ name: HOLDING.has(name) ? "close" : "open", from_s: before.until_s, until_s: from_s }];
    });
    this.closing = carry.closing;
    this.graspFromWorld = inverse(kinematics.worldFromGripper(carry.grasp));
    this.placed = carry.placed ? compose(kinematics.worldFromGripper(carry.placed), this.graspFromWorld) : null;
  }

  /** How far the fingers have closed, from 0, open, to 1. */
  closingAt(time_s: number): number {
    const share = (stop: Mode | undefined): number => (stop ? stood(stop, time_s) / (stop.until_s - stop.from_s) : 0);
    return this.closing * share(this.stops[0]) * (1 - share(this.stops[1]));
  }

  /** So long the robot has stood while its hand moved, in seconds. */
  stoodUntil(time_s: number): number {
    return this.stops.reduce((sum, stop) => sum + stood(stop, time_s), 0);
  }

  /** By how much the object has moved, in the planning frame; null while it stands where it was. */
  movedAt(time_s: number, worldFromGripper: Pose): Pose | null {
    const [close, open] = this.stops;
    if (!close || time_s < close.until_s) return null;
    return open && this.placed && time_s >= open.from_s ? this.placed : compose(worldFromGripper, this.graspFromWorld);
  }

  /** What the robot does; "close" and "open" while its hand moves. */
  modeAt(time_s: number): Mode["name"] {
    const stop = this.stops.find(({ from_s, until_s }) => time_s > from_s && time_s < until_s);
    return (stop ?? this.modes.findLast(({ from_s }) => from_s <= time_s))?.name ?? "";
  }
}

/** What the robot does with the object in its hand. */
const HOLDING = new Set(["lift-off", "carry", "set-down"]);

function stood({ from_s, until_s }: Mode, time_s: number): number {
  return Math.min(Math.max(time_s - from_s, 0), until_s - from_s);
}
