import { toHash } from "./view_link.ts";
import type { Eye, View } from "./view_state.ts";

/** Browsers warn about pages that change their address too often. */
const REST_MS = 300;

/** Keeps the page's address up to date with the view, and copies it as a link. */
export class LinkKeeper {
  private readonly view: View;
  private readonly eye: () => Eye;
  private readonly canPlay: boolean;
  private timer = 0;

  /** `canPlay`: whether the page has a motion; it plays at once if the address states no time. */
  constructor(view: View, eye: () => Eye, canPlay: boolean) {
    this.view = view;
    this.eye = eye;
    this.canPlay = canPlay;
    // A link to another view of this page was opened; the page's own changes of its address cause no such event.
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

  /** Copies a link to the current view to the clipboard; returns the message for the user. */
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
    // The camera still glides a little after it is released.
    const { state } = this.view;
    const hash = toHash({ ...state, eye: state.eye && this.eye() }, this.canPlay);
    try {
      history.replaceState(null, "", hash === "" ? location.pathname + location.search : `#${hash}`);
    } catch {
      // In the frame of a notebook the page has no address of its own.
    }
  }
}
