import { element } from "../panels/element.ts";
import { score, words } from "../figures.ts";
import { rank } from "../panels/grasp_choice.ts";
import type { Grasp } from "../data/page_data.ts";
import type { SceneView } from "../views/scene_view.ts";
import type { Stage } from "../stage.ts";
import type { ShownPlan } from "./trajectory.ts";
import type { View } from "../data/view_state.ts";

/** Distance in points within which the pointer selects a grasp: for a mouse and for a finger. */
const REACH = { mouse: 7, touch: 20 };

/** A press that moves farther than this, in points, rotates the view and selects no grasp. */
const STILL = 6;

/** Distance from the pointer to the tooltip, in points. */
const AWAY = 14;

/** Tooltip with the data of the grasp under the pointer. */
export class GraspTip {
  readonly element = element("div", { class: "tip", role: "tooltip", "aria-live": "polite" });
  private readonly grasps: Grasp[];
  private readonly stage: Stage;
  private readonly scene: SceneView;
  private readonly view: View;
  private readonly plans: ShownPlan[];
  private pressed: { x: number; y: number } | null = null;
  private pending: PointerEvent | null = null;

  constructor(stage: Stage, scene: SceneView, view: View, grasps: Grasp[], plans: ShownPlan[]) {
    this.stage = stage;
    this.scene = scene;
    this.view = view;
    this.grasps = grasps;
    this.plans = plans;
    this.element.hidden = true;
    const { canvas } = stage;
    canvas.addEventListener("pointermove", (event) => {
      if (event.buttons !== 0 || event.pointerType === "touch") return;
      // One update per frame is enough.
      if (!this.pending) requestAnimationFrame(() => this.look());
      this.pending = event;
    });
    canvas.addEventListener("pointerleave", (event) => {
      if (event.pointerType !== "touch") this.hide();
    });
    canvas.addEventListener("pointerdown", (event) => (this.pressed = { x: event.clientX, y: event.clientY }));
    canvas.addEventListener("pointerup", (event) => {
      const { pressed } = this;
      const isStill = pressed && Math.hypot(event.clientX - pressed.x, event.clientY - pressed.y) <= STILL;
      if (isStill) this.show(event);
    });
    stage.controls.addEventListener("start", () => this.hide());
    view.on(["layers", "isPlaying"], ({ layers, isPlaying }) => {
      if (!layers.grasps || isPlaying) this.hide();
    });
  }

  private look(): void {
    if (this.pending) this.show(this.pending);
    this.pending = null;
  }

  private show(event: PointerEvent): void {
    const { left, top } = this.stage.canvas.getBoundingClientRect();
    const [x, y] = [event.clientX - left, event.clientY - top];
    const reach = event.pointerType === "touch" ? REACH.touch : REACH.mouse;
    const isShown = this.view.state.layers.grasps;
    const found = isShown ? this.scene.grasps.at(x, y, reach, this.stage.lens) : null;
    if (found === null) return this.hide();
    this.tell(found, x, y);
  }

  /** Selects the next or previous grasp in the order of the scores, for users without a pointer. */
  step(by: number): void {
    if (this.grasps.length === 0) return;
    this.view.setLayer("grasps", true);
    const order = this.grasps.map((_, place) => place).sort((a, b) => rank(this.grasps[b]) - rank(this.grasps[a]));
    const now = order.findIndex((place) => this.grasps[place].index === this.view.state.grasp);
    const first = by > 0 ? -1 : 0;
    this.point(order[((now < 0 ? first : now) + by + order.length) % order.length]);
  }

  /** Selects the grasp with this index in the scenario, and stops the motion, so that the grasp stays visible. */
  select(index: number): void {
    const place = this.grasps.findIndex((grasp) => grasp.index === index);
    if (place < 0) return;
    this.view.set({ isPlaying: false });
    this.view.setLayer("grasps", true);
    this.point(place);
  }

  private point(place: number): void {
    const { x, y } = this.stage.lens(this.scene.grasps.middle(place));
    this.tell(place, x, y);
  }

  private tell(place: number, x: number, y: number): void {
    this.view.set({ grasp: this.grasps[place].index });
    this.element.replaceChildren(...this.words(this.grasps[place]));
    this.element.hidden = false;
    const free = this.stage.freeEdges;
    const [ownWidth, ownHeight] = [this.element.offsetWidth, this.element.offsetHeight];
    const isRight = x + AWAY + ownWidth <= free.right;
    const isBelow = y + AWAY + ownHeight <= free.bottom;
    this.element.style.left = `${within(isRight ? x + AWAY : x - AWAY - ownWidth, free.left, free.right - ownWidth)}px`;
    this.element.style.top = `${within(isBelow ? y + AWAY : y - AWAY - ownHeight, free.top, free.bottom - ownHeight)}px`;
  }

  private hide(): void {
    this.element.hidden = true;
    this.view.set({ grasp: null });
  }

  private words(grasp: Grasp): HTMLElement[] {
    const line = (name: string, value: string): HTMLElement =>
      element("div", {}, element("span", { class: "soft" }, name), element("span", {}, value));
    const lines = [element("b", {}, `Grasp ${grasp.index}`), line("score", score(grasp.score))];
    if (grasp.load !== null) lines.push(line("load", grasp.load.toFixed(2)));
    if (grasp.width_m !== null) lines.push(line("width", `${(1000 * grasp.width_m).toFixed(1)} mm`));
    lines.push(line("IK", words(grasp.ik)));
    const taken = this.plans.filter(({ plan }) => plan.grasp === grasp.index).map(({ plan }) => plan.name);
    if (taken.length > 0) lines.push(line("taken by", taken.join(", ")));
    const reason = this.plans[this.view.state.plan]?.reasons.get(grasp.index);
    if (reason !== undefined) lines.push(line("blocked", words(reason)));
    return lines;
  }
}

/** The value, moved into the interval less a margin at each end; its lower end if it is empty. */
function within(value: number, low: number, high: number): number {
  return Math.max(Math.min(value, high - EDGE), low + EDGE);
}

/** Least distance of the tooltip from panels and from the edge of the canvas, in points. */
const EDGE = 4;
