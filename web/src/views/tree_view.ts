import { BufferAttribute, BufferGeometry, Color, Group, LineBasicMaterial, LineSegments } from "three";
import { ofTree } from "../colours.ts";
import { floats32, unsigned32 } from "../data/numbers.ts";
import type { SearchTree } from "../data/page_data.ts";
import type { Stage } from "../stage.ts";
import { TreePicture } from "./tree_picture.ts";

/** Opacity of a line in a small tree, and in one whose lines overlap. */
const OPACITY = 0.7;
const DENSE_OPACITY = 0.16;
const DENSE_NODES = 50_000;

/** Opacity of a tree shown as a picture, which covers each point only once: the robot stays visible through it. */
const PICTURE_OPACITY = 0.7;
const DENSE_PICTURE_OPACITY = 0.36;

/** Number of lines drawn while the camera moves on a slow machine. */
const SPARSE_NODES = 10_000;

const ORDER = 1.2;

/** The trees of a search, one line from each node to its parent: one draw call, and growth costs nothing. Without a
 * graphics card it is a picture while the camera rests, and an even subset of the lines while it moves. */
export class TreeView {
  readonly group = new Group();
  readonly count: number;
  /** Number of nodes of each tree. */
  readonly sizes = new Map<number, number>();
  /** Number of shown nodes, in the order in which they were added. */
  shown: number;
  private readonly lines: LineSegments<BufferGeometry, LineBasicMaterial>;
  private readonly slow: { picture: TreePicture; sparse: LineSegments; stride: number } | null = null;

  constructor(tree: SearchTree, stage: Stage) {
    const [positions, parents, trees] = [floats32(tree.positions), unsigned32(tree.parents), unsigned32(tree.trees)];
    this.count = this.shown = parents.length;
    if (positions.length !== 3 * this.count || trees.length !== this.count) {
      throw new Error(`a search tree of ${this.count} nodes with ${positions.length} coordinates`);
    }
    for (const which of trees) this.sizes.set(which, (this.sizes.get(which) ?? 0) + 1);
    const geometry = new BufferGeometry();
    geometry.setAttribute("position", new BufferAttribute(ends(positions, parents), 3));
    geometry.setAttribute("color", new BufferAttribute(paint(trees), 3, true));
    const dense = Math.min(this.count / DENSE_NODES, 1);
    const between = (sparse: number, full: number): number => sparse + (full - sparse) * dense;
    const opacity = between(OPACITY, DENSE_OPACITY);
    this.lines = line(
      geometry,
      new LineBasicMaterial({ vertexColors: true, transparent: true, opacity, depthWrite: false }),
    );
    this.group.add(this.lines);
    if (!stage.isSlow) return;
    // Lines in the picture hide each other; the picture as a whole is translucent.
    Object.assign(this.lines.material, { transparent: false, opacity: 1, depthWrite: true });
    const stride = Math.max(Math.ceil(this.count / SPARSE_NODES), 1);
    const share = new BufferGeometry().setAttribute("position", geometry.getAttribute("position"));
    share.setAttribute("color", geometry.getAttribute("color"));
    share.setIndex(
      Array.from({ length: Math.floor(this.count / stride) }, (_, i) => [2 * i * stride, 2 * i * stride + 1]).flat(),
    );
    const sparse = line(
      share,
      new LineBasicMaterial({ vertexColors: true, transparent: true, opacity: 0.6, depthWrite: false }),
    );
    this.slow = { picture: new TreePicture(between(PICTURE_OPACITY, DENSE_PICTURE_OPACITY)), sparse, stride };
    this.slow.picture.quad.renderOrder = ORDER;
    this.group.add(this.slow.picture.quad, sparse);
    stage.onBeforeDraw(() => this.choose(stage));
  }

  show(nodes: number): void {
    this.shown = Math.min(Math.max(Math.round(nodes), 0), this.count);
    this.lines.geometry.setDrawRange(0, 2 * this.shown);
    this.slow?.sparse.geometry.setDrawRange(0, 2 * Math.floor(this.shown / this.slow.stride));
  }

  /** Shows the picture if the camera rests, else a subset of the lines. */
  private choose(stage: Stage): void {
    if (!this.slow || !this.group.visible) return;
    const { picture, sparse } = this.slow;
    stage.camera.updateMatrixWorld();
    const isResting = picture.isResting(stage.camera, stage.renderer);
    this.lines.visible = false;
    picture.quad.visible = isResting;
    sparse.visible = !isResting;
    if (isResting) picture.draw(this.lines, this.shown, stage.camera, stage.renderer);
    else stage.invalidate();
  }
}

function line<Look extends LineBasicMaterial>(
  geometry: BufferGeometry,
  look: Look,
): LineSegments<BufferGeometry, Look> {
  const lines = new LineSegments(geometry, look);
  lines.frustumCulled = false;
  lines.renderOrder = ORDER;
  return lines;
}

/** Positions of parent and node, for each node. The line of a root has no length and is invisible. */
function ends(positions: Float32Array, parents: Uint32Array): Float32Array {
  const both = new Float32Array(6 * parents.length);
  parents.forEach((parent, node) => {
    both.set(positions.subarray(3 * parent, 3 * parent + 3), 6 * node);
    both.set(positions.subarray(3 * node, 3 * node + 3), 6 * node + 3);
  });
  return both;
}

/** Colour of the node's tree for both ends of each line. */
export function paint(trees: Uint32Array): Uint8Array {
  const palette = new Map<number, number[]>();
  const both = new Uint8Array(6 * trees.length);
  trees.forEach((tree, node) => {
    let colour = palette.get(tree);
    if (!colour) {
      // Vertex colours are linear.
      const { r, g, b } = new Color(ofTree(tree));
      colour = [r, g, b, r, g, b].map((value) => Math.round(255 * value));
      palette.set(tree, colour);
    }
    both.set(colour, 6 * node);
  });
  return both;
}
