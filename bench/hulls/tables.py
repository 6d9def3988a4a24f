"""The tables of the bench in Markdown."""

import datetime

import numpy as np

from methods import NAMES

OURS = NAMES[:2]
PEERS = NAMES[2:]
PERSISTENCE = "keeps turning as now"
GOOD = 0.7  # R^2 of the heading left out with which a model is worth having
LOST = 0.05  # in R^2
ACCEPTED = ("use", "use_with_care")


def clipped(value):
    """R^2, no worse than -1: how far off a useless model is says nothing."""
    return max(-1.0, value) if np.isfinite(value) else -1.0


def score(row, name, measure):
    """Of a method without a model: as useless as any."""
    return clipped(row["scores"].get(name, {}).get(measure, -1.0))


def ratio(row, name):
    """Error of the 30 s runs over that of 'keeps turning as now'."""
    mine = row["scores"].get(name, {}).get("short_deg", np.inf)
    return min(10.0, mine / row["scores"][PERSISTENCE]["short_deg"])


def means(rows, names, measure):
    if measure == "short":
        return {name: -float(np.median([ratio(row, name) for row in rows])) for name in names}
    return {name: float(np.mean([score(row, name, measure) for row in rows])) for name in names}


def ranks(values):
    """1 is the best; equal ones share the mean of their ranks."""
    order = np.array(list(values.values()))
    return {name: float(1 + np.sum(order > value) + 0.5 * (np.sum(order == value) - 1)) for name, value in values.items()}


def table(header, lines):
    return "\n".join(["| " + " | ".join(header) + " |", "|" + "---|" * len(header), *("| " + " | ".join(line) + " |" for line in lines)]) + "\n"


def by_hull(rows, hulls):
    groups = {hull: [row for row in rows if row["hull"] == hull and not row["whole"]] for hull in hulls}
    return {hull: group for hull, group in groups.items() if group}


def score_table(groups, names, measure, digits=3):
    sign = -1.0 if measure == "short" else 1.0
    lines = []
    for hull, rows in groups.items():
        values = means(rows, names, measure)
        best = max(values.values())
        cells = [f"{sign * values[name]:.{digits}f}" for name in names]
        lines.append([hull, str(len(rows)), *(f"**{cell}**" if values[name] == best else cell for name, cell in zip(names, cells))])
    return table(["hull", "pairs", *names], lines)


def rank_table(groups, ours, peers, measure):
    """Ranks among the peers and one of our two models."""
    names = [ours, *peers]
    lines, all_ranks = [], []
    for hull, rows in groups.items():
        got = ranks(means(rows, names, measure))
        all_ranks.append([got[name] for name in names])
        lines.append([hull, *(f"{got[name]:g}" for name in names)])
    mean = np.mean(all_ranks, axis=0)
    lines.append(["**mean rank**", *(f"**{value:.2f}**" for value in mean)])
    first = ", ".join(name for name, value in zip(names, mean) if value == mean.min())
    return table(["hull", *names], lines), first


def verdict_table(groups):
    """How often seatrial's verdict and what its model predicts of the other records go together."""
    lines = []
    for hull, rows in groups.items():
        accepted = [row for row in rows if row["said"]["outcome"] in ACCEPTED]
        refused = [row for row in rows if row["said"]["outcome"] not in ACCEPTED]
        good = lambda group: sum(score(row, "seatrial", "heading") > GOOD for row in group)
        peer = sum(max(score(row, name, "heading") for name in PEERS) > GOOD for row in refused)
        covered = [row["coverage"] for row in rows if "coverage" in row]
        covered_accepted = [row["coverage"] for row in accepted if "coverage" in row]
        share = lambda values: f"{100.0 * np.mean(values):.0f} %" if values else "-"
        lines.append([
            hull, str(good(accepted)), str(len(accepted) - good(accepted)), str(good(refused)), str(len(refused) - good(refused)), str(peer),
            share(covered_accepted), share(covered),
        ])
    header = [
        "hull", f"accepted, R^2 over {GOOD}", "accepted, under", f"refused, R^2 over {GOOD}", "refused, under", f"refused, a peer over {GOOD}",
        "coverage, accepted", "coverage, all",
    ]
    return table(header, lines)


def best_peer(row, measure):
    if measure == "short":
        return min(PEERS, key=lambda name: ratio(row, name))
    return max(PEERS, key=lambda name: score(row, name, measure))


def losses(rows):
    """Pairs in which a peer predicts clearly better, seatrial refuses what a peer predicts, or its 30 s runs lose."""
    lines = []
    for row in rows:
        if row["whole"]:
            continue
        peer = best_peer(row, "heading")
        theirs, ours = score(row, peer, "heading"), max(score(row, name, "heading") for name in OURS)
        short, short_peer = min(ratio(row, name) for name in OURS), best_peer(row, "short")
        kinds = []
        if theirs > GOOD and theirs > ours + LOST:
            kinds.append("loses")
        if theirs > GOOD and row["said"]["outcome"] not in ACCEPTED:
            kinds.append("refuses")
        if ratio(row, short_peer) < 0.95 and ratio(row, short_peer) < 0.9 * short:
            kinds.append("loses 30 s")
        if not kinds:
            continue
        refined = row["said"].get("refined") or {}
        model = f"a22 {refined['a22_per_s']:.3g}, b2 {refined['b2_per_s2']:.3g}" if refined else "-"
        lines.append([
            f"{row['train']} -> {row['test']}", ", ".join(kinds), row["said"]["outcome"].replace("_", " ") + ": " + ", ".join(row["said"]["codes"][:3]),
            model, " / ".join(f"{score(row, name, 'heading'):.2f}" for name in OURS), f"{theirs:.2f} {peer}",
            f"{short:.2f}", f"{ratio(row, short_peer):.2f} {short_peer}",
        ])
    header = ["pair", "what", "verdict", "model handed over", "R^2, both of ours", "best peer", "30 s, ours", "30 s, best peer"]
    return table(header, lines)


