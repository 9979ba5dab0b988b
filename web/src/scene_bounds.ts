import type { Kinematics } from "./motion/kinematics.ts";
import type { NodeView } from "./views/node_view.ts";
import type { Node, Point, Pose } from "./data/page_data.ts";
import { transformed } from "./motion/pose.ts";
import { type Movers, postureAlong, postureOf } from "./motion/posture.ts";
import type { ShownPlan } from "./motion/trajectory.ts";
import { INITIAL, type ViewState } from "./data/view_state.ts";

/** Obstacles farther than this from robot and target, in metres, may be outside the picture. */
const NEAR_M = 0.3;

/** Number of points on the gripper's path that should be visible. */
const PATH_POINTS = 12;

/** Bounds of the content that the view must show, over all its motions. */
export class SceneBounds {
  /** Corners of boxes around robot and target in all their postures, and around the nearby sections of obstacles. */
  readonly focus: Point[];
  readonly middle: Point;
  /** Radius in metres around `middle` that contains everything. */
  readonly reach_m: number;
  /** Points of target, gripper path and robot at the start that should not be hidden. */
  readonly wanted: Point[];

  constructor(view: NodeView, movers: Movers) {
    const { plans, recording } = movers;
    const start = postureOf(INITIAL, { ...movers, plans: [] }).worldFromNodes;
    const postures: Pose[][] = [start];
    const shares = [0, 1 / 3, 2 / 3, 1];
    for (const plan of plans.filter(({ trajectory }) => !trajectory.isEmpty)) {
      const { duration_s } = plan.trajectory;
      postures.push(...shares.map((share) => postureAlong(plan, share * duration_s, movers).worldFromNodes));
    }
    if (recording) {
      const at = (share: number): ViewState => ({ ...INITIAL, time_s: share * recording.duration_s });
      postures.push(...shares.map((share) => postureOf(at(share), movers).worldFromNodes));
    }
    const corners = (counts: (node: Node) => boolean): Point[][] =>
      postures.flatMap((posture, index) => {
        view.pose(posture);
        // Bodies that do not move need one check.
        return view.nodes.flatMap((node, i) =>
          counts(node) && (index === 0 || node.role !== "obstacle") ? [boxCorners(view, i)] : [],
        );
      });
    const matters = corners((node) => node.role !== "obstacle").flat();
    const obstacles = corners((node) => node.role === "obstacle").filter((points) => points.length > 0);
    view.pose(start);
    const near = matters.length > 0 ? grown(around(matters), NEAR_M) : null;
    const parts = near ? obstacles.flatMap((points) => cornersOf(common(around(points), near))) : obstacles.flat();
    this.focus = [...matters, ...parts];
    const all = around([...matters, ...obstacles.flat()]);
    const isEmpty = all.low[0] > all.high[0];
    const half = (i: number): number => (isEmpty ? 1 : (all.high[i] - all.low[i]) / 2);
    this.middle = [0, 1, 2].map((i) => (isEmpty ? 0 : (all.low[i] + all.high[i]) / 2)) as Point;
    this.reach_m = Math.max(Math.hypot(half(0), half(1), half(2)), 0.05);
    const isSeen = ({ role, mesh }: Node): boolean => role === "link" && mesh !== null;
    const links = start.filter((_, index) => isSeen(view.nodes[index])).map(([x, y, z]): Point => [x, y, z]);
    const ways = plans.flatMap((plan) => pathPoints(plan, movers.kinematics));
    this.wanted = [...targetPoints(view), ...links, ...ways];
  }
}

interface Box {
  low: Point;
  high: Point;
}

function around(points: Point[]): Box {
  const low: Point = [Infinity, Infinity, Infinity];
  const high: Point = [-Infinity, -Infinity, -Infinity];
  for (const point of points) {
    point.forEach((value, i) => {
      low[i] = Math.min(low[i], value);
      high[i] = Math.max(high[i], value);
    });
  }
  return { low, high };
}

function grown({ low, high }: Box, by: number): Box {
  return { low: low.map((value) => value - by) as Point, high: high.map((value) => value + by) as Point };
}

function common(a: Box, b: Box): Box {
  return {
    low: a.low.map((value, i) => Math.max(value, b.low[i])) as Point,
    high: a.high.map((value, i) => Math.min(value, b.high[i])) as Point,
  };
}

/** Corners of a box; none if it is empty. */
function cornersOf({ low, high }: Box): Point[] {
  if (low.some((value, i) => value > high[i])) return [];
  return Array.from(
    { length: 8 },
    (_, corner) => low.map((value, i) => ((corner >> i) & 1 ? high[i] : value)) as Point,
  );
}

function boxCorners(view: NodeView, index: number): Point[] {
  const box = view.box(index);
  return box ? cornersOf(box).map((corner) => transformed(view.worldFromNodes[index], corner)) : [];
}

/** Points in the upper half of the target, which its support does not hide. */
function targetPoints(view: NodeView): Point[] {
  return view.nodes.flatMap((node, index) => {
    const corners = node.role === "target" ? boxCorners(view, index) : [];
    if (corners.length === 0) return [];
    const { low, high } = around(corners);
    const z = 0.15 * low[2] + 0.85 * high[2];
    const middle = [0, 1, 2].map((i) => (low[i] + high[i]) / 2) as Point;
    return [middle, ...[low[0], high[0]].flatMap((x) => [low[1], high[1]].map((y): Point => [x, y, z]))];
  });
}

function pathPoints({ trajectory }: ShownPlan, kinematics: Kinematics): Point[] {
  const last = trajectory.times_s.length - 1;
  if (last < 0) return [];
  return Array.from({ length: PATH_POINTS }, (_, index) => {
    const row = trajectory.row(Math.round((index / (PATH_POINTS - 1)) * last));
    const [x, y, z] = kinematics.worldFromGripper(row);
    return [x, y, z];
  });
}
