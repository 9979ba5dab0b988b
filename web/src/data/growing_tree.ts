import { BufferAttribute, BufferGeometry, LineBasicMaterial, LineSegments } from "three";
import { floats32, unsigned32 } from "./numbers.ts";
import type { SearchTree } from "./page_data.ts";
import { paint } from "../views/tree_view.ts";

/** New nodes of a search, as the server returns them (`tree?search=S&after=N`). */
export interface NewNodes extends SearchTree {
  search: number;
  /** Number of nodes before these. */
  from: number;
}

/** Initial capacity in nodes; it doubles when exceeded. */
const FIRST_NODES = 1024;

const OPACITY = 0.6;
const ORDER = 1.2;

/** The trees of a search under way in another process, one line from each node to its parent: one draw call. */
export class GrowingTree {
  readonly lines: LineSegments<BufferGeometry, LineBasicMaterial>;
  /** Number of the search on the server; null before the first. */
  search: number | null = null;
  count = 0;
  private positions = new Float32Array(3 * FIRST_NODES);
  private isAsked = true;

  constructor() {
    const look = { vertexColors: true, transparent: true, opacity: OPACITY, depthWrite: false };
    this.lines = new LineSegments(new BufferGeometry(), new LineBasicMaterial(look));
    this.lines.frustumCulled = false;
    this.lines.renderOrder = ORDER;
    this.makeRoom(FIRST_NODES);
    this.begin(null);
  }

  /** Forgets all nodes and expects those of another search; null: of none. */
  begin(search: number | null): void {
    this.search = search;
    this.count = 0;
    this.lines.geometry.setDrawRange(0, 0);
    this.show(this.isAsked);
  }

  /** Shows or hides the lines; hidden while there are no nodes. */
  show(isAsked: boolean): void {
    this.isAsked = isAsked;
    this.lines.visible = isAsked && this.count > 0;
  }

  add({ search, from, positions, parents, trees }: NewNodes): void {
    // The answer belongs to an earlier request or search.
    if (search !== this.search || from !== this.count) return;
    const [points, above, of] = [floats32(positions), unsigned32(parents), unsigned32(trees)];
    const count = from + above.length;
    this.makeRoom(count);
    this.positions.set(points, 3 * from);
    const ends = this.attribute("position");
    above.forEach((parent, place) => {
      const node = from + place;
      ends.array.set(this.positions.subarray(3 * parent, 3 * parent + 3), 6 * node);
      ends.array.set(this.positions.subarray(3 * node, 3 * node + 3), 6 * node + 3);
    });
    const colours = this.attribute("color");
    colours.array.set(paint(of), 6 * from);
    for (const attribute of [ends, colours]) {
      attribute.addUpdateRange(6 * from, 6 * above.length);
      attribute.needsUpdate = true;
    }
    this.count = count;
    this.lines.geometry.setDrawRange(0, 2 * count);
    this.show(this.isAsked);
  }

  private attribute(name: "position" | "color"): BufferAttribute {
    return this.lines.geometry.getAttribute(name) as BufferAttribute;
  }

  private makeRoom(nodes: number): void {
    const { geometry } = this.lines;
    const had = geometry.hasAttribute("position") ? this.attribute("position").count / 2 : 0;
    if (nodes <= had) return;
    const room = Math.max(nodes, 2 * had);
    const [ends, colours] = [new Float32Array(6 * room), new Uint8Array(6 * room)];
    const positions = new Float32Array(3 * room);
    if (had > 0) {
      ends.set(this.attribute("position").array);
      colours.set(this.attribute("color").array);
      positions.set(this.positions);
      geometry.dispose();
    }
    this.positions = positions;
    geometry.setAttribute("position", new BufferAttribute(ends, 3));
    geometry.setAttribute("color", new BufferAttribute(colours, 3, true));
  }
}
