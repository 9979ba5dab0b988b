import { ofMode } from "./colours.ts";
import { button, element } from "./element.ts";
import type { ShownPlan } from "./trajectory.ts";

/** What the robot does when, below the slider of the time; what is pressed shows its beginning. */
export class ModeStrip {
  readonly element = element("div", { class: "modes", role: "group", "aria-label": "What the robot does" });
  private readonly duration_s: number;
  private readonly onTime: (time_s: number) => void;
  private shown: ShownPlan | null = null;
  private marks: { name: string; mark: HTMLButtonElement }[] = [];

  /** `onTime` is called with the time at which something begins that was pressed. */
  constructor(duration_s: number, onTime: (time_s: number) => void) {
    this.duration_s = duration_s;
    this.onTime = onTime;
  }

  show(plan: ShownPlan | undefined, time_s: number): void {
    if ((plan ?? null) !== this.shown) {
      this.shown = plan ?? null;
      this.marks = plan?.carrying ? this.marksOf(plan) : [];
      this.element.replaceChildren(...this.marks.map(({ mark }) => mark));
    }
    const now = plan?.carrying?.modeAt(time_s);
    for (const { name, mark } of this.marks) mark.ariaCurrent = name === now ? "step" : null;
  }

  private marksOf({ carrying, colour }: ShownPlan): typeof this.marks {
    if (!carrying) return [];
    const all = [...carrying.modes, ...carrying.stops].sort((a, b) => a.from_s - b.from_s);
    return all.map(({ name, from_s, until_s }) => {
      const label = HAND[name] ?? `To the beginning of ${name}`;
      const mark = button(label, element("span", {}, name), () => this.onTime(from_s + (from_s > 0 ? AFTER_S : 0)), "mode");
      mark.dataset["mode"] = name;
      mark.style.left = `${(100 * from_s) / this.duration_s}%`;
      mark.style.width = `${(100 * (until_s - from_s)) / this.duration_s}%`;
      mark.style.setProperty("--mode", name in HAND ? "var(--ink-soft)" : ofMode(colour, name));
      return { name, mark };
    });
  }
}

/** What the hand does while the robot stands. */
const HAND: Record<string, string> = { close: "The hand closes", open: "The hand opens" };

/** Where something ends and the next begins, it is shown that the next does. */
const AFTER_S = 1e-6;
