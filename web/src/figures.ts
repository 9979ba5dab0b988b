/** Formats numbers for people. */

export function seconds(time_s: number): string {
  return `${time_s.toFixed(2)} s`;
}

/** Progress along a plan: seconds, or the travelled length if the path has no timing. */
export function progress(time_s: number, isTimed: boolean): string {
  return isTimed ? seconds(time_s) : `length ${time_s.toFixed(2)}`;
}

/** A clearance, which is a lower bound and therefore rounded down. */
export function millimetres(clearance_m: number): string {
  const mm = 1000 * clearance_m;
  const digits = Math.abs(mm) < 10 ? 2 : Math.abs(mm) < 100 ? 1 : 0;
  const nearest = mm.toFixed(digits);
  const text = Number(nearest) / 1000 > clearance_m ? (Number(nearest) - 10 ** -digits).toFixed(digits) : nearest;
  return `${text.replace("-", "−")} mm`;
}

export function score(value: number | null): string {
  return value === null ? "—" : value.toFixed(2);
}

/** An integer with a thin space between thousands. */
export function count(value: number): string {
  return value.toString().replace(/\B(?=(\d{3})+$)/g, "\u2009");
}

/** Value of a joint in degrees or metres. */
export function jointValue(kind: "revolute" | "prismatic", value: number): string {
  const text = kind === "revolute" ? `${((value * 180) / Math.PI).toFixed(1)}°` : `${value.toFixed(3)} m`;
  // Zero has no minus sign.
  return text.replace(/^-(?=[0.]+(°| m)$)/, "").replace("-", "−");
}

/** Converts "hand-collides" to words. */
export function words(name: string): string {
  return name.replace(/[-_]+/g, " ");
}
