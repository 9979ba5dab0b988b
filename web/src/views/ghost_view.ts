import { type BufferGeometry, Group, type Vector3 } from "three";
import { carriedBy } from "../motion/carrying.ts";
import type { Kinematics } from "../motion/kinematics.ts";
import type { MeshGeometries } from "./mesh_geometry.ts";
import type { Node, Pose } from "../data/page_data.ts";
import { distanceBetween } from "../motion/pose.ts";
import { type Movers, postureAlong } from "../motion/posture.ts";
import { RobotCopy, robotGeometry } from "./robot_copy.ts";
import type { ShownPlan } from "../motion/trajectory.ts";

const GHOST = "#468ad0";
const GHOST_OPACITY = 0.3;
const GHOST_RIM = 0.9;

/** Appearance of the robots of plans that are not selected. */
const OTHER_OPACITY = 0.55;
const OTHER_RIM = 0.5;

/** A copy is shown if one of its joints differs from the robot's by more than this, in metres or radians. */
const AWAY = 0.08;

/** Additional difference at which the robot of another plan has its full opacity. */
const FULLY_AWAY = 0.4;

/** Translucent robots with the objects that they carry: along the selected plan's path, and those of other plans. */
export class GhostView {
  readonly ghosts = new Group();
  readonly others = new Group();
  private readonly onWay: Ghost[] = [];
  private readonly ofPlans = new Map<number, Ghost>();
  private places: { copy: RobotCopy; at: Pose }[] = [];
  private readonly movers: Movers;
  /** Indices of the copied nodes, in order: the links, and carried objects. */
  private readonly copied: number[];
  private readonly geometry: () => BufferGeometry;
  private known: BufferGeometry | null = null;

  constructor(movers: Movers, geometries: MeshGeometries) {
    this.movers = movers;
    const carried = carriedBy(movers.plans);
    const isCopied = ({ role, name }: Node): boolean => role === "link" || carried.has(name);
    this.copied = movers.nodes.flatMap((node, index) => (isCopied(node) ? [index] : []));
    // Evaluated when the first copy is needed.
    this.geometry = () => robotGeometry(this.copied.map((index) => movers.nodes[index]), geometries);
  }

  /** Shows `count` ghosts of a plan, equally spaced along the path of the gripper. */
  showWay(plan: ShownPlan | null, count: number): void {
    const instants = plan && count > 0 ? ghostInstants(plan, this.movers.kinematics, count) : [];
    while (this.onWay.length < instants.length) {
      const copy = this.copy(GHOST, GHOST_OPACITY, GHOST_RIM);
      this.onWay.push({ copy, q: [] });
      this.ghosts.add(copy.group);
    }
    this.onWay.forEach((ghost, index) => {
      ghost.q = [];
      if (plan && index < instants.length) this.place(ghost, plan, plan.trajectory.times_s[instants[index]]);
    });
  }

  /** Hides copies at the robot's own posture: at the start, common to all plans, only the robot itself is visible. */
  makeWay(q: ArrayLike<number>): void {
    const away = (copy: number[]): number => Math.max(...copy.map((value, i) => Math.abs(value - q[i])));
    for (const ghost of this.onWay) ghost.copy.group.visible = ghost.q.length > 0 && away(ghost.q) > AWAY;
    for (const { copy, q: other } of this.ofPlans.values()) {
      const share = (away(other) - AWAY) / FULLY_AWAY;
      copy.group.visible = other.length > 0 && share > 0;
      copy.setOpacity(OTHER_OPACITY * Math.min(share, 1));
    }
  }

  /** Shows the robots of other plans at a time; `makeWay` sets their opacity. */
  showOthers(plans: ShownPlan[], time_s: number): void {
    for (const other of this.ofPlans.values()) other.q = [];
    for (const plan of plans) {
      if (plan.trajectory.isEmpty) continue;
      let other = this.ofPlans.get(plan.index);
      if (!other) {
        other = { copy: this.copy(plan.colour, OTHER_OPACITY, OTHER_RIM), q: [] };
        this.ofPlans.set(plan.index, other);
        this.others.add(other.copy.group);
      }
      this.place(other, plan, time_s);
    }
  }

  /** Draws nearer copies over farther ones. */
  sort(eye: Vector3): void {
    const from: Pose = [eye.x, eye.y, eye.z, 0, 0, 0, 1];
    this.places.sort((a, b) => distanceBetween(b.at, from) - distanceBetween(a.at, from));
    this.places.forEach(({ copy }, order) => copy.setOrder(order));
  }

  private place(ghost: Ghost, plan: ShownPlan, time_s: number): void {
    const { q, worldFromNodes, worldFromGripper, moved } = postureAlong(plan, time_s, this.movers);
    const { copy } = ghost;
    ghost.q = q;
    // Objects at their poses in the scenario need no ghost.
    const isThere = ({ role, name }: Node): boolean => role === "link" || moved.has(name);
    copy.pose(this.copied.map((node) => (isThere(this.movers.nodes[node]) ? worldFromNodes[node] : null)));
    const at = worldFromGripper ?? worldFromNodes[0];
    const known = this.places.find((place) => place.copy === copy);
    if (known) known.at = at;
    else this.places.push({ copy, at });
  }

  private copy(colour: string, opacity: number, rim: number): RobotCopy {
    this.known ??= this.geometry();
    return new RobotCopy(this.known, this.copied.length, { colour, opacity, rim });
  }
}

/** A copy and its configuration; hidden if the configuration is empty. */
interface Ghost {
  copy: RobotCopy;
  q: number[];
}

/** Rows of a trajectory from start to end, equally spaced along the path of the gripper. */
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
