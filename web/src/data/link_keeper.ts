import { toHash } from "./view_link.ts";
import type { Eye, View } from "./view_state.ts";

/** A browser complains of addresses that change more often than it can count. */
const REST_MS = 300;

/** Keeps the address of the page at what is seen, and gives a link to it. */
export class LinkKeeper {
  private readonly view: View;
  private readonly eye: () => Eye;
  private readonly canPlay: boolean;
  private timer = 0;

  /** `canPlay`: whether there is a motion, which a page without a time in its address begins with. */
  constructor(view: View, eye: () => Eye, canPlay: boolean) {
    this.view = view;
    this.eye = eye;
    this.canPlay = canPlay;
    // A link to another view of this page; the page itself changes its address without this event.
    window.addEventListener("hashchange", () => location.reload());
    view.on(
      ["plan", "time_s", "speed", "q", "layers", "ghosts", "treeNodes", "graspColour", "eye", "isPlaying"],
      () => {
        clearTimeout(this.timer);
        if (!view.state.isPlaying && !view.state.isTreeGrowing)
          this.timer = setTimeout(() => this.keep(), REST_MS) as unknown as number;
      },
    );
  }

  /** Puts a link to this very view on the clipboard; what to tell who asked for it. */
  async copy(): Promise<string> {
    this.view.set({ eye: this.eye() });
    this.keep();
    try {
      await navigator.clipboard.writeText(location.href);
      return "Link copied";
    } catch {
      return "The link stands in the address bar";
    }
  }

  private keep(): void {
    // An eye that was let go glides on a little.
    const { state } = this.view;
    const hash = toHash({ ...state, eye: state.eye && this.eye() }, this.canPlay);
    try {
      history.replaceState(null, "", hash === "" ? location.pathname + location.search : `#${hash}`);
    } catch {
      // In the frame of a notebook the page has no address of its own.
    }
  }
}
