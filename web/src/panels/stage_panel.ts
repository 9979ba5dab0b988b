import * as colours from "../colours.ts";
import { button, element, section, swatch } from "./element.ts";
import { count, millimetres, progress, seconds, words } from "../figures.ts";
import type { FailedAlternatives, Task, TaskStage } from "../data/page_data.ts";
import type { ShownPlan } from "../motion/trajectory.ts";
import type { View, ViewState } from "../data/view_state.ts";

/** Words for the outcome of a stage, and the colour of the mark. */
const OUTCOMES: Record<TaskStage["outcome"], { text: string; kind: string }> = {
  done: { text: "done", kind: "free" },
  passed: { text: "some passed", kind: "none" },
  failed: { text: "failed here", kind: "contact" },
  "not-reached": { text: "not reached", kind: "none" },
  unknown: { text: "not known", kind: "none" },
};

/** Offset in seconds after a boundary, so that the later stage is shown. */
const AFTER_S = 1e-6;

/** Effects of the panel's buttons. */
interface Acts {
  seek(time_s: number): void;
  showGrasp(index: number): void;
}

/** Grasps of the page. */
interface KnownGrasps {
  /** Their indices in the scenario. */
  indices: ReadonlySet<number>;
  /** The reasons that blocked them, in the order of their colours. */
  reasons: string[];
}

/** Stages of the chosen plan's task: what was tried, what failed, and where. */
export class StagePanel {
  readonly element: HTMLDetailsElement;
  private readonly view: View;
  private readonly plans: ShownPlan[];
  private readonly known: KnownGrasps;
  private readonly acts: Acts;
  private heads: { stage: TaskStage; head: HTMLElement }[] = [];
  private grasps: { index: number; chip: HTMLElement }[] = [];

  constructor(view: View, plans: ShownPlan[], known: KnownGrasps, acts: Acts) {
    this.view = view;
    this.plans = plans;
    this.known = known;
    this.acts = acts;
    const title = element("span");
    const body = element("div", { class: "stages" });
    this.element = section(title, true, body);
    const show = ({ plan }: ViewState): void => {
      const shown = this.plans[plan];
      const task = shown?.plan.task ?? null;
      [this.heads, this.grasps] = [[], []];
      title.textContent = task ? `Stages (${task.stages.length})` : "Stages";
      body.replaceChildren(...(shown && task ? this.parts(shown, task) : [soft("This plan has no list of stages.")]));
    };
    view.on(["plan"], show);
    view.on(["plan", "time_s", "q"], (state) => this.markStage(state));
    view.on(["plan", "grasp"], (state) => this.markGrasp(state));
    show(view.state);
    this.markStage(view.state);
    this.markGrasp(view.state);
  }

  private parts(shown: ShownPlan, task: Task): HTMLElement[] {
    const stages = task.stages.map((stage, index) => this.stage(shown, stage, index));
    const { search } = shown.plan;
    // Without any attempt, all grasps were excluded beforehand.
    const effort = search && search.goals_tried + search.ik_attempts > 0 ? [soft(searchEffort(search))] : [];
    return [summary(task), element("ol", {}, ...stages), ...effort];
  }

  private stage(shown: ShownPlan, stage: TaskStage, index: number): HTMLElement {
    const { text, kind } = OUTCOMES[stage.outcome];
    const name = capitalised(stage.name);
    const title = [
      element("span", { class: "number", "aria-hidden": "true" }, String(index + 1)),
      element("b", {}, name),
      element("span", { class: "mark", "data-kind": kind }, text),
    ];
    const { from_s } = stage;
    const head =
      from_s === null
        ? element("div", { class: "stage-head" }, ...title)
        : element("button", { type: "button", class: "stage-head", title: "Go to the beginning of this stage" }, ...title);
    if (from_s !== null) head.addEventListener("click", () => this.acts.seek(from_s + (from_s > 0 ? AFTER_S : 0)));
    this.heads.push({ stage, head });
    const facts = motionFacts(shown, stage);
    const parts: HTMLElement[] = [head];
    if (facts.length > 0) {
      parts.push(element("p", { class: "facts soft" }, ...facts.map((fact) => element("span", {}, fact))));
    }
    if (stage.grasp !== null) {
      const taken = element("div", { class: "chips" }, element("span", { class: "soft" }, "Grasp taken:"));
      taken.append(this.grasp(stage.grasp));
      parts.push(taken);
    }
    const number = stage.failed.reduce((sum, each) => sum + each.count, 0);
    if (number > 0 || (stage.left !== null && stage.outcome !== "not-reached")) {
      parts.push(element("p", { class: "counts" }, ...counts(number, stage.left)));
    }
    parts.push(...stage.failed.map((failed) => this.reason(failed)));
    return element("li", { class: "stage", "data-outcome": stage.outcome }, ...parts);
  }

