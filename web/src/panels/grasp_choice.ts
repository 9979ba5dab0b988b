import { NOT_TRIED } from "../colours.ts";
import type { Grasp, Plan } from "../data/page_data.ts";

/** So many of the best are shown at first: more would hide what they hold, and the hand. */
const BEST = 10;

/**
 * A few grasps, by their places in the list: those that plans end at, and the best; of those that a search has tried
 * in vain before others.
 */
export function fewGrasps(grasps: Grasp[], plans: Plan[]): number[] {
  const taken = new Set(plans.map(({ grasp }) => grasp));
  const blocked = plans.flatMap((plan) => plan.blocked.filter(({ reason }) => reason !== NOT_TRIED));
  const tried = new Set(blocked.map(({ grasp }) => grasp));
  // A score is at most 1.
  const worth = (grasp: Grasp): number => rank(grasp) + (tried.has(grasp.index) ? 10 : 0);
  const order = grasps.map((_, place) => place).sort((a, b) => worth(grasps[b]) - worth(grasps[a]));
  const best = new Set(order.slice(0, BEST));
  return grasps.flatMap(({ index }, place) => (best.has(place) || taken.has(index) ? [place] : []));
}

/** A grasp without a score comes last. */
export function rank({ score }: Grasp): number {
  return score ?? -1;
}
