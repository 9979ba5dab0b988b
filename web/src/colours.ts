import type { Mode } from "./data/page_data.ts";

/** Red, green and blue between 0 and 1, from `#rrggbb`. */
export type Screen = [number, number, number];

const channels = (hex: string): Screen => [
  Number.parseInt(hex.slice(1, 3), 16) / 255,
  Number.parseInt(hex.slice(3, 5), 16) / 255,
  Number.parseInt(hex.slice(5, 7), 16) / 255,
];

const hex = (colour: Screen): string =>
  `#${colour
    .map((value) =>
      Math.round(255 * value)
        .toString(16)
        .padStart(2, "0"),
    )
    .join("")}`;

/** From violet over green to yellow: colour-blind people can distinguish the colours, and greyscale print keeps their
 * order. Cranny's pictures use the same scale. */
export const SCORE_STOPS = ["#4b3ca8", "#3a6fd0", "#2fa1c4", "#3cc88f", "#a6e04a", "#ffe52b"];

/** Colour of unknown values. */
export const UNKNOWN = "#9a9aa2";

/** A score between 0 and 1 as a colour; grey for none. */
export function ofScore(score: number | null): string {
  if (score === null) return UNKNOWN;
  const place = Math.min(Math.max(score, 0), 1) * (SCORE_STOPS.length - 1);
  const index = Math.min(Math.floor(place), SCORE_STOPS.length - 2);
  const [low, high] = [channels(SCORE_STOPS[index]), channels(SCORE_STOPS[index + 1])];
  return hex(low.map((value, i) => value + (high[i] - value) * (place - index)) as Screen);
}

/** Colours of plans, the first as in Cranny's pictures; people with red-green blindness can distinguish them. */
const PLANS = ["#e83f6f", "#2f7de1", "#f0962e", "#12a48b", "#8a5cd6", "#5b6b7f"];

export function ofPlan(index: number): string {
  return PLANS[index % PLANS.length];
}

/** Colour of a stretch of a plan's path: lighter than the plan during lift-off and set-down, darker while the object is
 * carried, slightly darker after it is released; as in Cranny's pictures. */
export function ofMode(plan: string, { holds, touches, leaves }: Pick<Mode, "holds" | "touches" | "leaves">): string {
  const [towards, share] = touches ? ["#ffffff", 0.6] : holds ? ["#201838", 0.6] : leaves ? ["#201838", 0.3] : [plan, 0];
  const [from, to] = [channels(plan), channels(towards)];
  return hex(from.map((value, i) => value + (to[i] - value) * share) as Screen);
}

/** Colour of the result of inverse kinematics for a grasp. */
export function ofIk(status: string): string {
  return (
    { solved: "#2fae6b", "hand-collides": "#e0483e", "out-of-reach": "#e9a13b", "no-solution": "#8a5cd6" }[status] ??
    UNKNOWN
  );
}

/** Reason that gives no information about a grasp. */
export const NOT_TRIED = "not tried";

/** Colours of the reasons that blocked grasps, in the order in which they are counted. */
const REASONS = ["#e0483e", "#e9a13b", "#3a7bd5", "#8a5cd6", "#12a48b", "#c65b9b", "#7f8c3a", "#5b6b7f"];

export function ofReason(index: number): string {
  return index < 0 ? UNKNOWN : REASONS[index % REASONS.length];
}

/** Colours of the tree from the start, and of those from goals. */
const START_TREE = "#2f7de1";
const GOAL_TREES = ["#f0962e", "#e83f6f", "#12a48b", "#8a5cd6", "#d4a017", "#c65b9b"];

export function ofTree(tree: number): string {
  return tree === 0 ? START_TREE : GOAL_TREES[(tree - 1) % GOAL_TREES.length];
}
