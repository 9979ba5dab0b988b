import { NOT_TRIED } from "../colours.ts";
import type { Grasp, Plan } from "../data/page_data.ts";

/** Number of best grasps that are shown at first: more would hide the object and the hand. */
const BEST = 10;

/** List positions of a few grasps: those at which plans end, and the best, with priority for grasps that a search has
 * tried without success. */
export function fewGrasps(grasps: Grasp[], plans: Plan[]): number[] {
  const taken = new Set(plans.map(({ grasp }) => grasp));
  const blocked = plans.flatMap((plan) => plan.blocked.filter(({ reason }) => reason !== NOT_TRIED));
  const tried = new Set(blocked.map(({ grasp }) => grasp));
  // Scores are at most 1, so 10 puts tried grasps first.
  const worth = (grasp: Grasp): number => rank(grasp) + (tried.has(grasp.index) ? 10 : 0);
  const order = grasps.map((_, place) => place).sort((a, b) => worth(grasps[b]) - worth(grasps[a]));
  const best = new Set(order.slice(0, BEST));
  return grasps.flatMap(({ index }, place) => (best.has(place) || taken.has(index) ? [place] : []));
}

/** Sorting key; a grasp without a score comes last. */
export function rank({ score }: Grasp): number {
  return score ?? -1;
}
