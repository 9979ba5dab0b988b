import { CatmullRomCurve3, Group, Mesh, MeshLambertMaterial, TubeGeometry, Vector3 } from "three";
import type { Kinematics } from "./kinematics.ts";
import { indexAt, type ShownPlan } from "./trajectory.ts";

const RADIUS_M = 0.004;

/** Sides of the tube. */
const SIDES = 8;

/** Points along the tube; more cannot be seen. */
const MOST_STEPS = 400;

const AHEAD_OPACITY = 0.3;
const OTHER_OPACITY = 0.55;

/** The way of the gripper of a plan: what lies behind is solid, what lies ahead is faint. */
export class PathView {
  readonly group = new Group();
  readonly plan: ShownPlan;
  private readonly behind: Mesh<TubeGeometry, MeshLambertMaterial> | null = null;
  private readonly ahead: Mesh<TubeGeometry, MeshLambertMaterial> | null = null;
  private readonly steps: number = 0;
  /** How far along each instant is, from 0 to 1. */
  private readonly share: number[] = [];

  constructor(plan: ShownPlan, kinematics: Kinematics) {
    this.plan = plan;
    const points: Vector3[] = [];
    let way = 0;
    plan.trajectory.times_s.forEach((_, index) => {
      const [x, y, z] = kinematics.worldFromGripper(plan.trajectory.row(index));
      const point = new Vector3(x, y, z);
      const before = points.at(-1);
      const step = before ? before.distanceTo(point) : 1;
      if (before) way += step;
      this.share.push(way);
      // Where the gripper rests, the tube would have no direction.
      if (step > 1e-5) points.push(point);
    });
    this.share = this.share.map((length) => length / (way || 1));
    if (points.length < 2) return;
    this.steps = Math.min(2 * points.length, MOST_STEPS);
    const curve = new CatmullRomCurve3(points);
    const tube = (opacity: number): Mesh<TubeGeometry, MeshLambertMaterial> => {
      const material = new MeshLambertMaterial({ color: plan.colour, emissive: plan.colour, emissiveIntensity: 0.35 });
      material.opacity = opacity;
      material.transparent = opacity < 1;
      const mesh = new Mesh(new TubeGeometry(curve, this.steps, RADIUS_M, SIDES), material);
      this.group.add(mesh);
      return mesh;
    };
    this.behind = tube(1);
    this.ahead = tube(AHEAD_OPACITY);
    this.ahead.renderOrder = 1.5;
  }

  /** `isChosen`: whether this plan has the robot. */
  show(time_s: number, isChosen: boolean): void {
    if (!this.behind || !this.ahead) return;
    const { times_s } = this.plan.trajectory;
    const index = indexAt(times_s, time_s);
    const next = Math.min(index + 1, times_s.length - 1);
    const step_s = times_s[next] - times_s[index];
    const within = step_s > 0 ? Math.min(Math.max((time_s - times_s[index]) / step_s, 0), 1) : 0;
    const share = this.share[index] + within * (this.share[next] - this.share[index]);
    const corners = SIDES * 6;
    const passed = Math.round(share * this.steps);
    this.behind.geometry.setDrawRange(0, passed * corners);
    this.ahead.geometry.setDrawRange(passed * corners, (this.steps - passed) * corners);
    const opacity = isChosen ? 1 : OTHER_OPACITY;
    this.behind.material.opacity = opacity;
    this.behind.material.transparent = opacity < 1;
  }
}
