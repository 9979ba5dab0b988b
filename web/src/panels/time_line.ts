import { ClearancePlot } from "./clearance_plot.ts";
import { button, element } from "./element.ts";
import { millimetres, progress, seconds, words } from "../figures.ts";
import { icon } from "./icons.ts";
import { ModeStrip } from "./mode_strip.ts";
import type { Player } from "../motion/player.ts";
import type { Theme } from "../theme.ts";
import type { ShownPlan } from "../motion/trajectory.ts";
import { SPEEDS, type View, type ViewState } from "../data/view_state.ts";

/** Width of a slider's thumb in points; it stays inside the track. */
const THUMB = 14;

/** Play, pause, scrub and speed, with the clearance along the path. */
export class TimeLine {
  readonly element: HTMLElement;
  private readonly play: HTMLButtonElement;
  private readonly scrub: HTMLInputElement;
  private readonly clock = element("output", { class: "clock" });
  private readonly closest = element("div", { class: "closest" });
  private readonly plot: ClearancePlot;
  private readonly modes: ModeStrip;
  private readonly plans: ShownPlan[];
  private readonly player: Player;

  constructor(view: View, player: Player, plans: ShownPlan[], theme: Theme) {
    this.plans = plans;
    this.player = player;
    this.play = button("Play (space)", icon("play"), () => player.toggle(), "play");
    this.scrub = element("input", {
      type: "range",
      class: "scrub",
      min: 0,
      max: player.duration_s,
      step: "any",
      "aria-label": "Time along the path",
    });
    this.scrub.addEventListener("input", () => player.seek(Number(this.scrub.value)));
    const speed = element("select", { class: "speed", "aria-label": "Speed" });
    for (const value of SPEEDS) speed.append(element("option", { value }, `${value}×`));
    speed.addEventListener("change", () => view.set({ speed: Number(speed.value) }));
    this.plot = new ClearancePlot(plans, player.duration_s, (time_s) => player.seek(time_s));
    this.modes = new ModeStrip(player.duration_s, (time_s) => player.seek(time_s));
    const hasPlot = !this.plot.isEmpty;
    const hasModes = plans.some(({ carrying }) => carrying);
    this.element = element(
      "section",
      {
        class: ["dock", ...(hasPlot ? [] : ["without-plot"]), ...(hasModes ? ["with-modes"] : [])].join(" "),
        "aria-label": "Time line",
      },
      element("div", { class: "transport" }, this.play, this.clock),
      element("div", { class: "track" }, this.scrub, ...(hasModes ? [this.modes.element] : [])),
      speed,
      ...(hasPlot ? [this.closest, this.plot.canvas] : []),
    );
    new ResizeObserver(() => {
      const [scrub, plot] = [this.scrub, this.plot.canvas].map((part) => part.getBoundingClientRect());
      this.plot.setSpan(scrub.left - plot.left + THUMB / 2, plot.right - scrub.right + THUMB / 2);
    }).observe(this.scrub);
    this.element.hidden = !player.canPlay;
    const show = (state: ViewState): void => this.show(state, speed);
    view.on(["time_s", "plan", "isPlaying", "speed", "q", "layers"], show);
    theme.on(() => this.plot.redraw());
    show(view.state);
  }

  private show(state: ViewState, speed: HTMLSelectElement): void {
    const { isPlaying, time_s } = state;
    if (this.play.dataset["playing"] !== String(isPlaying)) {
      this.play.dataset["playing"] = String(isPlaying);
      this.play.replaceChildren(icon(isPlaying ? "pause" : "play"));
      this.play.ariaLabel = this.play.title = isPlaying ? "Pause (space)" : "Play (space)";
    }
    this.scrub.value = String(time_s);
    this.scrub.style.setProperty("--done", `${(100 * time_s) / (this.player.duration_s || 1)}%`);
    const shownPlan = this.plans[state.plan];
    const isTimed = shownPlan?.plan.is_timed ?? true;
    // A path without timing has its own length, which does not apply to other plans.
    const last_s = isTimed ? this.player.duration_s : shownPlan.trajectory.duration_s;
    const gone = (at_s: number): number => at_s - (isTimed ? 0 : (shownPlan.carrying?.stoodUntil(at_s) ?? 0));
    const [now, end] = [gone(Math.min(time_s, last_s)), gone(last_s)];
    this.scrub.setAttribute("aria-valuetext", `${progress(now, isTimed)} of ${progress(end, isTimed)}`);
    this.clock.replaceChildren(
      element("b", {}, now.toFixed(2)),
      element("span", { class: "soft" }, isTimed ? ` / ${seconds(end)}` : ` / ${end.toFixed(2)} long`),
    );
    this.clock.title = isTimed ? "" : "No time, but the length of the path, at a nominal pace";
    speed.value = String(state.speed);
    this.modes.show(shownPlan, time_s);
    const shown = this.plans.filter(({ index }) => index === state.plan || state.layers.others);
    this.plot.draw(state.plan, shown, time_s);
    if (state.q) {
      this.closest.replaceChildren(element("span", { class: "soft" }, "posed by hand"));
      return;
    }
    const closest = shownPlan?.clearance?.at(time_s);
    this.closest.replaceChildren(
      ...(closest
        ? [
            element("span", { class: "soft" }, "clearance "),
            element("b", {}, millimetres(closest.distance_m)),
            element(
              "div",
              { class: "pair", title: `${closest.first} – ${closest.second}` },
              `${words(closest.first)} – ${words(closest.second)}`,
            ),
          ]
        : [element("span", { class: "soft" }, "clearance not known")]),
    );
  }
}
