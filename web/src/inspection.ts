import type { LiveVerdict, Standing } from "./data/live_verdict.ts";
import type { Pose } from "./data/page_data.ts";
import type { SceneView } from "./views/scene_view.ts";
import type { Stage } from "./stage.ts";
import type { View } from "./data/view_state.ts";

/**
 * `window.cranny`: what the page shows, as figures, for tests and for who is curious. It can be looked at and not
 * changed; what is written here stays.
 */
export interface Inspection {
  /** Along the path, in seconds. */
  readonly time: number;
  readonly isPlaying: boolean;
  /** Index of the plan that has the robot. */
  readonly plan: number;
  /** The robot's variables, as it is shown. */
  readonly q: number[];
  /** The gripper frame, in 64 bits: x, y, z, qx, qy, qz, qw; empty without a robot. */
  readonly worldFromGripper: Pose;
  /** The frame of the target's first part; null without a target. */
  readonly worldFromTarget: Pose | null;
  /** What the robot does, of a plan that carries its object away: "reach", "close", "lift-off", "carry" and so
   * on; else empty. */
  readonly mode: string;
  /** Draw calls of the last frame, those of shadows among them. */
  readonly drawCalls: number;
  /** Script time of the last frame in milliseconds, the graphics card's not counted. */
  readonly frameScriptMs: number;
  /** Frames drawn so far. */
  readonly frames: number;
  /** Whether no frame is drawn or due. */
  readonly isIdle: boolean;
  /** Nodes of the search tree that are shown, of the plan or of a search that is going on; 0 without one. */
  readonly treeNodes: number;
  /** From the call of the page's address to its first frame, in milliseconds. */
  readonly loadMs: number;
  /** What the server says of the posture. */
  readonly standing: Standing;
  /** The grasp that is pointed at. */
  readonly grasp: number | null;
  /** How many grasps are shown as small grippers. */
  readonly shownGrasps: number;
  /** Where a grasp (by place in the list) is seen, in points of the canvas. */
  graspOnScreen(place: number): { x: number; y: number };
  /** Where the gripper frame is seen. */
  gripperOnScreen(): { x: number; y: number };
}

declare global {
  interface Window {
    readonly cranny?: Inspection;
  }
}

export function openInspection(stage: Stage, scene: SceneView, view: View, live: LiveVerdict, loadMs: number): void {
  const door: Inspection = Object.freeze({
    get time() {
      return view.state.time_s;
    },
    get isPlaying() {
      return view.state.isPlaying;
    },
    get plan() {
      return view.state.plan;
    },
    get q() {
      return [...scene.posture.q];
    },
    get worldFromGripper() {
      return [...(scene.posture.worldFromGripper ?? [])] as Pose;
    },
    get worldFromTarget() {
      return structuredClone(scene.worldFromTarget);
    },
    get mode() {
      return scene.mode;
    },
    get drawCalls() {
      return stage.renderer.info.render.calls;
    },
    get frameScriptMs() {
      return stage.frameScript_ms;
    },
    get frames() {
      return stage.frames;
    },
    get isIdle() {
      return stage.isIdle;
    },
    get treeNodes() {
      const tree = scene.trees.get(view.state.plan);
      return view.state.layers.tree ? (tree?.shown ?? scene.growing.count) : 0;
    },
    get loadMs() {
      return loadMs;
    },
    get standing() {
      return structuredClone(live.standing);
    },
    get grasp() {
      return view.state.grasp;
    },
    get shownGrasps() {
      return view.state.layers.grasps ? scene.grasps.shown : 0;
    },
    gripperOnScreen() {
      const [px, py, pz] = scene.posture.worldFromGripper ?? [0, 0, 0];
      const { x, y } = stage.lens([px, py, pz]);
      return { x, y };
    },
    graspOnScreen(place: number) {
      const { x, y } = stage.lens(scene.grasps.middle(place));
      return { x, y };
    },
  });
  Object.defineProperty(window, "cranny", { value: door, enumerable: true });
}
