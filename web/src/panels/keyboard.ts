import { STANDARD_VIEWS, type StandardView } from "../framing.ts";
import { LAYERS } from "./layer_panel.ts";
import type { Player } from "../motion/player.ts";
import type { Layer, View } from "../data/view_state.ts";

/** Change of time per arrow key, in seconds. */
const STEP_S = 0.05;
const LARGE_STEP_S = 0.5;

export interface KeyActions {
  look(view: StandardView): void;
  stepGrasp(by: number): void;
  copyLink(): void;
  record(): void;
  toggleTheme(): void;
  togglePanel(): void;
  toggleHelp(): void;
}

/** Handles keys regardless of focus, unless the focused element uses the key itself. */
export function listenToKeys(
  view: View,
  player: Player,
  plans: number,
  available: ReadonlySet<Layer>,
  actions: KeyActions,
): void {
  const step = (event: KeyboardEvent, direction: number): void =>
    player.seek(view.state.time_s + direction * (event.shiftKey ? LARGE_STEP_S : STEP_S));
  const choose = (by: number): void => {
    if (plans > 1) view.set({ plan: (view.state.plan + by + plans) % plans, q: null, treeNodes: null });
  };
  const keys: Record<string, (event: KeyboardEvent) => void> = {
    " ": () => player.toggle(),
    ArrowLeft: (event) => step(event, -1),
    ArrowRight: (event) => step(event, 1),
    Home: () => player.seek(0),
    End: () => player.seek(player.duration_s),
    "[": () => choose(-1),
    "]": () => choose(1),
    ",": () => actions.stepGrasp(-1),
    ".": () => actions.stepGrasp(1),
    l: () => actions.copyLink(),
    r: () => actions.record(),
    m: () => actions.toggleTheme(),
    h: () => actions.togglePanel(),
    "?": () => actions.toggleHelp(),
  };
  for (const standard of STANDARD_VIEWS) keys[standard.key] = () => actions.look(standard);
  for (const { layer, key } of LAYERS) {
    if (available.has(layer)) keys[key] = () => view.setLayer(layer, !view.state.layers[layer]);
  }
  document.addEventListener("keydown", (event) => {
    const action = Object.hasOwn(keys, event.key) ? keys[event.key] : undefined;
    if (!action || event.ctrlKey || event.metaKey || event.altKey || event.defaultPrevented) return;
    if (isMeantElsewhere(event)) return;
    event.preventDefault();
    action(event);
  });
}

/** Whether an element uses the key itself: sliders and selections use arrows, buttons space, dialogues all but `?`. */
function isMeantElsewhere({ key, target }: KeyboardEvent): boolean {
  const at = target as HTMLElement | null;
  if (document.querySelector("dialog[open]")) return key !== "?";
  if (at instanceof HTMLSelectElement) return [" ", "ArrowLeft", "ArrowRight", "Home", "End"].includes(key);
  if (at instanceof HTMLInputElement && at.type === "radio") return ["ArrowLeft", "ArrowRight"].includes(key);
  if (at instanceof HTMLInputElement && at.type === "range") {
    // On the time line, these keys already have the intended effect.
    return !at.classList.contains("scrub") && ["ArrowLeft", "ArrowRight", "Home", "End"].includes(key);
  }
  return key === " " && at !== null && at.closest("button, input, summary") !== null;
}