  /** A reason with the grasps that failed for it. */
  private reason(failed: FailedAlternatives): HTMLElement {
    const colour = colours.ofReason(failed.grasps.length > 0 ? this.known.reasons.indexOf(failed.reason) : -1);
    const line = [
      swatch(colour),
      element("span", { class: "because" }, capitalised(words(failed.because))),
      element("b", {}, count(failed.count)),
    ];
    if (failed.grasps.length === 0) return element("div", { class: "reason" }, ...line);
    const chips = failed.grasps.map((index) => this.grasp(index));
    const details = element(
      "details",
      { class: "reason" },
      element("summary", { title: "Show these grasps" }, ...line),
      element("div", { class: "chips" }, element("span", { class: "soft" }, "Grasps:"), ...chips),
    );
    const point = (isPointed: boolean) => () => this.view.set({ reason: isPointed ? failed.reason : null });
    details.addEventListener("pointerenter", point(true));
    details.addEventListener("pointerleave", point(false));
    return details;
  }

  /** A grasp that shows itself in the scene when it is pressed. */
  private grasp(index: number): HTMLElement {
    if (!this.known.indices.has(index)) return element("span", { class: "chip" }, String(index));
    const chip = button(`Show grasp ${index} in the scene`, String(index), () => this.acts.showGrasp(index), "chip");
    this.grasps.push({ index, chip });
    return chip;
  }

  /** Marks the stage that is under way. */
  private markStage({ time_s, q }: ViewState): void {
    const begun = this.heads.filter(({ stage }) => stage.from_s !== null && stage.from_s <= time_s);
    const now = q === null ? begun.at(-1)?.head : undefined;
    for (const { head } of this.heads) head.ariaCurrent = head === now ? "step" : null;
  }

  private markGrasp({ grasp }: ViewState): void {
    for (const { index, chip } of this.grasps) chip.ariaPressed = String(index === grasp);
  }
}

/** The result of the whole task in a sentence or two. */
function summary({ stages, failed_at, tried, not_tried }: Task): HTMLElement {
  const all = stages.length;
  if (stages.every(({ outcome }) => outcome === "done")) {
    const kept = stages.some(({ failed }) => failed.length > 0)
      ? ""
      : " A plan file with a path keeps the alternative that succeeded, not those that failed before it.";
    return element("p", { class: "summary", "data-kind": "free" }, `All stages have a path.${kept}`);
  }
  const where =
    failed_at === null
      ? "No path was found. The plan file does not state the stage at which the search failed."
      : `No path was found. The search failed at stage ${failed_at + 1} of ${all}: ${stages[failed_at].name}.`;
  const grasps = tried === null ? "" : ` ${graspCount(tried)} checked, and none led through all stages.`;
  const untried = not_tried ? ` ${graspCount(not_tried)} not checked.` : "";
  return element("p", { class: "summary", "data-kind": "contact" }, where + grasps + untried);
}

function graspCount(number: number): string {
  return number === 1 ? "1 grasp was" : `${count(number)} grasps were`;
}

/** Number of alternatives that failed at a stage, and of those left after it. */
function counts(failed: number, left: number | null): HTMLElement[] {
  const parts = [element("span", { class: "lost" }, `✕ ${count(failed)} failed`)];
  if (left !== null) parts.push(element("span", { class: "kept" }, `✓ ${count(left)} left`));
  return parts;
}

/** Time and clearance of a stage that has a path. */
function motionFacts({ plan }: ShownPlan, { from_s, until_s, clearance_m }: TaskStage): string[] {
  if (from_s === null || until_s === null) return [];
  const span = plan.is_timed ? `${from_s.toFixed(2)} to ${seconds(until_s)}` : progress(until_s - from_s, false);
  const clear = plan.is_valid && clearance_m !== null ? [`clearance at least ${millimetres(clearance_m)}`] : [];
  return [span, ...clear];
}

function searchEffort({ goals_tried, ik_attempts, planning_time_s }: NonNullable<ShownPlan["plan"]["search"]>): string {
  return (
    `The whole search tried ${count(goals_tried)} goals (grasps or arm positions) and computed an arm position ` +
    `${count(ik_attempts)} times (inverse kinematics), in ${seconds(planning_time_s)}.`
  );
}

function soft(text: string): HTMLElement {
  return element("p", { class: "soft said" }, text);
}

function capitalised(text: string): string {
  return text.charAt(0).toUpperCase() + text.slice(1);
}
