import * as colours from "../colours.ts";
import { button, element, section, swatch } from "./element.ts";
import { count, words } from "../figures.ts";
import { fewGrasps } from "./grasp_choice.ts";
import type { Grasp, Plan } from "../data/page_data.ts";
import type { ShownPlan } from "../motion/trajectory.ts";
import type { GraspColour, View, ViewState } from "../data/view_state.ts";

const BY: Record<GraspColour, string> = { score: "Score", ik: "IK", reason: "Why not" };

/** Colours of the grasps, and the reasons that blocked them. */
export class GraspPanel {
  readonly element: HTMLElement;
  private readonly legend = element("div", { class: "legend" });
  private readonly grasps: Grasp[];
  private readonly plans: ShownPlan[];
  private readonly reasons: string[];
  private readonly view: View;

  constructor(view: View, grasps: Grasp[], plans: ShownPlan[], reasons: string[]) {
    this.view = view;
    this.grasps = grasps;
    this.plans = plans;
    this.reasons = reasons;
    const hasIk = grasps.some(({ ik }) => ik !== "unknown");
    const tabs = (Object.keys(BY) as GraspColour[])
      .filter((by) => by === "score" || (by === "ik" ? hasIk : reasons.length > 0))
      .map((by) => {
        const tab = button(`Colour grasps by: ${BY[by]}`, BY[by], () => view.set({ graspColour: by }), "tab");
        return { by, tab };
      });
    const choice = element("div", { class: "tabs", role: "group", "aria-label": "Colour of grasps" });
    if (tabs.length > 1) choice.append(...tabs.map(({ tab }) => tab));
    const few = fewGrasps(grasps, plans.map(({ plan }) => plan)).length;
    const title = element("span");
    this.element = section(title, true, choice, this.legend);
    const show = (state: ViewState): void => {
      const isAll = state.layers.allGrasps || few === grasps.length;
      title.textContent = `Grasps (${isAll ? "" : `${count(few)} of `}${count(grasps.length)})`;
      for (const { by, tab } of tabs) tab.setAttribute("aria-pressed", String(by === state.graspColour));
      this.legend.replaceChildren(...this.rows(state));
    };
    view.on(["graspColour", "plan", "layers"], show);
    show(view.state);
  }

  private rows({ graspColour, plan }: ViewState): HTMLElement[] {
    if (graspColour === "score") return this.scores();
    if (graspColour === "ik") {
      const counts = new Map<string, number>();
      for (const { ik } of this.grasps) counts.set(ik, (counts.get(ik) ?? 0) + 1);
      return [...counts].map(([status, number]) => row(colours.ofIk(status), words(status), number));
    }
    const chosen = this.plans[plan]?.plan;
    if (!chosen) return [];
    const counts = blockedCounts(chosen);
    if (counts.length === 0)
      return [element("p", { class: "soft said" }, "This plan does not say what stood in the way.")];
    const named = new Set(chosen.blocked.map(({ reason }) => reason));
    const order = new Map(this.reasons.map((reason, index) => [reason, index]));
    return counts.map(({ reason, count: number }) => {
      // A reason without a known grasp has no colour in the scene.
      const colour = colours.ofReason(named.has(reason) ? (order.get(reason) ?? -1) : -1);
      const line = row(colour, words(reason), number);
      if (!named.has(reason)) return line;
      line.tabIndex = 0;
      line.classList.add("pointed");
      const point = (isPointed: boolean) => () => this.view.set({ reason: isPointed ? reason : null });
      line.addEventListener("pointerenter", point(true));
      line.addEventListener("pointerleave", point(false));
      line.addEventListener("focus", point(true));
      line.addEventListener("blur", point(false));
      return line;
    });
  }

  private scores(): HTMLElement[] {
    const known = this.grasps.flatMap(({ score }) => (score === null ? [] : [score]));
    const unknown = this.grasps.length - known.length;
    const bar = element("div", { class: "scale", "aria-hidden": "true" });
    bar.style.background = `linear-gradient(to right, ${colours.SCORE_STOPS.join(", ")})`;
    const ends = element(
      "div",
      { class: "ends soft" },
      ...["0", "score", "1"].map((text) => element("span", {}, text)),
    );
    const scale = known.length > 0 ? [bar, ends] : [];
    return unknown > 0 ? [...scale, row(colours.UNKNOWN, "without score", unknown)] : scale;
  }
}

/** Number of grasps by reason, from the plan file if it has them; the most frequent first, untried grasps last. */
export function blockedCounts(plan: Plan): { reason: string; count: number }[] {
  const counts = new Map(plan.blocked_counts.map(({ reason, count: number }) => [reason, number]));
  if (counts.size === 0) {
    for (const { reason } of plan.blocked) counts.set(reason, (counts.get(reason) ?? 0) + 1);
  }
  return [...counts]
    .map(([reason, number]) => ({ reason, count: number }))
    .filter((each) => each.count > 0)
    .sort(
      (a, b) => Number(a.reason === colours.NOT_TRIED) - Number(b.reason === colours.NOT_TRIED) || b.count - a.count,
    );
}

function row(colour: string, text: string, number: number): HTMLElement {
  return element("div", { class: "row" }, swatch(colour), element("span", {}, text), element("b", {}, count(number)));
}
