//! The page that stands alone: a log, or a simulated trial, without a server.

import "../page.css";
import { element, fill } from "../element.ts";
import { FIGURES, openFigure } from "./figures/figure.ts";
import { setTheme, showTheme, theme, type Theme, THEMES } from "../theme.ts";
import { openOwnLog } from "./own.ts";
import { Program } from "./module.ts";
import { openSimulated } from "./simulated.ts";

showTheme();
const program = new Program();
const places = [
  { route: "log", name: "Your log", open: openOwnLog },
  { route: "simulated", name: "A simulated trial", open: openSimulated },
] as const;
const links = places.map(({ route, name }) => element("a", { href: `#${route}` }, name));
const main = element("main", { id: "main", tabindex: -1 });
const themes = element(
  "select",
  { onchange: () => setTheme(themes.value as Theme) },
  ...THEMES.map(([value, name]) => element("option", { value, selected: value === theme() }, name)),
);

/** For scripts on this page: `await seatrial.hold(file)`, `await seatrial.ask({ ask: "identify", log: file.name })`. */
Object.assign(window, { seatrial: program });

const header = element(
  "header",
  { class: "bar" },
  element(
    "div",
    { class: "brand" },
    element("h1", {}, "seatrial"),
    element("p", { class: "subtitle" }, "in this page, without a network"),
  ),
  element("nav", { "aria-label": "Views" }, ...links),
  element("div", { class: "settings" }, element("label", {}, "Theme", themes)),
);
const place = document.getElementById("page") ?? document.body;

let view: { readonly root: HTMLElement; drop(): void } | null = null;
let shown = "";
const show = (): void => {
  const [first, name = "", ground] = location.hash.slice(1).split("/");
  const figure = first === "figure" ? FIGURES[name] : undefined;
  // A figure within a page of the docs has the ground of that page.
  if (figure !== undefined && ground !== undefined) document.documentElement.dataset["theme"] = ground;
  const chosen = places.find(({ route }) => first === route) ?? places[0];
  const wanted = figure === undefined ? chosen.route : `figure/${name}`;
  if (wanted === shown) return;
  shown = wanted;
  view?.drop();
  links.forEach((link, at) =>
    places[at] === chosen ? link.setAttribute("aria-current", "page") : link.removeAttribute("aria-current"),
  );
  view = figure === undefined ? chosen.open(program) : openFigure(program, figure);
  fill(place, figure === undefined && header, main);
  fill(main, view.root);
};
addEventListener("hashchange", show);
show();
// After the first paint.
setTimeout(() => void program.begin(), 100);
