import type { Kinematics } from "./kinematics.ts";
import type { Carry, Mode, Pose } from "./page_data.ts";
import { compose, inverse } from "./pose.ts";

/** What becomes of an object that a plan carries away, over time. */
export class Carrying {
  readonly object: string;
  readonly modes: Mode[];
  private readonly closing: number;
  private readonly graspFromWorld: Pose;

  constructor(carry: Carry, kinematics: Kinematics) {
    this.object = carry.object;
    this.modes = carry.modes;
    this.closing = carry.closing;
    this.graspFromWorld = inverse(kinematics.worldFromGripper(carry.grasp));
  }

  /** The hand begins to close where the way to the grasp ends, and has closed where the way on begins. */
  get closes_s(): { from: number; until: number } {
    return { from: this.modes[0].until_s, until: this.modes[1].from_s };
  }

  /** How far the fingers have closed, from 0, open, to 1. */
  closingAt(time_s: number): number {
    const { from, until } = this.closes_s;
    return (this.closing * this.stoodUntil(time_s)) / (until - from);
  }

  /** So long the robot has stood while its hand closed, in seconds. */
  stoodUntil(time_s: number): number {
    const { from, until } = this.closes_s;
    return Math.min(Math.max(time_s - from, 0), until - from);
  }

  /** By how much the object has moved, in the planning frame; null while it stands. */
  movedAt(time_s: number, worldFromGripper: Pose): Pose | null {
    return time_s < this.closes_s.until ? null : compose(worldFromGripper, this.graspFromWorld);
  }

  /** What the robot does; "close" while its hand closes. */
  modeAt(time_s: number): Mode["name"] {
    const { from, until } = this.closes_s;
    if (time_s > from && time_s < until) return "close";
    return this.modes.findLast(({ from_s }) => from_s <= time_s)?.name ?? "";
  }
}
