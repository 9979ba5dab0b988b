import type { During, Verdict, VerdictQuestion } from "./page_data.ts";

/** Requests a verdict; rejects if there is no answer. */
export type Ask = (question: VerdictQuestion) => Promise<Verdict>;

export interface VerdictListener {
  /** `q` is the configuration of the question. */
  onVerdict(verdict: Verdict, q: number[]): void;
  onFailure(message: string): void;
}

/** Live verdicts while a slider moves: one request at a time, and only the newest of those that arrive meanwhile is
 * sent next. The last question is always answered; earlier ones may not be. */
export class VerdictClient {
  private readonly askServer: Ask;
  private readonly listener: VerdictListener;
  private readonly pause_ms: number;
  private waiting: VerdictQuestion | null = null;
  private isBusy = false;

  /** `pause_ms`: least time between an answer and the next question. */
  constructor(ask: Ask, listener: VerdictListener, pause_ms = PAUSE_MS) {
    this.askServer = ask;
    this.listener = listener;
    this.pause_ms = pause_ms;
  }

  /** `during`: segment of the plan, if it has moved an object. */
  ask(q: ArrayLike<number>, during: During | null = null): void {
    this.waiting = { q: Array.from(q), ...(during ? { during } : {}) };
    if (!this.isBusy) void this.work();
  }

  /** Drops the waiting question and the answer to the one under way. */
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

/** About one frame of a display: more frequent answers would not be visible. */
const PAUSE_MS = 15;

/** Sends the question to the server behind the page. */
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
