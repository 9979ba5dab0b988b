import type { Kinematics } from "./kinematics.ts";
import type { Pose } from "./page_data.ts";
import type { ShownPlan } from "./trajectory.ts";
import type { ViewState } from "./view_state.ts";

/** How the robot stands now. */
export interface Posture {
  q: number[];
  worldFromLinks: Pose[];
  worldFromGripper: Pose;
}

/** As it was posed by hand, else where the path has it, else where the scenario starts. */
export function postureOf(state: ViewState, plans: ShownPlan[], kinematics: Kinematics): Posture {
  const trajectory = plans[state.plan]?.trajectory;
  const onPath = trajectory && !trajectory.isEmpty ? trajectory.at(state.time_s) : kinematics.robot.start;
  const q = Array.from(state.q ?? onPath);
  const worldFromLinks = kinematics.worldFromLinks(q);
  return { q, worldFromLinks, worldFromGripper: worldFromLinks[kinematics.robot.tip] };
}
