import { button, element, section } from "./element.ts";
import { jointValue, millimetres, words } from "../figures.ts";
import { HandDrag } from "../motion/hand_drag.ts";
import type { Kinematics, Variable } from "../motion/kinematics.ts";
import type { LiveVerdict, Standing } from "../data/live_verdict.ts";
import type { SceneView } from "../views/scene_view.ts";
import type { Stage } from "../stage.ts";
import type { View } from "../data/view_state.ts";

/** Slider range of a joint without limits: half a turn or a metre in each direction. */
const UNBOUNDED = { revolute: Math.PI, prismatic: 1 };

/** Number of listed contacts; others are only counted. */
const MOST_CONTACTS = 6;

/** A slider for each joint, and the server's verdict on the posture. */
export class JointPanel {
  readonly element: HTMLDetailsElement;
  private readonly sliders: { input: HTMLInputElement; value: HTMLOutputElement; variable: Variable }[];
  private readonly verdict = element("div", { class: "verdict", role: "status" });
  private readonly reset: HTMLButtonElement;

  constructor(
    view: View,
    { scene, stage, kinematics, live }: { scene: SceneView; stage: Stage; kinematics: Kinematics; live: LiveVerdict },
  ) {
    this.sliders = kinematics.variables.map((variable, index) => {
      const most = UNBOUNDED[variable.kind];
      const input = element("input", {
        type: "range",
        min: variable.lower ?? -most,
        max: variable.upper ?? most,
        step: "any",
        "aria-label": variable.name,
        "data-joint": index,
      });
      // By default, an arrow key moves a slider with `step="any"` by a tenth of its range.
      input.addEventListener("keydown", (event) => {
        const direction = { ArrowLeft: -1, ArrowDown: -1, ArrowRight: 1, ArrowUp: 1 }[event.key];
        if (direction === undefined) return;
        event.preventDefault();
        const step = (variable.kind === "revolute" ? Math.PI / 180 : 0.005) * (event.shiftKey ? 10 : 1);
        input.value = String(Number(input.value) + direction * step);
        input.dispatchEvent(new Event("input"));
      });
      input.addEventListener("input", () => {
        const q = [...scene.posture.q];
        q[index] = Number(input.value);
        view.set({ q, isPlaying: false });
      });
      return { input, value: element("output", { class: "value" }), variable };
    });
    this.reset = button("Back to the path", "Back to the path", () => view.set({ q: null }), "text");
    const rows = this.sliders.map(({ input, value, variable }) =>
      element(
        "label",
        { class: "slider" },
        element("span", { title: variable.name }, words(variable.name)),
        input,
        value,
      ),
    );
    const drag = new HandDrag(view, scene, stage, kinematics);
    this.element = section(
      "Joints",
      false,
      this.verdict,
      drag.element,
      element("div", { class: "rows" }, ...rows),
      this.reset,
    );
    const show = (): void => {
      const { q } = scene.posture;
      this.sliders.forEach(({ input, value, variable }, index) => {
        // The slider under the pointer already has this value.
        if (document.activeElement !== input || Number(input.value) !== q[index]) input.value = String(q[index]);
        value.value = jointValue(variable.kind, q[index]);
      });
      this.reset.hidden = view.state.q === null;
    };
    const ask = (): void => {
      const { isPlaying, q } = view.state;
      if ((this.element.open || q !== null) && !isPlaying) live.ask(scene.posture);
      else live.forget();
    };
    view.on(["q", "time_s", "plan", "isPlaying"], () => {
      if (this.element.open) show();
      this.reset.hidden = view.state.q === null;
      ask();
    });
    this.element.addEventListener("toggle", () => {
      if (this.element.open) this.element.scrollIntoView({ block: "nearest" });
      show();
      ask();
    });
    live.on((standing) => {
      this.show(standing);
      const names = standing.kind === "known" ? standing.verdict.contacts.flatMap((c) => [c.first, c.second]) : [];
      scene.setTouching(new Set(names));
    });
    show();
    // A link to a posture opens the panel.
    if (view.state.q !== null) {
      this.element.open = true;
      ask();
    }
  }

  private show(standing: Standing): void {
    const say = (kind: string, title: string, ...more: (Node | string)[]): void => {
      this.verdict.dataset["kind"] = kind;
      this.verdict.replaceChildren(element("b", {}, title), ...more);
    };
    switch (standing.kind) {
      case "unasked":
        return say("none", "…");
      case "not-live":
        return say("none", "Verdicts need ", element("code", {}, "cranny view"), ": this page is one file.");
      case "failed":
        return say("failed", "No verdict: ", standing.message);
      case "known": {
        const { is_free, clearance_m, contacts } = standing.verdict;
        if (is_free) {
          const clearance = clearance_m === null ? "" : `, ${millimetres(clearance_m)} from anything`;
          return say("free", "Free", clearance);
        }
        const rows = contacts
          .slice(0, MOST_CONTACTS)
          .map(({ first, second }) => element("li", {}, `${words(first)} – ${words(second)}`));
        if (contacts.length > MOST_CONTACTS)
          rows.push(element("li", {}, `and ${contacts.length - MOST_CONTACTS} more`));
        return say("contact", contacts.length > 0 ? "Contact" : "Not allowed", element("ul", {}, ...rows));
      }
    }
  }
}
