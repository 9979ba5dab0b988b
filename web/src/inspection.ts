import type { LiveVerdict, Standing } from "./data/live_verdict.ts";
import type { Pose } from "./data/page_data.ts";
import type { SceneView } from "./views/scene_view.ts";
import type { Stage } from "./stage.ts";
import type { View } from "./data/view_state.ts";

/** `window.cranny`: read-only figures of what the page shows, for tests and the curious; assignments have no effect. */
export interface Inspection {
  /** Time along the path, in seconds. */
  readonly time: number;
  readonly isPlaying: boolean;
  /** Index of the plan that moves the robot. */
  readonly plan: number;
  /** The robot's variables as shown. */
  readonly q: number[];
  /** The gripper frame, in 64 bits: x, y, z, qx, qy, qz, qw; empty without a robot. */
  readonly worldFromGripper: Pose;
  /** The frame of the target's first body; null without a target. */
  readonly worldFromTarget: Pose | null;
  /** Current stage of a plan that carries its object: "reach", "close", "lift-off", "carry" and others; else empty. */
  readonly mode: string;
  /** Draw calls of the last frame, including those for shadows. */
  readonly drawCalls: number;
  /** Script time of the last frame in milliseconds, without the graphics card's. */
  readonly frameScriptMs: number;
  /** Number of frames drawn. */
  readonly frames: number;
  /** Whether no frame is being drawn or due. */
  readonly isIdle: boolean;
  /** Shown nodes of the search tree, of the plan or of a search under way; 0 without one. */
  readonly treeNodes: number;
  /** Time from the request for the page to its first frame, in milliseconds. */
  readonly loadMs: number;
  /** The server's verdict on the posture. */
  readonly standing: Standing;
  /** The grasp under the pointer. */
  readonly grasp: number | null;
  /** Number of grasps shown as small grippers. */
  readonly shownGrasps: number;
  /** Position of a grasp (by list position) on the screen, in points of the canvas. */
  graspOnScreen(place: number): { x: number; y: number };
  /** Position of the gripper frame on the screen. */
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
