import { ofMode } from "../colours.ts";
import { button, element } from "./element.ts";
import type { Stretch } from "../motion/carrying.ts";
import type { ShownPlan } from "../motion/trajectory.ts";

/** Stages of the plan below the time slider (with several objects, where each begins); pressing one jumps there. */
export class ModeStrip {
  readonly element = element("div", { class: "modes", role: "group", "aria-label": "What the robot does" });
  private readonly duration_s: number;
  private readonly onTime: (time_s: number) => void;
  private shown: ShownPlan | null = null;
  private marks: { stretch: Stretch; mark: HTMLButtonElement }[] = [];

  /** `onTime` is called with the time at which the pressed stage begins. */
  constructor(duration_s: number, onTime: (time_s: number) => void) {
    this.duration_s = duration_s;
    this.onTime = onTime;
  }

  show(plan: ShownPlan | undefined, time_s: number): void {
    if ((plan ?? null) !== this.shown) {
      this.shown = plan ?? null;
      this.marks = plan?.carrying ? this.marksOf(plan) : [];
      this.element.replaceChildren(...this.marks.map(({ mark }) => mark));
      this.element.classList.toggle("of-steps", (plan?.carrying?.stepCount ?? 0) > 1);
    }
    const now = plan?.carrying?.at(time_s);
    for (const { stretch, mark } of this.marks) mark.ariaCurrent = stretch === now ? "step" : null;
  }

  private marksOf({ carrying, colour }: ShownPlan): typeof this.marks {
    if (!carrying) return [];
    const begun = new Set<number>();
    return carrying.stretches.map((stretch) => {
      const { name, from_s, until_s, step } = stretch;
      const said = HAND[name] ?? `To the beginning of ${name}`;
      const isOne = carrying.stepCount === 1;
      const label = isOne ? said : `${said}, step ${step + 1}`;
      const isFirst = !begun.has(step);
      begun.add(step);
      const text = isOne || !isFirst ? name : `step ${step + 1}`;
      const mark = button(label, element("span", {}, text), () => this.onTime(from_s + (from_s > 0 ? AFTER_S : 0)), "mode");
      mark.dataset["mode"] = name;
      mark.style.left = `${(100 * from_s) / this.duration_s}%`;
      mark.style.width = `${(100 * (until_s - from_s)) / this.duration_s}%`;
      mark.style.setProperty("--mode", name in HAND ? "var(--ink-soft)" : ofMode(colour, stretch));
      return { stretch, mark };
    });
  }
}

/** Labels of the hand's motions while the robot stands. */
const HAND: Record<string, string> = { close: "The hand closes", open: "The hand opens" };

/** Offset in seconds after a boundary, so that the later stage is shown. */
const AFTER_S = 1e-6;
