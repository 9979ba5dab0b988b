import { button, element } from "./element.ts";
import { STANDARD_VIEWS } from "../framing.ts";
import { icon } from "./icons.ts";
import { LAYERS } from "./layer_panel.ts";

const MOTION: [string, string][] = [
  ["space", "Play, pause"],
  ["← →", "A little back or on; with shift, more"],
  ["home end", "Start and end of the path"],
  ["[ ]", "Previous, next plan"],
  [", .", "Previous, next grasp by its score"],
];

const VIEW: [string, string][] = [
  ...STANDARD_VIEWS.map(({ key, name }): [string, string] => [key, `${name} view`]),
  ["l", "Copy a link to this view"],
  ["r", "Record the motion as a video"],
  ["m", "Light or dark"],
  ["h", "Hide or show the panel"],
  ["?", "These keys"],
];

const HANDS: [string, string][] = [
  ["drag", "Turn the view"],
  ["right drag", "Move it (two fingers)"],
  ["wheel", "Nearer, farther (pinch)"],
  ["hover", "What is known of a grasp (tap)"],
];

/** Overview of keys and mouse actions. */
export class Help {
  readonly element: HTMLDialogElement;

  constructor() {
    const part = (title: string, rows: [string, string][]): HTMLElement =>
      element(
        "section",
        {},
        element("h3", {}, title),
        element(
          "dl",
          {},
          ...rows.flatMap(([keys, does]) => [
            element("dt", {}, ...keys.split(" ").map((key) => element("kbd", {}, key))),
            element("dd", {}, does),
          ]),
        ),
      );
    const layers = LAYERS.map(({ key, label }): [string, string] => [key, label]);
    this.element = element(
      "dialog",
      { class: "help", "aria-label": "Keys" },
      button("Close", icon("close"), () => this.element.close()),
      element(
        "div",
        { class: "columns" },
        part("Motion", MOTION),
        part("Hands", HANDS),
        part("View", VIEW),
        part("Show", layers),
      ),
    );
    // A press outside the dialogue closes it.
    this.element.addEventListener("click", (event) => {
      if (event.target === this.element) this.element.close();
    });
  }

  toggle(): void {
    if (this.element.open) this.element.close();
    else this.element.showModal();
  }
}
