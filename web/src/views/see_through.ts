import type { Point, Pose } from "../data/page_data.ts";
import type { NodeView } from "./node_view.ts";
import { inverse, transformed } from "../motion/pose.ts";

/** Nodes of obstacles between the camera and points that should be visible, except `carried` objects. */
export function hidingNodes(view: NodeView, eye: Point, wanted: Point[], carried: ReadonlySet<string>): Set<number> {
  const hiding = new Set<number>();
  view.nodes.forEach((node, index) => {
    const box = node.role === "obstacle" && !carried.has(node.name) ? view.box(index) : null;
    if (!box) return;
    const nodeFromWorld: Pose = inverse(view.worldFromNodes[index]);
    const from = transformed(nodeFromWorld, eye);
    if (wanted.some((point) => isCrossed(box, from, transformed(nodeFromWorld, point)))) hiding.add(index);
  });
  return hiding;
}

/** Whether the straight line between two points crosses the box (slab method; Kay & Kajiya 1986). */
export function isCrossed(box: { low: Point; high: Point }, from: Point, to: Point): boolean {
  let [enter, leave] = [0, 1];
  for (let axis = 0; axis < 3; axis += 1) {
    const step = to[axis] - from[axis];
    const [a, b] = [box.low[axis] - from[axis], box.high[axis] - from[axis]];
    if (Math.abs(step) < 1e-12) {
      if (a > 0 || b < 0) return false;
      continue;
    }
    enter = Math.max(enter, Math.min(a / step, b / step));
    leave = Math.min(leave, Math.max(a / step, b / step));
  }
  return enter < leave;
}
