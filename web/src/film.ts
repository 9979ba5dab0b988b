import type { Player } from "./motion/player.ts";
import type { Stage } from "./stage.ts";
import type { View } from "./data/view_state.ts";

/** Formats that browsers record, the best first. */
const KINDS = ["video/mp4;codecs=avc1.640028", "video/webm;codecs=vp9", "video/webm;codecs=vp8", "video/webm"];

const PICTURES_A_SECOND = 30;

/** Bits per second at which edges stay sharp. */
const RATE = 12_000_000;

/** Records the motion from beginning to end as it is shown, and downloads it as a file. */
export class Film {
  private readonly view: View;
  private readonly stage: Stage;
  private readonly player: Player;
  private readonly name: string;
  private recorder: MediaRecorder | null = null;

  constructor(view: View, stage: Stage, player: Player, name: string) {
    this.view = view;
    this.stage = stage;
    this.player = player;
    this.name = name;
    stage.onFrame(() => {
      if (this.recorder?.state !== "recording") return false;
      if (!view.state.isPlaying) this.recorder.stop();
      return view.state.isPlaying;
    });
  }

  /** Records a video; returns the message for the user once the file exists. */
  async record(): Promise<string> {
    const kind = typeof MediaRecorder === "undefined" ? undefined : KINDS.find((each) => MediaRecorder.isTypeSupported(each));
    if (kind === undefined) return "This browser records no video";
    if (!this.player.canPlay) return "Nothing moves here";
    if (this.recorder) return "A video is being recorded";
    const { isLooping } = this.view.state;
    this.stage.setOpaque(true);
    this.view.set({ time_s: 0, q: null, isPlaying: true, isLooping: false });
    try {
      const parts = await this.parts(kind);
      const link = document.createElement("a");
      link.href = URL.createObjectURL(new Blob(parts, { type: kind }));
      link.download = `${this.name}.${kind.startsWith("video/mp4") ? "mp4" : "webm"}`;
      link.click();
      setTimeout(() => URL.revokeObjectURL(link.href), 60_000);
      return `Recorded ${link.download}`;
    } finally {
      this.stage.setOpaque(false);
      this.view.set({ isLooping });
      this.recorder = null;
    }
  }

  private parts(kind: string): Promise<Blob[]> {
    const stream = this.stage.canvas.captureStream(PICTURES_A_SECOND);
    const recorder = new MediaRecorder(stream, { mimeType: kind, videoBitsPerSecond: RATE });
    this.recorder = recorder;
    const parts: Blob[] = [];
    recorder.addEventListener("dataavailable", ({ data }) => parts.push(data));
    const done = new Promise<Blob[]>((resolve, reject) => {
      recorder.addEventListener("stop", () => resolve(parts));
      recorder.addEventListener("error", () => reject(new Error("the video cannot be recorded")));
    });
    recorder.start();
    this.stage.invalidate();
    return done;
  }
}
