//! What stands around every view: navigation, who has control, the connection, and the red button.

import { abortTrial, Refused, secrets, status } from "./api/client.ts";
import { Live } from "./api/live.ts";
import { element, fill, say } from "./element.ts";
import { setTheme, theme, type Theme, THEMES } from "./theme.ts";
import { setUnits, type System, units } from "./units.ts";
import { openCommission } from "./views/commission.ts";
import { openControl } from "./views/control.ts";
import { openHistory } from "./views/history.ts";
import { openLive } from "./views/live.ts";
import { news } from "./words.ts";

/** A view on the page. */
export interface View {
  readonly root: HTMLElement;
  /** Lets go of what the view watches. */
  drop(): void;
}

const VIEWS: readonly { readonly route: string; readonly name: string; readonly open: (live: Live) => View }[] = [
  { route: "live", name: "Live", open: openLive },
  { route: "control", name: "Control", open: openControl },
  { route: "commission", name: "Gains", open: openCommission },
  { route: "history", name: "History", open: openHistory },
];

const HOLD_MS = 600;
const ABORT_TRIES = 20;
const ABORT_AGAIN_MS = 500;
const SILENCE_TICK_MS = 1000;

export function openShell(body: HTMLElement): void {
  const live = new Live();
  const main = element("main", { id: "main", tabindex: -1 });
  const subtitle = element("p", { class: "subtitle" });
  const holder = element("span", { class: "badge" });
  const links = VIEWS.map(({ route, name }) => element("a", { href: `#/${route}` }, name));
  const polite = element("div", { class: "unseen", role: "status" });
  const lost = element("div", { class: "lost", role: "alert", hidden: true });
  const loud = element("div", { role: "alert" });
  const abort = abortButton(live, (text) => fill(loud, text === null ? null : element("div", { class: "lost" }, text)));

  fill(
    body,
    element(
      "a",
      { class: "skip", href: "#main", onclick: (event: Event) => (event.preventDefault(), main.focus()) },
      "Skip to the view",
    ),
    element(
      "header",
      { class: "bar" },
      element("div", { class: "brand" }, element("h1", {}, "seatrial"), subtitle),
      element("nav", { "aria-label": "Views" }, ...links),
      holder,
      element("div", { class: "settings" }, themeChoice(), unitsChoice()),
      abort,
    ),
    loud,
    lost,
    main,
    polite,
  );

  let view: View | null = null;
  const show = (): void => {
    const route = location.hash.split("/")[1] ?? "";
    const chosen = VIEWS.find((candidate) => candidate.route === route) ?? VIEWS[0];
    if (chosen === undefined) return;
    view?.drop();
    links.forEach((link, at) =>
      VIEWS[at] === chosen ? link.setAttribute("aria-current", "page") : link.removeAttribute("aria-current"),
    );
    document.title = `${chosen.name} · seatrial`;
    view = chosen.open(live);
    fill(main, view.root);
  };
  addEventListener("hashchange", () => {
    show();
    main.focus({ preventScroll: true });
    scrollTo(0, 0);
  });
  show();

  let gate: HTMLElement | null = null;
  let refusal: string | null = null;
  const draw = (): void => {
    const { trial, control } = live;
    say(
      subtitle,
      live.commission?.running === true
        ? `${live.commission.vehicle} · heading steps`
        : trial === null
          ? "no trial"
          : `${trial.vehicle} · ${trial.configuration}${trial.running ? "" : " · ended"}`,
    );
    say(
      holder,
      control?.holder ? (control.is_you ? "you have control" : `${control.holder} has control`) : "nobody has control",
    );
    holder.className = `badge ${control?.is_you ? "good" : ""}`;
    say(polite, news(live));
    const isLost = live.connection === "lost";
    lost.hidden = !isLost;
    main.classList.toggle("old", isLost);
    if (live.connection === "refused" && (gate === null || refusal !== live.refusal)) {
      refusal = live.refusal;
      gate = tokenGate(live);
      fill(main, gate);
      gate.querySelector("input")?.focus();
    } else if (live.connection === "open" && gate !== null) {
      gate = null;
      show();
    }
  };
  live.watch(draw);
  setInterval(() => {
    if (live.connection === "lost")
      say(lost, `Connection lost. What is shown is ${Math.round(live.silent_for_s())} s old; trying again.`);
  }, SILENCE_TICK_MS);
  draw();
  void enter(live);
}

