import type { Moved } from "./carrying.ts";
import type { Kinematics } from "./kinematics.ts";
import { worldFromNodes } from "../views/node_view.ts";
import type { During, Node, Pose } from "../data/page_data.ts";
import type { Recording } from "../data/recording.ts";
import type { ShownPlan } from "./trajectory.ts";
import type { ViewState } from "../data/view_state.ts";

/** Sources of motion on the page. */
export interface Movers {
  nodes: Node[];
  plans: ShownPlan[];
  kinematics: Kinematics;
  recording: Recording | null;
}

/** Current poses of everything. */
export interface Posture {
  q: number[];
  worldFromLinks: Pose[];
  /** Null without a robot. */
  worldFromGripper: Pose | null;
  worldFromNodes: Pose[];
  moved: Moved;
  /** Current segment of the plan; null until an object has moved. */
  during: During | null;
}

/** Posture as set by hand, without moved objects; else from path or recording, else from the scenario's start. */
export function postureOf(state: ViewState, movers: Movers): Posture {
  const { plans, kinematics } = movers;
  const plan = plans[state.plan];
  if (state.q === null && plan && !plan.trajectory.isEmpty) return postureAlong(plan, state.time_s, movers);
  return standing(state.q ?? kinematics.robot.start, state.time_s, movers);
}

/** Posture of a plan at a time. */
export function postureAlong(plan: ShownPlan, time_s: number, { nodes, kinematics }: Movers): Posture {
  const { carrying, trajectory, index } = plan;
  const q = Array.from(trajectory.at(time_s));
  const worldFromLinks = kinematics.worldFromLinks(q, carrying?.closingAt(time_s));
  const worldFromGripper = worldFromLinks[kinematics.robot.tip];
  const moved = carrying?.movedAt(time_s, worldFromGripper) ?? NOTHING;
  const now = moved.size > 0 ? carrying?.at(time_s) : undefined;
  const during = now ? { plan: index, segment: now.segment } : null;
  return { q, worldFromLinks, worldFromGripper, worldFromNodes: worldFromNodes(nodes, worldFromLinks, moved), moved, during };
}

function standing(at: ArrayLike<number>, time_s: number, { nodes, kinematics, recording }: Movers): Posture {
  const q = Array.from(at);
  const worldFromLinks = kinematics.worldFromLinks(q);
  const places = worldFromNodes(nodes, worldFromLinks, NOTHING);
  recording?.at(time_s).forEach((pose, node) => (places[node] = pose));
  const worldFromGripper = worldFromLinks[kinematics.robot.tip] ?? null;
  return { q, worldFromLinks, worldFromGripper, worldFromNodes: places, moved: NOTHING, during: null };
}

/** No body has moved. */
const NOTHING: Moved = new Map();
