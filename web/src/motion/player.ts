import type { Recording } from "../data/recording.ts";
import type { ShownPlan } from "./trajectory.ts";
import type { Stage } from "../stage.ts";
import type { View } from "../data/view_state.ts";

/** Advances the time: all plans play in step, and each stands still at its end. */
export class Player {
  /** Duration of the longest plan, or of the recording. */
  readonly duration_s: number;
  private readonly view: View;

  constructor(view: View, stage: Stage, plans: ShownPlan[], recording: Recording | null) {
    this.view = view;
    this.duration_s = Math.max(recording?.duration_s ?? 0, ...plans.map(({ trajectory }) => trajectory.duration_s));
    stage.onFrame((elapsed_s) => this.step(elapsed_s));
    view.on(["isPlaying"], () => stage.invalidate());
  }

  get canPlay(): boolean {
    return this.duration_s > 0;
  }

  /** Plays or pauses; restarts from the beginning if the time is at the end. */
  toggle(): void {
    const { isPlaying, time_s } = this.view.state;
    if (!this.canPlay) return;
    const isAtEnd = time_s >= this.duration_s;
    this.view.set({ isPlaying: !isPlaying, q: null, ...(!isPlaying && isAtEnd ? { time_s: 0 } : {}) });
  }

  /** Sets the time and pauses. */
  seek(time_s: number): void {
    if (!this.canPlay) return;
    this.view.set({ time_s: Math.min(Math.max(time_s, 0), this.duration_s), isPlaying: false, q: null });
  }

  private step(elapsed_s: number): boolean {
    const { isPlaying, isLooping, time_s, speed } = this.view.state;
    if (!isPlaying) return false;
    const next = Math.min(time_s + elapsed_s * speed, this.duration_s);
    const hasEnded = next >= this.duration_s;
    this.view.set({ time_s: hasEnded && isLooping ? 0 : next, isPlaying: !hasEnded || isLooping });
    return this.view.state.isPlaying;
  }
}
