import type { During, Verdict, VerdictQuestion } from "./page_data.ts";

/** Asks somebody who knows; rejects if there is no answer. */
export type Ask = (question: VerdictQuestion) => Promise<Verdict>;

export interface VerdictListener {
  /** `q` is what was asked about. */
  onVerdict(verdict: Verdict, q: number[]): void;
  onFailure(message: string): void;
}

/**
 * Live verdicts while a slider moves: one question is under way at a time, and of those that come meanwhile only
 * the newest is asked next. The last question is always answered; what was asked on the way may not be.
 */
export class VerdictClient {
  private readonly askServer: Ask;
  private readonly listener: VerdictListener;
  private readonly pause_ms: number;
  private waiting: VerdictQuestion | null = null;
  private isBusy = false;

  /** `pause_ms`: the least time between an answer and the next question. */
  constructor(ask: Ask, listener: VerdictListener, pause_ms = PAUSE_MS) {
    this.askServer = ask;
    this.listener = listener;
    this.pause_ms = pause_ms;
  }

  /** `during`: what a plan does there, if one has moved anything. */
  ask(q: ArrayLike<number>, during: During | null = null): void {
    this.waiting = { q: Array.from(q), ...(during ? { during } : {}) };
    if (!this.isBusy) void this.work();
  }

  /** Forgets what waits. An answer under way is not reported either. */
  cancel(): void {
    this.waiting = null;
    this.isCancelled = this.isBusy;
  }

  private isCancelled = false;

  private async work(): Promise<void> {
    this.isBusy = true;
    while (this.waiting) {
      const question: VerdictQuestion = this.waiting;
      this.waiting = null;
      this.isCancelled = false;
      try {
        const verdict = await this.askServer(question);
        if (!this.isCancelled) this.listener.onVerdict(verdict, question.q);
      } catch (error) {
        if (!this.isCancelled) this.listener.onFailure(error instanceof Error ? error.message : String(error));
      }
      if (this.pause_ms > 0) await new Promise((resolve) => setTimeout(resolve, this.pause_ms));
    }
    this.isBusy = false;
  }
}

/** About a frame of a display: more answers than that cannot be seen. */
const PAUSE_MS = 15;

/** The server behind the page. */
export async function askServer(question: VerdictQuestion): Promise<Verdict> {
  let answer: Response;
  try {
    answer = await fetch("verdict", {
      method: "POST",
      headers: { "content-type": "application/json" },
      body: JSON.stringify(question),
    });
  } catch {
    throw new Error("cranny view does not answer any more");
  }
  const body: unknown = await answer.json().catch(() => null);
  if (!answer.ok) throw new Error((body as { error?: string } | null)?.error ?? `status ${answer.status}`);
  return body as Verdict;
}
