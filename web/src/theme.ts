//! Light, dark and sunlight. The tokens are the report's; sunlight is this page's own.

export type Theme = "system" | "light" | "dark" | "sunlight";

export const THEMES: readonly [Theme, string][] = [
  ["system", "as the system"],
  ["light", "light"],
  ["dark", "dark"],
  ["sunlight", "sunlight"],
];

const KEY = "seatrial.theme";
const watchers = new Set<() => void>();
const system = matchMedia("(prefers-color-scheme: dark)");
system.addEventListener("change", tell);

export function theme(): Theme {
  const kept = localStorage.getItem(KEY);
  return THEMES.find(([name]) => name === kept)?.[0] ?? "system";
}

export function setTheme(to: Theme): void {
  localStorage.setItem(KEY, to);
  showTheme();
}

export function showTheme(): void {
  const now = theme();
  const root = document.documentElement;
  if (now === "system") delete root.dataset["theme"];
  else root.dataset["theme"] = now;
  tell();
}

/** Calls back after each change of the theme; a canvas must be drawn again. */
export function onTheme(callback: () => void): () => void {
  watchers.add(callback);
  return () => watchers.delete(callback);
}

function tell(): void {
  for (const callback of watchers) callback();
}

/** The value of a token, `--a`. */
export function token(name: string): string {
  return getComputedStyle(document.documentElement).getPropertyValue(name).trim();
}
