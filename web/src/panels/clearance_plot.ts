import { millimetres, progress } from "../figures.ts";
import type { ClearanceCurve, ShownPlan } from "../motion/trajectory.ts";

/** Clearances above this, in metres, are drawn alike. */
const MOST_M = 0.25;

/** Possible maxima of the scale, in metres. */
const SCALES_M = [0.01, 0.02, 0.05, 0.1, 0.15, 0.25];

/** Margins above the highest and below the lowest line, in points. */
const TOP = 6;
const BOTTOM = 3;

/** Dash pattern of the line for the robot's own links, in points. */
const DASH = [3, 3];

/** Clearance from the world over time, one line per plan. The selected plan is filled, and a dashed line shows the
 * distance between its robot's own links, which would else hide the first. A cursor marks the time. */
export class ClearancePlot {
  readonly canvas = document.createElement("canvas");
  private readonly duration_s: number;
  private readonly plans: ShownPlan[];
  private scale_m = SCALES_M[0];
  private span = { left: 0, right: 0 };
  private last: { plan: number; shown: ShownPlan[]; time_s: number } | null = null;

  /** `onTime` is called with the time at the pressed position. */
  constructor(plans: ShownPlan[], duration_s: number, onTime: (time_s: number) => void) {
    this.plans = plans;
    this.duration_s = duration_s;
    this.canvas.className = "plot";
    this.canvas.setAttribute("role", "img");
    const seek = (event: PointerEvent): void => {
      const { left, width } = this.canvas.getBoundingClientRect();
      const share = (event.clientX - left - this.span.left) / (width - this.span.left - this.span.right);
      onTime(Math.min(Math.max(share, 0), 1) * duration_s);
    };
    this.canvas.addEventListener("pointerdown", (event) => {
      this.canvas.setPointerCapture(event.pointerId);
      seek(event);
    });
    this.canvas.addEventListener("pointermove", (event) => {
      if (event.buttons !== 0) seek(event);
    });
    new ResizeObserver(() => this.redraw()).observe(this.canvas);
  }

  get isEmpty(): boolean {
    return this.plans.every(({ clearance }) => !clearance);
  }

  /** Horizontal margins of the plot in points, so that it lines up with the travel of the slider's thumb. */
  setSpan(left: number, right: number): void {
    this.span = { left, right };
    this.redraw();
  }

  /** `shown`: the plans with lines; `plan`: index of the filled one. */
  draw(plan: number, shown: ShownPlan[], time_s: number): void {
    this.last = { plan, shown, time_s };
    const { clientWidth: width, clientHeight: height } = this.canvas;
    const ratio = Math.min(window.devicePixelRatio, 2);
    if (width === 0 || height === 0) return;
    this.canvas.width = Math.round(width * ratio);
    this.canvas.height = Math.round(height * ratio);
    const pen = this.canvas.getContext("2d");
    if (!pen) return;
    pen.scale(ratio, ratio);
    const style = getComputedStyle(this.canvas);
    const [ink, faint] = [style.getPropertyValue("--ink-soft"), style.getPropertyValue("--rule")];
    const most = Math.max(
      ...shown.map(({ clearance }) =>
        Math.min(MOST_M, clearance ? drawn(clearance).reduce((a, b) => Math.max(a, b), 0) : 0),
      ),
    );
    this.scale_m = SCALES_M.find((scale) => scale >= most) ?? MOST_M;
    const [from, to] = [this.span.left, width - this.span.right];
    const x = (time: number): number => from + (time / this.duration_s) * (to - from);
    const y = (distance: number): number => {
      const share = Math.min(Math.max(distance / this.scale_m, -0.05), 1);
      return height - BOTTOM - share * (height - TOP - BOTTOM);
    };
    this.rules(pen, { from, to }, y, ink, faint);
    const current = shown.find(({ index }) => index === plan);
    for (const other of shown.filter(({ index }) => index !== plan)) this.line(pen, other, x, y, 0.55);
    if (current) {
      this.fill(pen, current, x, y);
      this.waypoints(pen, current, x, height, ink);
      pen.fillStyle = faint;
      for (const mode of current.carrying?.modes.slice(1) ?? []) pen.fillRect(x(mode.from_s) - 0.5, 0, 1, height);
      this.line(pen, current, x, y, 1);
      this.ownLine(pen, current, x, y);
      this.legend(pen, current, from, ink);
    }
    this.cursor(pen, current, { x: x(time_s), time_s, height, y, ink: style.getPropertyValue("--ink") });
    this.describe(current);
  }

  redraw(): void {
    if (this.last) this.draw(this.last.plan, this.last.shown, this.last.time_s);
  }

  private rules(
    pen: CanvasRenderingContext2D,
    { from, to }: { from: number; to: number },
    y: (m: number) => number,
    ink: string,
    faint: string,
  ): void {
    pen.font = "10px system-ui, sans-serif";
    pen.textBaseline = "middle";
    for (const share of [0, 0.5, 1]) {
      const height = Math.round(y(share * this.scale_m)) + 0.5;
      pen.strokeStyle = faint;
      pen.lineWidth = 1;
      pen.beginPath();
      pen.moveTo(from, height);
      pen.lineTo(to, height);
      pen.stroke();
      const text = `${1000 * share * this.scale_m}${share === 1 ? " mm" : ""}`;
      pen.fillStyle = ink;
      pen.textAlign = "left";
      // To the right of the lines, below the choice of speed.
      pen.fillText(text, to + 8, Math.min(Math.max(height, 6), this.canvas.clientHeight - 6));
    }
  }

