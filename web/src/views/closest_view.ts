import {
  BufferAttribute,
  BufferGeometry,
  DynamicDrawUsage,
  Group,
  LineSegments,
  LineBasicMaterial,
  Points,
  PointsMaterial,
} from "three";
import type { Closest } from "../motion/trajectory.ts";

/** The line between the closest points of robot and surroundings, drawn over everything. */
export class ClosestView {
  readonly group = new Group();
  private readonly ends = new BufferAttribute(new Float32Array(6), 3).setUsage(DynamicDrawUsage);

  constructor() {
    const geometry = new BufferGeometry().setAttribute("position", this.ends);
    const over = { color: COLOUR, depthTest: false, transparent: true };
    const line = new LineSegments(geometry, new LineBasicMaterial(over));
    const dots = new Points(geometry, round(new PointsMaterial({ ...over, size: 7, sizeAttenuation: false })));
    for (const part of [line, dots]) {
      part.frustumCulled = false;
      part.renderOrder = 5;
      this.group.add(part);
    }
    this.group.visible = false;
  }

  show(closest: Closest | null): void {
    // There is no line if two bodies touch without a common point.
    this.group.visible = closest !== null && closest.points.length === 6 && closest.points.every(Number.isFinite);
    if (!closest || !this.group.visible) return;
    this.ends.set(closest.points);
    this.ends.needsUpdate = true;
  }
}

const COLOUR = 0xe0342b;

/** Points are drawn as squares; this discards fragments outside the circle. */
function round(material: PointsMaterial): PointsMaterial {
  material.onBeforeCompile = (shader) => {
    shader.fragmentShader = shader.fragmentShader.replace(
      "void main() {",
      "void main() {\n  if (length(gl_PointCoord - 0.5) > 0.5) discard;",
    );
  };
  return material;
}
