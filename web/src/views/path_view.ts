import { CatmullRomCurve3, Group, Mesh, MeshLambertMaterial, TubeGeometry, Vector3 } from "three";
import { ofMode } from "../colours.ts";
import type { Kinematics } from "../motion/kinematics.ts";
import { indexAt, type ShownPlan } from "../motion/trajectory.ts";

const RADIUS_M = 0.004;

/** Larger, so that the way back stays visible where it retraces the way out. */
const IN_HAND_RADIUS_M = 1.2 * RADIUS_M;

/** Number of sides of the tube. */
const SIDES = 8;

/** Maximum number of points along the tube; more would not be visible. */
const MOST_STEPS = 400;

const AHEAD_OPACITY = 0.3;
const OTHER_OPACITY = 0.55;

/** Path of the gripper in one section per stage of the plan: travelled sections are solid, those ahead are faint. */
export class PathView {
  readonly group = new Group();
  readonly plan: ShownPlan;
  private readonly pieces: Piece[];

  constructor(plan: ShownPlan, kinematics: Kinematics) {
    this.plan = plan;
    const { times_s } = plan.trajectory;
    const empty = { holds: false, touches: false, leaves: false };
    const whole = { ...empty, from_s: 0, until_s: plan.trajectory.duration_s };
    this.pieces = (plan.carrying?.modes ?? [whole]).flatMap((mode) => {
      const { from_s, until_s, holds, leaves } = mode;
      const first = times_s.findIndex((time_s) => time_s >= from_s);
      const last = times_s.findLastIndex((time_s) => time_s <= until_s);
      const look = {
        colour: ofMode(plan.colour, mode),
        radius_m: holds || leaves ? IN_HAND_RADIUS_M : RADIUS_M,
      };
      return first < 0 ? [] : (Piece.of(plan, kinematics, { first, last }, look) ?? []);
    });
    for (const piece of this.pieces) this.group.add(piece.behind, piece.ahead);
  }

  /** `isChosen`: whether this plan moves the robot. */
  show(time_s: number, isChosen: boolean): void {
    for (const piece of this.pieces) piece.show(this.plan.trajectory.times_s, time_s, isChosen ? 1 : OTHER_OPACITY);
  }
}

interface Look {
  /** `#rrggbb` */
  colour: string;
  radius_m: number;
}

type Tube = Mesh<TubeGeometry, MeshLambertMaterial>;

/** A section of the path with one colour. */
class Piece {
  readonly behind: Tube;
  readonly ahead: Tube;
  private readonly steps: number;
  /** Index of its first instant. */
  private readonly first: number;
  /** Fraction of the section's length at each instant, from 0 to 1. */
  private readonly share: number[];

  private constructor(points: Vector3[], first: number, share: number[], { colour, radius_m }: Look) {
    this.first = first;
    this.share = share;
    this.steps = Math.min(2 * points.length, MOST_STEPS);
    const curve = new CatmullRomCurve3(points);
    const tube = (opacity: number): Tube => {
      const material = new MeshLambertMaterial({ color: colour, emissive: colour, emissiveIntensity: 0.35 });
      material.opacity = opacity;
      material.transparent = opacity < 1;
      return new Mesh(new TubeGeometry(curve, this.steps, radius_m, SIDES), material);
    };
    this.behind = tube(1);
    this.ahead = tube(AHEAD_OPACITY);
    this.ahead.renderOrder = 1.5;
  }

  /** Null if the gripper rests. */
  static of(
    { trajectory }: ShownPlan,
    kinematics: Kinematics,
    { first, last }: { first: number; last: number },
    look: Look,
  ): Piece | null {
    const points: Vector3[] = [];
    const travelled: number[] = [];
    let way = 0;
    for (let index = first; index <= last; index += 1) {
      const [x, y, z] = kinematics.worldFromGripper(trajectory.row(index));
      const point = new Vector3(x, y, z);
      const before = points.at(-1);
      const step = before ? before.distanceTo(point) : 1;
      if (before) way += step;
      travelled.push(way);
      // A tube has no direction where the gripper rests.
      if (step > 1e-5) points.push(point);
    }
    if (points.length < 2) return null;
    return new Piece(points, first, travelled.map((length) => length / way), look);
  }

  show(times_s: Float64Array, time_s: number, opacity: number): void {
    const place = indexAt(times_s, time_s) - this.first;
    const next = Math.min(place + 1, this.share.length - 1);
    let share = place < 0 ? 0 : 1;
    if (place >= 0 && place < this.share.length) {
      const [begin_s, end_s] = [times_s[this.first + place], times_s[this.first + next]];
      const within = end_s > begin_s ? Math.min(Math.max((time_s - begin_s) / (end_s - begin_s), 0), 1) : 0;
      share = this.share[place] + within * (this.share[next] - this.share[place]);
    }
    const corners = SIDES * 6;
    const passed = Math.round(share * this.steps);
    this.behind.geometry.setDrawRange(0, passed * corners);
    this.ahead.geometry.setDrawRange(passed * corners, (this.steps - passed) * corners);
    this.behind.material.opacity = opacity;
    this.behind.material.transparent = opacity < 1;
  }
}
