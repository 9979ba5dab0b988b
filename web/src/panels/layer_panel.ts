import { element, section } from "./element.ts";
import { type Layer, MOST_GHOSTS, type View, type ViewState } from "../data/view_state.ts";

/** Layers that can be switched, with their keys. */
export const LAYERS: { layer: Layer; label: string; key: string }[] = [
  { layer: "visual", label: "Visual meshes", key: "v" },
  { layer: "collision", label: "Collision shapes", key: "c" },
  { layer: "spheres", label: "Sphere sets", key: "s" },
  { layer: "grasps", label: "Grasps", key: "g" },
  { layer: "allGrasps", label: "Every grasp", key: "e" },
  { layer: "path", label: "Gripper path", key: "p" },
  { layer: "ghosts", label: "Poses on the way", key: "o" },
  { layer: "closest", label: "Closest points", key: "d" },
  { layer: "tree", label: "Search tree", key: "t" },
  { layer: "others", label: "Other plans", key: "a" },
  { layer: "floor", label: "Base area", key: "b" },
  { layer: "places", label: "Places", key: "u" },
  { layer: "glass", label: "See through walls", key: "w" },
];

/** Switches for the layers. */
export class LayerPanel {
  readonly element: HTMLElement;
  private readonly boxes = new Map<Layer, HTMLInputElement>();

  /** `available`: the layers with visible content. */
  constructor(view: View, available: ReadonlySet<Layer>) {
    const rows = LAYERS.filter(({ layer }) => available.has(layer)).map(({ layer, label, key }) => {
      const box = element("input", { type: "checkbox", role: "switch" });
      box.addEventListener("change", () => view.setLayer(layer, box.checked));
      this.boxes.set(layer, box);
      return element("label", { class: "switch" }, box, element("span", {}, label), element("kbd", {}, key));
    });
    const ghosts = element("input", {
      type: "range",
      min: 2,
      max: MOST_GHOSTS,
      step: 1,
      "aria-label": "How many poses",
    });
    const number = element("output", { class: "value" });
    ghosts.addEventListener("input", () => view.set({ ghosts: Number(ghosts.value) }));
    const howMany = element("label", { class: "slider" }, element("span", {}, "How many"), ghosts, number);
    const show = (state: ViewState): void => {
      for (const [layer, box] of this.boxes) box.checked = state.layers[layer];
      howMany.hidden = !state.layers.ghosts || !available.has("ghosts");
      ghosts.value = number.value = String(state.ghosts);
    };
    const after = rows.findIndex(
      (_, index) => LAYERS.filter(({ layer }) => available.has(layer))[index].layer === "ghosts",
    );
    if (after >= 0) rows.splice(after + 1, 0, howMany);
    this.element = section("Show", true, element("div", { class: "rows" }, ...rows));
    view.on(["layers", "ghosts"], show);
    show(view.state);
  }
}
