import { Color, Group, InstancedMesh, Matrix4, MeshLambertMaterial } from "three";
import * as colours from "../colours.ts";
import { RODS, gripperGeometry } from "./gripper_glyph.ts";
import { setMatrix } from "./mesh_geometry.ts";
import type { Grasp, Point } from "../data/page_data.ts";
import { transformed } from "../motion/pose.ts";
import type { Lens } from "../stage.ts";
import type { ShownPlan } from "../motion/trajectory.ts";
import type { GraspColour } from "../data/view_state.ts";

/** Thickness of up to `FEW` grippers; more are drawn thinner, so that the object stays visible. */
const THICKNESS_M = 0.0026;
const THIN_M = 0.0014;
const FEW = 40;
const STRONG_THICKNESS_M = 0.005;

/** Share of its colour that a grasp keeps when another reason is highlighted. */
const DIMMED = 0.22;

/** Grasps as small grippers in one draw call, and the highlighted few in another. */
export class GraspView {
  readonly group = new Group();
  private readonly grasps: Grasp[];
  /** The grasps by their index in the scenario. */
  private readonly byIndex: ReadonlyMap<number, Grasp>;
  private readonly plain: InstancedMesh;
  private readonly strong: InstancedMesh;
  private readonly matrix = new Matrix4();
  private readonly colour = new Color();
  /** End points of the rods in the planning frame, six numbers each. */
  private readonly rods: Float64Array;
  /** List positions of the shown grasps. */
  private places: number[] = [];

  constructor(grasps: Grasp[], plans: number) {
    this.grasps = grasps;
    this.byIndex = new Map(grasps.map((grasp) => [grasp.index, grasp]));
    const material = (): MeshLambertMaterial => new MeshLambertMaterial({ emissive: 0xffffff, emissiveIntensity: 0 });
    this.plain = new InstancedMesh(gripperGeometry(THICKNESS_M), material(), grasps.length);
    // One for each plan, and one for the grasp under the pointer.
    this.strong = new InstancedMesh(gripperGeometry(STRONG_THICKNESS_M), material(), plans + 1);
    this.strong.count = 0;
    for (const mesh of [this.plain, this.strong]) {
      mesh.frustumCulled = false;
      this.group.add(mesh);
    }
    this.rods = new Float64Array(grasps.length * RODS.length * 6);
    grasps.forEach((grasp, index) => {
      RODS.forEach(([from, to], rod) => {
        const points = [from, to].flatMap((point) => transformed(grasp.world_from_gripper, point));
        this.rods.set(points, (index * RODS.length + rod) * 6);
      });
    });
  }

  /** Shows the grasps at these list positions; `paint` colours them. */
  show(places: number[]): void {
    if (places.length === this.places.length && places.every((place, i) => place === this.places[i])) return;
    this.places = places;
    this.plain.count = places.length;
    places.forEach((place, i) => {
      this.plain.setMatrixAt(i, setMatrix(this.matrix, this.grasps[place].world_from_gripper));
    });
    this.plain.instanceMatrix.needsUpdate = true;
    this.plain.geometry.dispose();
    this.plain.geometry = gripperGeometry(
      Math.max(THICKNESS_M * Math.sqrt(Math.min(FEW / Math.max(places.length, 1), 1)), THIN_M),
    );
  }

  /** Number of shown grasps. */
  get shown(): number {
    return this.places.length;
  }

  /** Colours the shown grasps; `only`: the highlighted reason, grasps with others are dimmed. */
  paint(by: GraspColour, plan: ShownPlan | null, reasons: string[], only: string | null, page: string): void {
    const background = new Color(page);
    const order = new Map(reasons.map((reason, index) => [reason, index]));
    this.places.forEach((place, index) => {
      const grasp = this.grasps[place];
      const reason = plan?.reasons.get(grasp.index) ?? null;
      const name =
        by === "score"
          ? colours.ofScore(grasp.score)
          : by === "ik"
            ? colours.ofIk(grasp.ik)
            : colours.ofReason(reason === null ? -1 : (order.get(reason) ?? -1));
      this.colour.set(name);
      if (only !== null && reason !== only) this.colour.lerp(background, 1 - DIMMED);
      this.plain.setColorAt(index, this.colour);
    });
    if (this.plain.instanceColor) this.plain.instanceColor.needsUpdate = true;
  }

  /** Highlights the grasps at which plans end, and the one under the pointer in a colour of its own. */
  emphasise(plans: ShownPlan[], pointed: number | null, pointedColour: string): void {
    const strong = plans.flatMap(({ plan, colour }) => (plan.grasp === null ? [] : [{ grasp: plan.grasp, colour }]));
    if (pointed !== null) strong.push({ grasp: pointed, colour: pointedColour });
    this.strong.count = 0;
    for (const { grasp, colour } of strong) {
      const found = this.byIndex.get(grasp);
      if (!found) continue;
      this.strong.setMatrixAt(this.strong.count, setMatrix(this.matrix, found.world_from_gripper));
      this.strong.setColorAt(this.strong.count, this.colour.set(colour));
      this.strong.count += 1;
    }
    this.strong.instanceMatrix.needsUpdate = true;
    if (this.strong.instanceColor) this.strong.instanceColor.needsUpdate = true;
  }

  /** Index (in the page's list) of the grasp nearest to a screen position, at most `reach` points away; of equally near
   * ones the one in front. Measuring from rods, not triangles, lets a finger hit grippers two points wide. */
  at(x: number, y: number, reach: number, lens: Lens): number | null {
    let best: { index: number; away: number; depth: number } | null = null;
    const rods = this.places.flatMap((place) => RODS.map((_, rod) => ({ place, rod: place * RODS.length + rod })));
    for (const { place, rod } of rods) {
      const points = this.rods.subarray(6 * rod, 6 * rod + 6);
      const [a, b] = [lens([points[0], points[1], points[2]]), lens([points[3], points[4], points[5]])];
      if (a.depth > 1 || b.depth > 1) continue;
      // Rounded to whole points: smaller differences do not matter for a pointer.
      const away = Math.round(distanceToSegment(x, y, a, b));
      if (away > reach) continue;
      const depth = Math.min(a.depth, b.depth);
      if (!best || away < best.away || (away === best.away && depth < best.depth)) {
        best = { index: place, away, depth };
      }
    }
    return best?.index ?? null;
  }

  /** The midpoint of a small gripper's palm. */
  middle(index: number): Point {
    const palm = this.rods.subarray((index * RODS.length + 2) * 6);
    return [(palm[0] + palm[3]) / 2, (palm[1] + palm[4]) / 2, (palm[2] + palm[5]) / 2];
  }
}

function distanceToSegment(x: number, y: number, a: { x: number; y: number }, b: { x: number; y: number }): number {
  const [dx, dy] = [b.x - a.x, b.y - a.y];
  const share = Math.min(Math.max(((x - a.x) * dx + (y - a.y) * dy) / (dx * dx + dy * dy || 1), 0), 1);
  return Math.hypot(x - a.x - share * dx, y - a.y - share * dy);
}