/** Asks first who we are: a refused token says so in words, while a refused socket says nothing. */
async function enter(live: Live): Promise<void> {
  try {
    await status();
  } catch (error) {
    if (error instanceof Refused && error.code !== "unreachable") {
      live.refuse(error.message);
      return;
    }
  }
  live.open();
}

/** Is there something to abort? */
const runs = (live: Live): boolean => live.trial?.running === true || live.commission?.running === true;

/**
 * The one large red button. It asks for the abort also where the page does not know whether a trial runs, and as soon
 * as it is touched: a thumb that slips off before it is lifted makes no click.
 */
function abortButton(live: Live, tell: (text: string | null) => void): HTMLElement {
  const hint = element("small", { class: "key-hint" });
  const button = element(
    "button",
    {
      class: "abort",
      type: "button",
      onpointerdown: (event: PointerEvent) => void (event.button === 0 && press()),
      // Without a pointer: by keyboard or screen reader.
      onclick: (event: MouseEvent) => void (event.detail === 0 && press()),
    },
    "ABORT",
    hint,
  );
  let busy = false;
  const press = async (): Promise<void> => {
    if (busy || (live.connection === "open" && !runs(live))) return;
    busy = true;
    button.classList.add("held");
    tell(
      live.commission?.running === true
        ? "Aborting: the old gains are put back."
        : "Aborting: the rudder goes neutral, then the heading is held.",
    );
    for (let attempt = 1; attempt <= ABORT_TRIES; attempt += 1) {
      try {
        await abortTrial();
        tell(null);
        break;
      } catch (error) {
        const why = error instanceof Refused ? error.message : String(error);
        tell(`ABORT HAS NOT ARRIVED. Use the vehicle's own switch. ${why}`);
        if (error instanceof Refused && error.code !== "unreachable") break;
        await new Promise((resolve) => setTimeout(resolve, ABORT_AGAIN_MS));
      }
    }
    busy = false;
    button.classList.remove("held");
  };
  const draw = (): void => {
    const running = runs(live);
    button.setAttribute("aria-disabled", String(!running));
    say(hint, running ? "key . or hold Esc" : "nothing is running");
  };
  live.watch(draw);
  draw();

  let held = 0;
  addEventListener("keydown", (event) => {
    if (event.ctrlKey || event.metaKey || event.altKey || event.repeat) return;
    const types = event.target instanceof Element && event.target.matches("input, textarea, select");
    if (event.key === "." && !types) void press();
    if (event.key === "Escape") held = window.setTimeout(() => void press(), HOLD_MS);
  });
  addEventListener("keyup", (event) => {
    if (event.key === "Escape") clearTimeout(held);
  });
  return button;
}

function tokenGate(live: Live): HTMLElement {
  const input = element("input", { type: "password", autocomplete: "current-password", required: true, name: "token" });
  const enterToken = (event: Event): void => {
    event.preventDefault();
    secrets.token = input.value.trim();
    void enter(live);
  };
  return element(
    "form",
    { class: "panel stack", onsubmit: enterToken },
    element("h2", {}, "Token needed"),
    element(
      "p",
      {},
      secrets.token === null
        ? "This server is open to the network. It printed a token for viewers and one for operators when it was first started."
        : `The token was refused. ${live.refusal ?? ""}`,
    ),
    element("label", { class: "field" }, "Token", input),
    element("div", { class: "row" }, element("button", { class: "main", type: "submit" }, "Enter")),
  );
}

function themeChoice(): HTMLElement {
  const options = THEMES.map(([value, name]) => element("option", { value, selected: value === theme() }, name));
  const select = element("select", { onchange: () => setTheme(select.value as Theme) }, ...options);
  return element("label", {}, "Theme", select);
}

function unitsChoice(): HTMLElement {
  const options = (["metric", "nautical"] as const).map((value) =>
    element("option", { value, selected: value === units() }, value),
  );
  const select = element("select", { onchange: () => setUnits(select.value as System) }, ...options);
  return element("label", {}, "Units", select);
}
