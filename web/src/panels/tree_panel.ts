import * as colours from "../colours.ts";
import { button, element, section, swatch } from "./element.ts";
import { count } from "../figures.ts";
import { icon } from "./icons.ts";
import type { SceneView } from "../views/scene_view.ts";
import type { Stage } from "../stage.ts";
import type { View, ViewState } from "../data/view_state.ts";

/** Duration in seconds of the growth of a whole search, regardless of its size. */
const GROWTH_S = 8;

/** Number of listed trees; others are only counted. */
const MOST_TREES = 5;

/** Animates the growth of the search tree. */
export class TreePanel {
  readonly element: HTMLDetailsElement;

  constructor(view: View, scene: SceneView, stage: Stage) {
    const total = (state: ViewState): number => scene.trees.get(state.plan)?.count ?? 0;
    const toggle = (): void => {
      const { state } = view;
      const isAtEnd = (state.treeNodes ?? total(state)) >= total(state);
      view.setLayer("tree", true);
      view.set({
        isTreeGrowing: !state.isTreeGrowing,
        ...(!state.isTreeGrowing && isAtEnd ? { treeNodes: 0 } : {}),
      });
    };
    const play = button("Let the tree grow", icon("play"), toggle, "play small");
    const slider = element("input", { type: "range", min: 0, step: 1, "aria-label": "Nodes of the search tree" });
    slider.addEventListener("input", () => {
      view.setLayer("tree", true);
      view.set({ treeNodes: Number(slider.value), isTreeGrowing: false });
    });
    const value = element("div", { class: "soft" });
    const legend = element("div", { class: "legend" });
    this.element = section("Search tree", true, element("div", { class: "growth" }, play, slider), value, legend);
    const show = (state: ViewState): void => {
      const all = total(state);
      this.element.hidden = all === 0;
      const nodes = state.treeNodes ?? all;
      slider.max = String(all);
      slider.value = String(nodes);
      value.textContent = `${count(Math.round(nodes))} of ${count(all)} nodes`;
      play.replaceChildren(icon(state.isTreeGrowing ? "pause" : "play"));
      play.ariaLabel = play.title = state.isTreeGrowing ? "Stop growing" : "Let the tree grow";
    };
    const list = (state: ViewState): void => legend.replaceChildren(...treeRows(scene.trees.get(state.plan)?.sizes));
    view.on(["treeNodes", "plan", "isTreeGrowing"], show);
    view.on(["plan"], list);
    view.on(["isTreeGrowing"], () => stage.invalidate());
    stage.onFrame((elapsed_s) => {
      const { state } = view;
      if (!state.isTreeGrowing) return false;
      const all = total(state);
      const nodes = Math.min(
        (state.treeNodes ?? 0) + Math.max((elapsed_s / GROWTH_S) * all, elapsed_s > 0 ? 1 : 0),
        all,
      );
      view.set({ treeNodes: nodes >= all ? null : nodes, isTreeGrowing: nodes < all });
      return view.state.isTreeGrowing;
    });
    show(view.state);
    list(view.state);
  }
}

function treeRows(sizes: Map<number, number> | undefined): HTMLElement[] {
  const ordered = [...(sizes ?? [])].sort(([a, sizeA], [b, sizeB]) => (a === 0 ? -1 : b === 0 ? 1 : sizeB - sizeA));
  const rows = ordered
    .slice(0, MOST_TREES)
    .map(([tree, size]) =>
      element(
        "div",
        { class: "row" },
        swatch(colours.ofTree(tree)),
        element("span", {}, tree === 0 ? "from the start" : `from goal ${tree}`),
        element("b", {}, count(size)),
      ),
    );
  const rest = ordered.slice(MOST_TREES);
  if (rest.length > 0) {
    const nodes = rest.reduce((sum, [, size]) => sum + size, 0);
    rows.push(
      element(
        "div",
        { class: "row soft" },
        element("span", {}, `${rest.length} more trees`),
        element("b", {}, count(nodes)),
      ),
    );
  }
  return rows;
}
