import { Object3D } from "three";
import { TransformControls } from "three/addons/controls/TransformControls.js";
import { button, element } from "../panels/element.ts";
import { broughtTo } from "./inverse_kinematics.ts";
import type { Kinematics } from "./kinematics.ts";
import type { SceneView } from "../views/scene_view.ts";
import type { Stage } from "../stage.ts";
import type { View } from "../data/view_state.ts";

/** Arrows and rings at the gripper: the arm follows by inverse kinematics as far as it can reach. */
export class HandDrag {
  readonly element: HTMLElement;
  private readonly controls: TransformControls;
  private readonly handle = new Object3D();
  private readonly scene: SceneView;
  private readonly move: HTMLButtonElement;
  private readonly turn: HTMLButtonElement;

  constructor(view: View, scene: SceneView, stage: Stage, kinematics: Kinematics) {
    this.scene = scene;
    this.controls = new TransformControls(stage.camera, stage.canvas);
    this.controls.setSpace("local");
    this.controls.setSize(0.7);
    stage.scene.add(this.handle, this.controls.getHelper());
    this.move = button("Move the hand", "Move the hand", () => this.choose("translate"), "text");
    this.turn = button("Turn the hand", "Turn the hand", () => this.choose("rotate"), "text");
    this.element = element("div", { class: "hand-drag" }, this.move, this.turn);
    this.controls.addEventListener("change", () => stage.invalidate());
    this.controls.addEventListener("dragging-changed", ({ value }) => {
      stage.controls.enabled = !value;
      // After the drag, the handle returns to the pose that the gripper has reached.
      if (!value) this.place();
    });
    this.controls.addEventListener("objectChange", () => {
      const { position: p, quaternion: r } = this.handle;
      const q = broughtTo(kinematics, [p.x, p.y, p.z, r.x, r.y, r.z, r.w], scene.posture.q);
      view.set({ q, isPlaying: false });
    });
    view.on(["q", "time_s", "plan"], () => {
      if (!this.controls.dragging) this.place();
    });
    this.show();
  }

  /** Shows arrows or rings; the same button hides them again. */
  private choose(mode: "translate" | "rotate"): void {
    const isOff = this.controls.object === undefined || this.controls.mode !== mode;
    this.controls.setMode(mode);
    if (isOff) this.controls.attach(this.handle);
    else this.controls.detach();
    this.place();
    this.show();
  }

  private place(): void {
    const pose = this.scene.posture.worldFromGripper;
    if (!pose) return;
    this.handle.position.set(pose[0], pose[1], pose[2]);
    this.handle.quaternion.set(pose[3], pose[4], pose[5], pose[6]);
    this.handle.updateMatrixWorld();
  }

  private show(): void {
    const mode = this.controls.object === undefined ? null : this.controls.mode;
    this.move.setAttribute("aria-pressed", String(mode === "translate"));
    this.turn.setAttribute("aria-pressed", String(mode === "rotate"));
  }
}
