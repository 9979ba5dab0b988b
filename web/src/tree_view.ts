import { BufferAttribute, BufferGeometry, Color, Group, LineBasicMaterial, LineSegments } from "three";
import { ofTree } from "./colours.ts";
import { floats32, unsigned32 } from "./numbers.ts";
import type { SearchTree } from "./page_data.ts";

/** Of a line where a tree is small, and where its lines lie over each other. */
const OPACITY = 0.7;
const DENSE_OPACITY = 0.28;
const DENSE_NODES = 50_000;

/** The trees of a search, a line from each node to its parent: one draw call, and growth costs nothing. */
export class TreeView {
  readonly group = new Group();
  readonly count: number;
  /** How many nodes each tree has. */
  readonly sizes = new Map<number, number>();
  /** How many nodes are shown, in the order in which they were added. */
  shown: number;
  private readonly lines: LineSegments<BufferGeometry, LineBasicMaterial>;

  constructor(tree: SearchTree) {
    const [positions, parents, trees] = [floats32(tree.positions), unsigned32(tree.parents), unsigned32(tree.trees)];
    this.count = this.shown = parents.length;
    if (positions.length !== 3 * this.count || trees.length !== this.count) {
      throw new Error(`a search tree of ${this.count} nodes with ${positions.length} coordinates`);
    }
    const ends = new Float32Array(6 * this.count);
    const paint = new Uint8Array(6 * this.count);
    const palette = new Map<number, [number, number, number]>();
    for (let node = 0; node < this.count; node += 1) {
      // A root's line has no length: nothing is seen of it.
      const parent = parents[node];
      const which = trees[node];
      let colour = palette.get(which);
      if (!colour) palette.set(which, (colour = lightOf(ofTree(which))));
      for (let i = 0; i < 3; i += 1) {
        ends[6 * node + i] = positions[3 * parent + i];
        ends[6 * node + 3 + i] = positions[3 * node + i];
        paint[6 * node + i] = paint[6 * node + 3 + i] = colour[i];
      }
      this.sizes.set(which, (this.sizes.get(which) ?? 0) + 1);
    }
    const geometry = new BufferGeometry();
    geometry.setAttribute("position", new BufferAttribute(ends, 3));
    geometry.setAttribute("color", new BufferAttribute(paint, 3, true));
    const dense = Math.min(this.count / DENSE_NODES, 1);
    const opacity = OPACITY + (DENSE_OPACITY - OPACITY) * dense;
    const material = new LineBasicMaterial({ vertexColors: true, transparent: true, opacity, depthWrite: false });
    this.lines = new LineSegments(geometry, material);
    this.lines.frustumCulled = false;
    this.lines.renderOrder = 1.2;
    this.group.add(this.lines);
  }

  show(nodes: number): void {
    this.shown = Math.min(Math.max(Math.round(nodes), 0), this.count);
    this.lines.geometry.setDrawRange(0, 2 * this.shown);
  }
}

/** A colour as amounts of light, as corners of a geometry have it. */
function lightOf(colour: string): [number, number, number] {
  const { r, g, b } = new Color(colour);
  return [r, g, b].map((value) => Math.round(255 * value)) as [number, number, number];
}
