import { type Eye, type GraspColour, INITIAL, type Layer, MOST_GHOSTS, type ViewState } from "./view_state.ts";

/**
 * The fragment of an address after `#` that restores a view. It states only differences from the initial view:
 * `fromHash(toHash(view)) = view`, except for motions under way and the item under the pointer. If the page has a
 * motion, the time is always stated, because a page whose address states a time does not play when it opens.
 */
export function toHash(state: ViewState, canPlay = false): string {
  const parts: string[] = [];
  const put = (key: string, value: string | number): void => void parts.push(`${key}=${value}`);
  if (state.plan !== INITIAL.plan) put("plan", state.plan);
  if (canPlay || state.time_s !== INITIAL.time_s) put("t", rounded(state.time_s, 4));
  if (state.speed !== INITIAL.speed) put("speed", state.speed);
  if (state.isLooping) put("loop", 1);
  const layers = Object.keys(INITIAL.layers) as Layer[];
  const on = layers.filter((layer) => state.layers[layer] && !INITIAL.layers[layer]);
  const off = layers.filter((layer) => !state.layers[layer] && INITIAL.layers[layer]);
  if (on.length > 0) put("show", on.join(","));
  if (off.length > 0) put("hide", off.join(","));
  if (state.ghosts !== INITIAL.ghosts) put("ghosts", state.ghosts);
  if (state.treeNodes !== null) put("nodes", state.treeNodes);
  if (state.graspColour !== INITIAL.graspColour) put("by", state.graspColour);
  if (state.q) put("q", state.q.map((value) => rounded(value, 6)).join(","));
  if (state.eye) {
    put("eye", [...state.eye.position, ...state.eye.target].map((value) => rounded(value, 4)).join(","));
  }
  return parts.join("&");
}

/** Decodes a link. Invalid values are omitted, so that a damaged link still shows the scene. */
export function fromHash(hash: string): Partial<ViewState> {
  const asked = new URLSearchParams(hash.replace(/^#/, ""));
  const found: Partial<ViewState> = {};
  const plan = number(asked.get("plan"));
  if (plan !== null && Number.isInteger(plan) && plan >= 0) found.plan = plan;
  const time_s = number(asked.get("t"));
  if (time_s !== null && time_s >= 0) found.time_s = time_s;
  if (asked.has("loop")) found.isLooping = true;
  const speed = number(asked.get("speed"));
  if (speed !== null && speed > 0 && speed <= 100) found.speed = speed;
  if (asked.has("show") || asked.has("hide")) {
    found.layers = { ...INITIAL.layers };
    for (const [key, isShown] of [
      ["show", true],
      ["hide", false],
    ] as const) {
      for (const name of (asked.get(key) ?? "").split(",")) {
        if (Object.hasOwn(INITIAL.layers, name)) found.layers[name as Layer] = isShown;
      }
    }
  }
  const ghosts = number(asked.get("ghosts"));
  if (ghosts !== null && Number.isInteger(ghosts) && ghosts >= 1 && ghosts <= MOST_GHOSTS) found.ghosts = ghosts;
  const nodes = number(asked.get("nodes"));
  if (nodes !== null && Number.isInteger(nodes) && nodes >= 0) found.treeNodes = nodes;
  const by = asked.get("by");
  if (by !== null && COLOURS.includes(by)) found.graspColour = by as GraspColour;
  const q = row(asked.get("q"));
  if (q) found.q = q;
  const eye = row(asked.get("eye"));
  if (eye?.length === 6) {
    found.eye = { position: eye.slice(0, 3) as Eye["position"], target: eye.slice(3) as Eye["target"] };
  }
  return found;
}

const COLOURS: string[] = ["score", "ik", "reason"] satisfies GraspColour[];

function rounded(value: number, digits: number): number {
  return Number(value.toFixed(digits));
}

function number(text: string | null): number | null {
  if (text === null || text.trim() === "") return null;
  const value = Number(text);
  return Number.isFinite(value) ? value : null;
}

function row(text: string | null): number[] | null {
  if (!text) return null;
  const values = text.split(",").map(number);
  return values.every((value) => value !== null) ? values : null;
}
