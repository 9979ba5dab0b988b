import { Group } from "three";
import { setMatrix } from "./mesh_geometry.ts";
import type { MeshGeometries } from "./mesh_geometry.ts";
import { NodeView } from "./node_view.ts";
import type { PageData } from "../data/page_data.ts";
import { compose, inverse } from "../motion/pose.ts";
import { rectangle } from "./rectangle.ts";

const PLACE = 0x12a48b;
const TARGET_OPACITY = 0.35;

/** Targets of put-down: rectangles, or the target body at its goal pose. */
export class PlaceView {
  readonly group = new Group();

  constructor({ places, nodes, materials }: PageData, geometries: MeshGeometries) {
    const targets = nodes.filter(({ role }) => role === "target");
    for (const { world_from_place, size_m } of places) {
      if (size_m) {
        const area = rectangle(...size_m, PLACE);
        setMatrix(area.matrix, world_from_place).decompose(area.position, area.quaternion, area.scale);
        this.group.add(area);
      } else if (targets.length > 0) {
        const there = new NodeView(targets, materials, geometries, TARGET_OPACITY);
        const motion = compose(world_from_place, inverse(targets[0].parent_from_node));
        there.pose(targets.map(({ parent_from_node }) => compose(motion, parent_from_node)));
        this.group.add(there.group);
      }
    }
  }
}
