import type { Moved } from "./carrying.ts";
import type { Kinematics } from "./kinematics.ts";
import { worldFromNodes } from "../views/node_view.ts";
import type { During, Node, Pose } from "../data/page_data.ts";
import type { Recording } from "../data/recording.ts";
import type { ShownPlan } from "./trajectory.ts";
import type { ViewState } from "../data/view_state.ts";

/** What there is that can move. */
export interface Movers {
  nodes: Node[];
  plans: ShownPlan[];
  kinematics: Kinematics;
  recording: Recording | null;
}

/** How everything stands now. */
export interface Posture {
  q: number[];
  worldFromLinks: Pose[];
  /** Null where there is no robot. */
  worldFromGripper: Pose | null;
  worldFromNodes: Pose[];
  moved: Moved;
  /** What is done; null as long as nothing has moved. */
  during: During | null;
}

/** As the robot was posed by hand, nothing moved; else as the path or the recording has it, else as the scenario starts. */
export function postureOf(state: ViewState, movers: Movers): Posture {
  const { plans, kinematics } = movers;
  const plan = plans[state.plan];
  if (state.q === null && plan && !plan.trajectory.isEmpty) return postureAlong(plan, state.time_s, movers);
  return standing(state.q ?? kinematics.robot.start, state.time_s, movers);
}

/** As a plan has it at a time. */
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

/** Everything stands where it was. */
const NOTHING: Moved = new Map();
