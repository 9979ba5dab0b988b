import { Vector3 } from "three";
import type { Stage } from "./stage.ts";
import type { Eye, View } from "./data/view_state.ts";

/** Long enough for a viewer to follow the change of viewpoint. */
const FLIGHT_S = 0.45;

/** Animates the camera from one viewpoint to another, and stores the viewpoint in the view state once it is at rest. */
export class CameraFlight {
  private readonly stage: Stage;
  private flight: { from: [Vector3, Vector3]; to: [Vector3, Vector3]; share: number } | null = null;

  constructor(stage: Stage, view: View) {
    this.stage = stage;
    stage.onFrame((elapsed_s) => this.step(elapsed_s));
    stage.controls.addEventListener("start", () => (this.flight = null));
    stage.controls.addEventListener("end", () => view.set({ eye: this.eye }));
  }

  /** Current viewpoint, or the destination of the flight under way. */
  get eye(): Eye {
    if (this.flight) {
      const [position, target] = this.flight.to;
      return { position: position.toArray(), target: target.toArray() };
    }
    return { position: this.stage.camera.position.toArray(), target: this.stage.controls.target.toArray() };
  }

  /** Starts a flight; jumps at once if the user prefers reduced motion. */
  fly(to: Eye, isAtOnce = false): void {
    const ends: [Vector3, Vector3] = [new Vector3(...to.position), new Vector3(...to.target)];
    const isStill = isAtOnce || matchMedia("(prefers-reduced-motion: reduce)").matches;
    const { camera, controls } = this.stage;
    const from: [Vector3, Vector3] = [camera.position.clone(), controls.target.clone()];
    this.flight = { from, to: ends, share: isStill ? 1 : 0 };
    if (isStill) this.place(1);
    this.stage.invalidate();
  }

  private step(elapsed_s: number): boolean {
    if (!this.flight) return false;
    this.flight.share = Math.min(this.flight.share + elapsed_s / FLIGHT_S, 1);
    const { share } = this.flight;
    this.place(share * share * (3 - 2 * share));
    if (share === 1) this.flight = null;
    return true;
  }

  /** Moves the camera on an arc around the viewed point, not on a straight line through the robot. */
  private place(share: number): void {
    if (!this.flight) return;
    const { from, to } = this.flight;
    const { camera, controls } = this.stage;
    controls.target.lerpVectors(from[1], to[1], share);
    const [a, b] = [from[0].clone().sub(from[1]), to[0].clone().sub(to[1])];
    const length = a.length() * (1 - share) + b.length() * share;
    const [riseA, riseB] = [a, b].map((v) => Math.asin(v.z / (v.length() || 1)));
    const [turnA, turnB] = [a, b].map((v) => Math.atan2(v.y, v.x));
    const around = ((((turnB - turnA) % TURN) + 1.5 * TURN) % TURN) - TURN / 2;
    const [rise, turn] = [riseA + (riseB - riseA) * share, turnA + around * share];
    camera.position
      .set(Math.cos(rise) * Math.cos(turn), Math.cos(rise) * Math.sin(turn), Math.sin(rise))
      .multiplyScalar(length)
      .add(controls.target);
    camera.lookAt(controls.target);
  }
}

const TURN = 2 * Math.PI;
