import { button, element } from "./element.ts";
import { count } from "../figures.ts";
import { STANDARD_VIEWS, type StandardView } from "../framing.ts";
import { icon } from "./icons.ts";
import type { PageData } from "../data/page_data.ts";
import { verdictMark } from "./plan_panel.ts";
import type { Insets } from "../stage.ts";
import type { Theme } from "../theme.ts";
import type { ShownPlan } from "../motion/trajectory.ts";

/** Below this width the panel is under the scene, and closed at first. */
const NARROW = matchMedia("(max-width: 760px)");

const SAID_MS = 2400;

/** Layout of the page: scene, title, tools, panel, time line. */
export class Shell {
  readonly element: HTMLElement;
  readonly viewport = element("main", { class: "viewport" });
  readonly panel = element("aside", { class: "panel", id: "panel", "aria-label": "Settings" });
  readonly dock = element("div", { class: "dock-place" });
  private readonly tools = element("nav", { class: "tools", "aria-label": "Tools" });
  private readonly said = element("div", { class: "said-over", role: "status" });
  private readonly searching = element("span", { class: "searching", role: "status" });
  private readonly caption = element("p", { class: "caption", role: "note" });
  private readonly title: HTMLElement;
  private readonly toggle: HTMLButtonElement;
  private isPanelOpen = !NARROW.matches;

  constructor(data: PageData, plans: ShownPlan[]) {
    document.title = `${data.name} · Cranny`;
    this.title = element(
      "header",
      { class: "title" },
      element("span", { class: "brand" }, "Cranny"),
      element("h1", {}, data.name),
    );
    if (plans.length === 1) this.title.append(verdictMark(plans[0]));
    this.title.append(this.searching);
    this.toggle = button("Settings (h)", icon("panel"), () => this.togglePanel());
    this.toggle.setAttribute("aria-controls", "panel");
    this.element = element(
      "div",
      { class: "page" },
      this.viewport,
      this.title,
      this.tools,
      this.caption,
      this.panel,
      this.dock,
      this.said,
    );
    this.showPanel();
    NARROW.addEventListener("change", () => {
      this.isPanelOpen = !NARROW.matches;
      this.showPanel();
    });
  }

  /** Shows that a search is under way, and its number of nodes. */
  tellSearch(nodes: number): void {
    this.searching.textContent = `searching: ${count(nodes)} ${nodes === 1 ? "node" : "nodes"}`;
  }

  /** Lists the obstacles that are shown as glass. */
  captionSeenThrough(names: string[]): void {
    this.caption.textContent = names.length > 0 ? `seen through: ${names.join(", ")}` : "";
  }

  /** Calls `listener` now and whenever the area covered by panels changes. */
  onInsets(listener: (insets: Insets) => void): void {
    const tell = (): void => {
      this.element.style.setProperty("--dock", `${this.dock.offsetHeight}px`);
      listener(this.insets);
    };
    const observer = new ResizeObserver(tell);
    for (const part of [this.panel, this.dock, this.title, this.viewport]) observer.observe(part);
    tell();
  }

  addTools(
    actions: {
      look(view: StandardView): void;
      copyLink(): void;
      record(): void;
      toggleTheme(): void;
      toggleHelp(): void;
    },
    theme: Theme,
    canPlay: boolean,
  ): void {
    const views = element("div", { class: "group", role: "group", "aria-label": "Views" });
    for (const view of STANDARD_VIEWS) {
      const label = `${view.name} view (${view.key})`;
      const short = view.name === "Three-quarter" ? icon("view") : view.name;
      views.append(button(label, short, () => actions.look(view), view.name === "Three-quarter" ? "icon" : "text"));
    }
    const mode = button("Light or dark (m)", icon("moon"), () => actions.toggleTheme());
    theme.on((_, name) => mode.replaceChildren(icon(name === "dark" ? "sun" : "moon")));
    const others = element(
      "div",
      { class: "group" },
      button("Copy link (l)", icon("link"), () => actions.copyLink()),
      ...(canPlay ? [button("Record a video (r)", icon("record"), () => actions.record())] : []),
      mode,
      button("Keys (?)", icon("help"), () => actions.toggleHelp()),
      this.toggle,
    );
    this.tools.append(views, others);
  }

  togglePanel(): void {
    this.isPanelOpen = !this.isPanelOpen;
    this.showPanel();
  }

  /** Shows a message briefly. */
  say(text: string): void {
    this.said.textContent = text;
    this.said.classList.add("shown");
    setTimeout(() => this.said.classList.remove("shown"), SAID_MS);
  }

  private showPanel(): void {
    this.panel.hidden = !this.isPanelOpen;
    this.toggle.setAttribute("aria-expanded", String(this.isPanelOpen));
  }

  private get insets(): Insets {
    const own = this.viewport.getBoundingClientRect();
    const top = Math.max(this.title.getBoundingClientRect().bottom - own.top, 0);
    const dock = this.dock.getBoundingClientRect();
    const panel = this.panel.getBoundingClientRect();
    const [isBeside, isBelow] = [this.isPanelOpen && !NARROW.matches, this.isPanelOpen && NARROW.matches];
    return {
      left: 0,
      top,
      right: isBeside ? own.right - panel.left : 0,
      bottom: isBelow ? own.bottom - panel.top : dock.height > 0 ? own.bottom - dock.top : 0,
    };
  }
}
