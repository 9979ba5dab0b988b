import { element, section, swatch } from "./element.ts";
import { progress } from "../figures.ts";
import type { ShownPlan } from "../motion/trajectory.ts";
import type { View, ViewState } from "../data/view_state.ts";

/** Selection of the plan that moves the robot, and its verdict. */
export class PlanPanel {
  readonly element: HTMLElement;

  constructor(view: View, plans: ShownPlan[]) {
    const radios = plans.map((shown) => {
      const { index, plan, colour } = shown;
      const radio = element("input", { type: "radio", name: "plan", value: index });
      radio.addEventListener("change", () => view.set({ plan: index, q: null, treeNodes: null }));
      const row = element(
        "label",
        { class: "plan" },
        radio,
        swatch(colour),
        element(
          "span",
          { class: "what" },
          element("b", {}, plan.name),
          element("span", { class: "soft", title: ending(shown) }, [plan.planner, ending(shown)].filter(Boolean).join(" · ")),
        ),
        verdictMark(shown),
      );
      return { radio, row };
    });
    const verdict = element("p", { class: "soft said" });
    this.element = section(
      plans.length > 1 ? `Plans (${plans.length})` : "Plan",
      true,
      element(
        "div",
        { class: "rows", role: "radiogroup", "aria-label": "Plan that has the robot" },
        ...radios.map(({ row }) => row),
      ),
      verdict,
    );
    const show = (state: ViewState): void => {
      radios.forEach(({ radio }, index) => (radio.checked = index === state.plan));
      const shown = plans[state.plan];
      const isUntimed = shown && !shown.trajectory.isEmpty && !shown.plan.is_timed;
      verdict.textContent = [shown?.plan.verdict ?? "", ...(isUntimed ? [UNTIMED] : [])].join(". ");
    };
    view.on(["plan"], show);
    show(view.state);
  }
}

/** Note on a path without timing. */
const UNTIMED = "It has no time, for the robot has no limits of acceleration; it plays at a nominal pace, a length of 1 a second";

/** Duration or length of a plan, or the reason why it has no path. */
function ending({ plan, trajectory }: ShownPlan): string {
  return trajectory.isEmpty ? plan.outcome : progress(plan.is_timed ? trajectory.duration_s : plan.path_length, plan.is_timed);
}

/** Verdict on a plan in one or two words. */
export function verdictMark({ plan, trajectory }: ShownPlan): HTMLElement {
  if (plan.is_valid) return element("span", { class: "mark", "data-kind": "free" }, "valid");
  if (trajectory.isEmpty) return element("span", { class: "mark", "data-kind": "failed" }, "no path");
  return element("span", { class: "mark", "data-kind": "contact" }, "not valid");
}
