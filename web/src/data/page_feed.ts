import type { GrowingTree, NewNodes } from "./growing_tree.ts";
import type { View } from "./view_state.ts";

/** What the server of a page that can change says (`news?after=N`). */
interface News {
  changes: number;
  page: number;
  /** How often the robot was told how to stand; `q` is the last of these. */
  poses: number;
  q: number[] | null;
  /** The search that is watched. */
  tree: { search: number; nodes: number } | null;
}

/** Until the next question after a server that does not answer, in milliseconds. */
const PAUSE_MS = 1000;

/** Questions without an answer, after which nobody is thought to be there. */
const MOST_FAILURES = 5;

/**
 * Follows what the server of the page shows: postures at once, the nodes of a search as they come, another page by
 * loading it. `onGrowth` is called when a search has begun or has new nodes.
 */
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
          // Whoever watches a search wants to see it, and then the tree of its plan.
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

/** Fetches the nodes that are new. */
async function grow(tree: GrowingTree, news: { search: number; nodes: number }, onGrowth: () => void): Promise<void> {
  if (news.nodes > tree.count) {
    const nodes = await asked<NewNodes>(`tree?search=${news.search}&after=${tree.count}`);
    // Another search may have begun since, or another page be shown: the next news say so.
    if (nodes) tree.add(nodes);
  }
  onGrowth();
}

/** What the server answers; null where it refuses. */
async function asked<Answer>(address: string): Promise<Answer | null> {
  const answer = await fetch(address);
  return answer.ok ? ((await answer.json()) as Answer) : null;
}

/** The same view of the new page, but from the begin of its motion. */
function reload(): void {
  const asked = new URLSearchParams(location.hash.slice(1));
  for (const key of ["t", "q", "plan"]) asked.delete(key);
  history.replaceState(null, "", `${location.pathname}#${asked.toString()}`);
  location.reload();
}
