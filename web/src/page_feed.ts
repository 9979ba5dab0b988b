import type { View } from "./view_state.ts";

/** What the server of a page that can change says (`news?after=N`). */
interface News {
  changes: number;
  page: number;
  q: number[] | null;
}

/** Until the next question after a server that does not answer, in milliseconds. */
const PAUSE_MS = 1000;

/** Questions without an answer, after which nobody is thought to be there. */
const MOST_FAILURES = 5;

/** Follows what the server of the page shows: postures at once, another page by loading it. */
export async function followFeed(page: number, view: View): Promise<void> {
  let after = 0;
  for (let failures = 0; failures < MOST_FAILURES; ) {
    try {
      const answer = await fetch(`news?after=${after}`);
      if (!answer.ok) return;
      const news = (await answer.json()) as News;
      failures = 0;
      if (news.page !== page) return reload();
      if (news.changes > after) view.set({ q: news.q, ...(news.q ? { isPlaying: false } : {}) });
      after = news.changes;
    } catch {
      failures += 1;
      await new Promise((resolve) => setTimeout(resolve, PAUSE_MS));
    }
  }
}

/** The same view of the new page, but from the begin of its motion. */
function reload(): void {
  const asked = new URLSearchParams(location.hash.slice(1));
  for (const key of ["t", "q", "plan"]) asked.delete(key);
  history.replaceState(null, "", `${location.pathname}#${asked.toString()}`);
  location.reload();
}