  private trace(pen: CanvasRenderingContext2D, plan: ShownPlan, x: Along, y: Along): void {
    pen.beginPath();
    if (!plan.clearance) return;
    const { times_s } = plan.clearance;
    const distances_m = drawn(plan.clearance);
    for (let i = 0; i < times_s.length; i += 1) pen.lineTo(x(times_s[i]), y(distances_m[i]));
  }

  private ownLine(pen: CanvasRenderingContext2D, plan: ShownPlan, x: Along, y: Along): void {
    if (!plan.clearance || !hasBoth(plan.clearance)) return;
    const { times_s, own_m } = plan.clearance;
    pen.beginPath();
    for (let i = 0; i < times_s.length; i += 1) pen.lineTo(x(times_s[i]), y(own_m[i]));
    pen.setLineDash(DASH);
    pen.strokeStyle = plan.colour;
    pen.globalAlpha = 0.7;
    pen.lineWidth = 1;
    pen.stroke();
    pen.setLineDash([]);
    pen.globalAlpha = 1;
  }

  /** Legend in the upper left corner. */
  private legend(pen: CanvasRenderingContext2D, plan: ShownPlan, from: number, ink: string): void {
    if (!plan.clearance || !hasBoth(plan.clearance)) return;
    pen.font = "10px system-ui, sans-serif";
    pen.textBaseline = "middle";
    pen.textAlign = "left";
    const back = getComputedStyle(this.canvas).getPropertyValue("--card");
    let left = from + 4;
    for (const [words, dash] of [
      ["from the world", []],
      ["robot from itself", DASH],
    ] as [string, number[]][]) {
      pen.fillStyle = back;
      pen.fillRect(left - 2, TOP - 4, 24 + pen.measureText(words).width, 14);
      pen.strokeStyle = plan.colour;
      pen.lineWidth = 1.5;
      pen.setLineDash(dash);
      pen.beginPath();
      pen.moveTo(left, TOP + 2.5);
      pen.lineTo(left + 16, TOP + 2.5);
      pen.stroke();
      pen.setLineDash([]);
      pen.fillStyle = ink;
      pen.fillText(words, left + 20, TOP + 3);
      left += 32 + pen.measureText(words).width;
    }
  }

  private line(pen: CanvasRenderingContext2D, plan: ShownPlan, x: Along, y: Along, opacity: number): void {
    this.trace(pen, plan, x, y);
    pen.globalAlpha = opacity;
    pen.strokeStyle = plan.colour;
    pen.lineWidth = 1.5;
    pen.lineJoin = "round";
    pen.stroke();
    pen.globalAlpha = 1;
  }

  private fill(pen: CanvasRenderingContext2D, plan: ShownPlan, x: Along, y: Along): void {
    const times_s = plan.clearance?.times_s;
    if (!times_s || times_s.length === 0) return;
    this.trace(pen, plan, x, y);
    pen.lineTo(x(times_s[times_s.length - 1]), y(0));
    pen.lineTo(x(times_s[0]), y(0));
    pen.globalAlpha = 0.16;
    pen.fillStyle = plan.colour;
    pen.fill();
    pen.globalAlpha = 1;
  }

  private waypoints(pen: CanvasRenderingContext2D, plan: ShownPlan, x: Along, height: number, ink: string): void {
    pen.fillStyle = ink;
    for (const time of plan.trajectory.waypointTimes_s) pen.fillRect(x(time) - 0.5, height - BOTTOM, 1, BOTTOM);
  }

  private cursor(pen: CanvasRenderingContext2D, plan: ShownPlan | undefined, at: Cursor): void {
    pen.strokeStyle = at.ink;
    pen.lineWidth = 1;
    pen.beginPath();
    pen.moveTo(at.x, 0);
    pen.lineTo(at.x, at.height);
    pen.stroke();
    const closest = plan?.clearance?.at(at.time_s);
    if (!plan || !closest || at.time_s > plan.trajectory.duration_s + 1e-6) return;
    pen.fillStyle = plan.colour;
    pen.beginPath();
    pen.arc(at.x, at.y(closest.distance_m), 3.5, 0, 2 * Math.PI);
    pen.fill();
  }

  private describe(plan: ShownPlan | undefined): void {
    const least = plan?.clearance?.least;
    const words = least
      ? `least ${millimetres(least.distance_m)} at ${progress(least.time_s, plan.plan.is_timed)}, ${least.first} and ${least.second}`
      : "not known for this plan";
    this.canvas.setAttribute("aria-label", `Clearance over time; ${words}`);
  }
}

/** Whether there are pairs with the world and pairs of own links. */
function hasBoth({ world_m, own_m }: ClearanceCurve): boolean {
  return world_m.some(Number.isFinite) && own_m.some(Number.isFinite);
}

/** Values of a plan's line: the distance from the world, if the world can be touched; in contact the least distance of
 * all pairs, as a negative depth. */
function drawn({ distances_m, world_m }: ClearanceCurve): Float64Array {
  const hasWorld = world_m.some(Number.isFinite);
  return distances_m.map((distance, i) => (hasWorld && distance >= 0 ? world_m[i] : distance));
}

type Along = (value: number) => number;

interface Cursor {
  x: number;
  time_s: number;
  height: number;
  y: Along;
  ink: string;
}
