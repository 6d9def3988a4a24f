//! Numbers as people read them: degrees always, speed and distance metric or nautical. A value that is missing is a dash.

export type System = "metric" | "nautical";

const KEY = "seatrial.units";
const MISSING = "–";
const KNOT_M_S = 1852 / 3600;
const FOOT_M = 0.3048;
const watchers = new Set<() => void>();

export function units(): System {
  return localStorage.getItem(KEY) === "nautical" ? "nautical" : "metric";
}

export function setUnits(to: System): void {
  localStorage.setItem(KEY, to);
  for (const callback of watchers) callback();
}

export function onUnits(callback: () => void): () => void {
  watchers.add(callback);
  return () => watchers.delete(callback);
}

export type Quantity = "speed" | "distance" | "angle" | "angular_rate" | "share" | "time" | "plain";

interface Scale {
  readonly factor: number;
  readonly unit: string;
}

export function scale(quantity: Quantity): Scale {
  const nautical = units() === "nautical";
  switch (quantity) {
    case "speed":
      return nautical ? { factor: 1 / KNOT_M_S, unit: "kn" } : { factor: 1, unit: "m/s" };
    case "distance":
      return nautical ? { factor: 1 / FOOT_M, unit: "ft" } : { factor: 1, unit: "m" };
    case "angle":
      return { factor: 180 / Math.PI, unit: "°" };
    case "angular_rate":
      return { factor: 180 / Math.PI, unit: "°/s" };
    case "share":
      return { factor: 100, unit: "%" };
    case "time":
      return { factor: 1, unit: "s" };
    case "plain":
      return { factor: 1, unit: "" };
  }
}

/** The value with its unit, to so many significant digits. */
export function shown(value: number | null | undefined, quantity: Quantity, digits = 3): string {
  if (value === null || value === undefined || !Number.isFinite(value)) return MISSING;
  const { factor, unit } = scale(quantity);
  const tight = unit === "" || unit.startsWith("°");
  const scaled = value * factor;
  // A share is not known to less than that.
  const number = unit === "%" && Math.abs(scaled) < 0.05 ? "0" : significant(scaled, digits);
  return `${number}${tight ? "" : "\u00a0"}${unit}`;
}

/** So many significant digits, without an exponent where a person can read it without one. */
export function significant(value: number, digits = 3): string {
  if (!Number.isFinite(value)) return MISSING;
  const size = Math.abs(value);
  if (size !== 0 && (size < 1e-4 || size >= 1e6)) return minus(value.toExponential(digits - 1));
  const decimals = size === 0 ? 0 : Math.max(0, digits - 1 - Math.floor(Math.log10(size)));
  return minus(value.toFixed(Math.min(decimals, 8)));
}

/** The decimals of a value with an interval: two significant digits of half its width, six of the larger bound at most. */
function decimalsOf(low: number, high: number): number {
  const ofWidth = 1 - Math.floor(Math.log10(Math.abs(high - low) / 2));
  const most = 5 - Math.floor(Math.log10(Math.max(Math.abs(low), Math.abs(high))));
  const decimals = Math.min(ofWidth, most);
  return Number.isFinite(decimals) ? Math.min(Math.max(decimals, 0), 9) : 3;
}

/** A value and its bounds with the digits that the interval leaves them. */
export function bounded(value: number, low: number, high: number): [value: string, low: string, high: string] {
  const size = Math.max(Math.abs(low), Math.abs(high));
  const isTiny = size > 0 && size < 1e-4;
  const decimals = decimalsOf(low, high);
  const text = (one: number): string =>
    isTiny || Math.abs(one) >= 1e6 ? significant(one) : minus(one.toFixed(decimals).replace(/^-(?=[0.]*$)/, ""));
  return [text(value), text(low), text(high)];
}

/** "1.20 [1.10, 1.31]". */
export function withInterval(value: number | null | undefined, interval: readonly number[] | null | undefined): string {
  if (value === null || value === undefined || !Number.isFinite(value)) return MISSING;
  const [low, high] = interval ?? [];
  if (low === undefined || high === undefined) return significant(value);
  const [middle, from, to] = bounded(value, low, high);
  return `${middle} [${from}, ${to}]`;
}

/** "1:05" for 65 s. */
export function clock(seconds: number | null | undefined): string {
  if (seconds === null || seconds === undefined || !Number.isFinite(seconds)) return MISSING;
  const whole = Math.max(0, Math.round(seconds));
  return `${Math.floor(whole / 60)}:${String(whole % 60).padStart(2, "0")}`;
}

function minus(text: string): string {
  return text.replace(/^-/, "−").replace("e-", "e−");
}
