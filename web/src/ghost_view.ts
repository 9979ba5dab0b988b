import { type BufferGeometry, Group, type Vector3 } from "three";
import type { Kinematics } from "./kinematics.ts";
import type { Pose } from "./page_data.ts";
import { distanceBetween } from "./pose.ts";
import { RobotCopy } from "./robot_copy.ts";
import type { ShownPlan } from "./trajectory.ts";

const GHOST = "#468ad0";
const GHOST_OPACITY = 0.3;
const GHOST_RIM = 0.9;

/** A robot beside the one that is looked at. */
const OTHER_OPACITY = 0.55;
const OTHER_RIM = 0.5;

/** A copy is shown if one of its joints is so far away from the robot's, in metres or radians. */
const AWAY = 0.08;

/** The robot of another plan is seen fully where it is so much farther away. */
const FULLY_AWAY = 0.4;

/** Translucent robots: on the way of the plan that is looked at, and those of the other plans. */
export class GhostView {
  readonly ghosts = new Group();
  readonly others = new Group();
  private readonly onWay: { copy: RobotCopy; q: Float64Array }[] = [];
  private readonly ofPlans = new Map<number, { copy: RobotCopy; q: Float64Array }>();
  private places: { copy: RobotCopy; at: Pose }[] = [];
  private readonly kinematics: Kinematics;
  private readonly geometry: () => BufferGeometry;
  private known: BufferGeometry | null = null;

  /** `geometry` is asked for when the first copy is wanted. */
  constructor(kinematics: Kinematics, geometry: () => BufferGeometry) {
    this.kinematics = kinematics;
    this.geometry = geometry;
  }

  /** `count` ghosts on the way of a plan, equally far apart along the way of the gripper. */
  showWay(plan: ShownPlan | null, count: number): void {
    const instants = plan && count > 0 ? ghostInstants(plan, this.kinematics, count) : [];
    while (this.onWay.length < instants.length) {
      const copy = this.copy(GHOST, GHOST_OPACITY, GHOST_RIM);
      this.onWay.push({ copy, q: new Float64Array() });
      this.ghosts.add(copy.group);
    }
    this.onWay.forEach((ghost, index) => {
      ghost.q = plan && index < instants.length ? plan.trajectory.row(instants[index]) : new Float64Array();
      if (ghost.q.length > 0) this.place(ghost.copy, ghost.q);
    });
  }

  /** No copy stands where the robot is: at the start, where all plans begin, one sees the robot alone. */
  makeWay(q: ArrayLike<number>): void {
    const away = (copy: Float64Array): number => Math.max(...Array.from(copy, (value, i) => Math.abs(value - q[i])));
    for (const ghost of this.onWay) ghost.copy.group.visible = ghost.q.length > 0 && away(ghost.q) > AWAY;
    for (const { copy, q: other } of this.ofPlans.values()) {
      const share = (away(other) - AWAY) / FULLY_AWAY;
      copy.group.visible = other.length > 0 && share > 0;
      copy.setOpacity(OTHER_OPACITY * Math.min(share, 1));
    }
  }

  /** The robots of plans beside the one that is looked at, at a time; `makeWay` says how much is seen of them. */
  showOthers(plans: ShownPlan[], time_s: number): void {
    for (const other of this.ofPlans.values()) other.q = new Float64Array();
    for (const plan of plans) {
      if (plan.trajectory.isEmpty) continue;
      let other = this.ofPlans.get(plan.index);
      if (!other) {
        other = { copy: this.copy(plan.colour, OTHER_OPACITY, OTHER_RIM), q: new Float64Array() };
        this.ofPlans.set(plan.index, other);
        this.others.add(other.copy.group);
      }
      other.q = plan.trajectory.at(time_s);
      this.place(other.copy, other.q);
    }
  }

  /** Nearer copies over farther ones. */
  sort(eye: Vector3): void {
    const from: Pose = [eye.x, eye.y, eye.z, 0, 0, 0, 1];
    this.places.sort((a, b) => distanceBetween(b.at, from) - distanceBetween(a.at, from));
    this.places.forEach(({ copy }, order) => copy.setOrder(order));
  }

  private place(copy: RobotCopy, q: Float64Array): void {
    const poses = this.kinematics.worldFromLinks(q);
    copy.pose(poses);
    const at = poses[this.kinematics.robot.tip];
    const known = this.places.find((place) => place.copy === copy);
    if (known) known.at = at;
    else this.places.push({ copy, at });
  }

  private copy(colour: string, opacity: number, rim: number): RobotCopy {
    this.known ??= this.geometry();
    return new RobotCopy(this.known, this.kinematics.robot.links.length, { colour, opacity, rim });
  }
}

/** Rows of a trajectory: from the start on, equally far apart along the way of the gripper, the end among them. */
export function ghostInstants(plan: ShownPlan, kinematics: Kinematics, count: number): number[] {
  const { trajectory } = plan;
  const travelled: number[] = [];
  let before: Pose | null = null;
  trajectory.times_s.forEach((_, index) => {
    const at = kinematics.worldFromGripper(trajectory.row(index));
    travelled.push((travelled.at(-1) ?? 0) + (before ? distanceBetween(before, at) : 0));
    before = at;
  });
  const whole = travelled.at(-1) ?? 0;
  const steps = Math.max(count - 1, 1);
  const chosen = Array.from({ length: count }, (_, ghost) =>
    travelled.findIndex((way) => way >= (ghost / steps) * whole * (1 - 1e-9)),
  );
  return [...new Set(chosen.filter((index) => index >= 0))];
}
