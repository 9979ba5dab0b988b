import type { Verdict } from "./page_data.ts";
import type { Posture } from "../motion/posture.ts";
import { askServer, VerdictClient } from "./verdict_client.ts";

/** State of the verdict on the shown posture. */
export type Standing =
  | { kind: "unasked" }
  | { kind: "not-live" }
  | { kind: "failed"; message: string }
  | { kind: "known"; verdict: Verdict; q: number[] };

/** The newest verdict of the server behind the page, if there is one. */
export class LiveVerdict {
  standing: Standing;
  private readonly client: VerdictClient | null;
  private readonly listeners: ((standing: Standing) => void)[] = [];

  constructor(isLive: boolean) {
    this.standing = isLive ? { kind: "unasked" } : { kind: "not-live" };
    this.client = isLive
      ? new VerdictClient(askServer, {
          onVerdict: (verdict, q) => this.tell({ kind: "known", verdict, q }),
          onFailure: (message) => this.tell({ kind: "failed", message }),
        })
      : null;
  }

  on(listener: (standing: Standing) => void): void {
    this.listeners.push(listener);
    listener(this.standing);
  }

  ask({ q, during }: Posture): void {
    this.client?.ask(q, during);
  }

  /** Discards a verdict that belongs to another posture. */
  forget(): void {
    this.client?.cancel();
    if (this.client && this.standing.kind !== "unasked") this.tell({ kind: "unasked" });
  }

  private tell(standing: Standing): void {
    this.standing = standing;
    for (const listener of this.listeners) listener(standing);
  }
}
