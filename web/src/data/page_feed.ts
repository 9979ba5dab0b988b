import type { GrowingTree, NewNodes } from "./growing_tree.ts";
import type { View } from "./view_state.ts";

/** Answer of a server whose page can change (`news?after=N`). */
interface News {
  changes: number;
  page: number;
  /** Number of postures that the server has received; `q` is the last. */
  poses: number;
  q: number[] | null;
  /** The search that is shown live. */
  tree: { search: number; nodes: number } | null;
}

/** Pause in milliseconds after a request that the server did not answer. */
const PAUSE_MS = 1000;

/** Unanswered requests after which the server counts as stopped. */
const MOST_FAILURES = 5;

/** Follows the server's changes: sets new postures at once, adds the nodes of a search as they arrive, reloads for
 * another page. Calls `onGrowth` if a search has begun or has new nodes. */
export async function followFeed(page: number, view: View, tree: GrowingTree, onGrowth: () => void): Promise<void> {
  let [after, poses] = [0, 0];
  for (let failures = 0; failures < MOST_FAILURES; ) {
    try {
      const news = await asked<News>(`news?after=${after}`);
      if (!news) return;
      failures = 0;
      if (news.page !== page) return reload();
      if (news.poses > poses) view.set({ q: news.q, ...(news.q ? { isPlaying: false } : {}) });
      poses = news.poses;
      if (news.tree) {
        if (news.tree.search !== tree.search) {
          tree.begin(news.tree.search);
          // During a live search its tree is shown, and afterwards the tree of the plan.
          view.setLayer("tree", true);
        }
        await grow(tree, news.tree, onGrowth);
      }
      after = news.changes;
    } catch {
      failures += 1;
      await new Promise((resolve) => setTimeout(resolve, PAUSE_MS));
    }
  }
}

/** Fetches the new nodes. */
async function grow(tree: GrowingTree, news: { search: number; nodes: number }, onGrowth: () => void): Promise<void> {
  if (news.nodes > tree.count) {
    const nodes = await asked<NewNodes>(`tree?search=${news.search}&after=${tree.count}`);
    // By now another search or page may have begun; the next news report it.
    if (nodes) tree.add(nodes);
  }
  onGrowth();
}

/** Answer of the server; null if it refuses. */
async function asked<Answer>(address: string): Promise<Answer | null> {
  const answer = await fetch(address);
  return answer.ok ? ((await answer.json()) as Answer) : null;
}

/** Reloads the page with the same view, but from the beginning of its motion. */
function reload(): void {
  const asked = new URLSearchParams(location.hash.slice(1));
  for (const key of ["t", "q", "plan"]) asked.delete(key);
  history.replaceState(null, "", `${location.pathname}#${asked.toString()}`);
  location.reload();
}