def distances(first, second):
    """How far a22 and b2 of two models are apart, in standard deviations of the difference."""
    both = [said["refined"] for said in (first, second)]
    spreads = [np.sqrt(sum(np.asarray(one["covariance"])[n][n] for one in both)) for n in range(2)]
    return [(both[1][key] - both[0][key]) / spread for key, spread in zip(("a22_per_s", "b2_per_s2"), spreads)]


def accepted_apart(groups):
    """Of the accepted models of each hull, the pairs that exclude each other."""
    lines = []
    for hull, rows in groups.items():
        said = {row["train"]: row["said"] for row in rows if row["said"]["outcome"] in ACCEPTED}
        names = sorted(said)
        pairs = [distances(said[one], said[other]) for n, one in enumerate(names) for other in names[n + 1 :]]
        if pairs:
            worst = np.max(np.abs(pairs), axis=1)
            lines.append([hull, str(len(names)), f"{np.sum(worst > 1.96)} of {len(pairs)}", f"{np.median(worst):.1f}"])
    return table(["hull", "accepted", "pairs more than 1.96 apart", "median distance"], lines)


def contradictions(rows):
    """Halves of one record whose intervals of a22 or b2 exclude each other."""
    halves = {(row["hull"], row["train"]): row["said"] for row in rows if row["train"].endswith("half")}
    lines, count = [], 0
    for (hull, name), first in halves.items():
        second = halves.get((hull, name.replace("1st", "2nd")))
        if not name.endswith("1st half") or not second or not (first.get("refined") and second.get("refined")):
            continue
        count += 1
        distance = distances(first, second)
        if max(map(abs, distance)) > 1.96:
            text = lambda said: f"{said['refined']['a22_per_s']:.3g}, {said['refined']['b2_per_s2']:.3g}"
            lines.append([name.removesuffix(" 1st half"), first["outcome"].replace("_", " "), second["outcome"].replace("_", " "),
                          text(first), text(second), f"{distance[0]:.1f}, {distance[1]:.1f}"])
    said = f"{len(lines)} of {count} records have halves whose models are more than 1.96 standard deviations apart in a22 or b2 (chance: one in ten).\n\n"
    return said + table(["record", "1st half", "2nd half", "a22, b2 of the 1st", "of the 2nd", "distance in a22, b2"], lines)


def whole_records(rows):
    """The verdict on each record as a whole, and its 30 s runs by the model of one half on the other."""
    lines = []
    for row in rows:
        if not row["whole"]:
            continue
        halves = [r for r in rows if not r["whole"] and r["hull"] == row["hull"] and r["train"].startswith(row["train"] + " ")]
        pair = lambda read: ", ".join(f"{read(half):.2f}" for half in halves)
        refined = row["said"].get("refined") or {}
        model = f"{refined['a22_per_s']:.3g}, {refined['b2_per_s2']:.3g}" if refined else "-"
        peers = ", ".join(f"{ratio(half, best_peer(half, 'short')):.2f} {best_peer(half, 'short')}" for half in halves)
        error = PEERS[:2]
        lines.append([row["train"], row["said"]["outcome"].replace("_", " ") + ": " + ", ".join(row["said"]["codes"][:3]), model,
                      pair(lambda half: min(ratio(half, name) for name in OURS)), pair(lambda half: min(ratio(half, name) for name in error)), peers])
    header = ["record", "verdict on the whole", "a22, b2", "30 s, ours", "30 s, output error", "30 s, best peer"]
    return table(header, lines)


def document(rows, hulls, with_octave):
    groups = by_hull(rows, hulls)
    peers = [name for name in PEERS if with_octave or not name.startswith("Octave")]
    names = [*OURS, *peers]
    # In the mean over hulls each hull weighs the same.
    parts = [
        f"{len({(r['hull'], r['train']) for r in rows})} records or halves trained on, {sum(not r['whole'] for r in rows)} pairs, "
        f"{datetime.date.today()}."
        + ("" if with_octave else " Octave's package `control` was not installed: skipped.") + "\n",
        "## R^2 of the heading left out, mean over the pairs\n", score_table(groups, names, "heading"),
        "## R^2 of the yaw rate left out, mean over the pairs\n", score_table(groups, names, "rate"),
        "## Error of 30 s runs over that of 'keeps turning as now', median over the pairs\n", score_table(groups, names, "short", 2),
    ]
    for ours in OURS:
        for measure, word in (("heading", "heading"), ("rate", "yaw rate"), ("short", "30 s runs")):
            text, first = rank_table(groups, ours, peers, measure)
            parts += [f"## Ranks by {word}: {ours} among the peers\n", f"First in the mean: {first}.\n", text]
    parts += [
        "## Verdict and prediction\n", verdict_table(groups),
        "## Records as a whole\n", whole_records(rows), "## Halves that contradict each other\n", contradictions(rows),
        "## Accepted models of one hull that contradict each other\n", accepted_apart(groups),
        "## Losses and refusals\n", losses(rows),
    ]
    return "\n".join(parts)
