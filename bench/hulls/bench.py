"""Trains seatrial and its peers on each record of each hull, predicts the others, and writes the table whoever wins.

    bench.py SEATRIAL OUT.md [--public FOLDER] [--only TEXT]     FOLDER: where the public repositories lie (README.md)

Beside OUT.md stands OUT.jsonl with every pair; an interrupted run goes on from it. SEATRIAL_DATA names the shared data, ../shared/data without it.
"""

import argparse
import json
import multiprocessing
import os
import sys
import time
from pathlib import Path

import numpy as np

import methods
import scores
import tables
from models import Polynomial
from records import HULLS

HERE = Path(__file__).resolve().parent
SHARED = Path(os.environ.get("SEATRIAL_DATA", HERE.parents[2] / "shared/data"))
PERSISTENCE = "keeps turning as now"


def arguments():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("seatrial")
    parser.add_argument("out", type=Path)
    parser.add_argument("--public", type=Path, default=Path("target/hulls"))
    parser.add_argument("--only", default="")
    return parser.parse_args()


def jobs(hulls, roots):
    """Each training record with those that are predicted from it; a record that is cut into halves is also trained on as a whole."""
    found = {hull.name: hull.records(roots) for hull in hulls}
    for hull in hulls:
        records = found[hull.name]
        if not records:
            print(f"{hull.name}: skipped, no record in {' or '.join(map(str, roots))}", file=sys.stderr)
        if len(found.get(hull.same_as, [])) >= len(records):
            continue
        partners = {}
        for one, other in hull.pairs(records):
            partners.setdefault(one.name, (one, []))[1].append(other)
        yield from ((hull.name, one, others) for one, others in partners.values())
        if hull.halves:
            yield from ((hull.name, record, []) for record in records)


def trained(record, program, with_octave):
    """What seatrial says, the models of all methods, and what each fit took, s, or why there is none."""
    said, fitted = methods.seatrial(program, record)
    notes = {}
    for name, fit in methods.PEERS.items():
        if name == "Octave" and not with_octave:
            continue
        begun = time.monotonic()
        try:
            fitted |= fit(record)
            notes[name] = round(time.monotonic() - begun, 2)
        except Exception as problem:  # a peer that fails has lost, and the bench goes on
            notes[name] = f"{type(problem).__name__}: {problem}"
    return said, fitted, notes


def scored(model, record):
    heading, rate = scores.free_run(model, record)
    return {"heading": heading, "rate": rate, "short_deg": np.degrees(scores.short_runs(model, record))}


def work(job):
    program, with_octave, (hull, record, others) = job
    if not others:
        said, _ = methods.seatrial(program, record)
        return [{"hull": hull, "train": record.name, "whole": True, "said": said, "source": record.source}]
    said, fitted, notes = trained(record, program, with_octave)
    rows = []
    for other in others:
        row = {"hull": hull, "train": record.name, "test": other.name, "whole": False, "said": said, "source": record.source, "notes": notes}
        row["scores"] = {name: scored(model, other) for name, model in fitted.items()}
        row["scores"][PERSISTENCE] = {"short_deg": np.degrees(scores.short_runs(None, other))}
        row["models"] = {name: description(model) for name, model in fitted.items()}
        if said.get("refined"):
            refined = said["refined"]
            row["coverage"] = scores.coverage(fitted["seatrial, first order"], refined["covariance"], refined["heading_noise_rad"], other)
        rows.append(row)
    return rows


def description(model):
    """The numbers of a model, for the file of pairs."""
    known = {key: value for key, value in vars(model).items() if isinstance(value, (float, np.floating)) and value != 0.0}
    text = {key: f"{value:.4g}" for key, value in known.items()}
    if isinstance(model, Polynomial):
        factors = [" ".join(f"{name}(k-{lag})" for name, lag in term) for term in model.terms]
        text["y(k)"] = " + ".join(f"{theta:.4g} {term}".strip() for theta, term in zip(model.theta, factors))
    return text


def main():
    options = arguments()
    hulls = [hull for hull in HULLS if options.only in hull.name]
    with_octave = methods.octave_here()
    log = options.out.with_suffix(".jsonl")
    rows = [json.loads(line) for line in log.read_text().splitlines()] if log.exists() else []
    done = {(row["hull"], row["train"]) for row in rows}
    todo = [(options.seatrial, with_octave, job) for job in jobs(hulls, [SHARED, options.public])]
    todo = [job for job in todo if (job[2][0], job[2][1].name) not in done]
    begun = time.monotonic()
    with multiprocessing.Pool(2) as pool, open(log, "a") as file:
        for n, result in enumerate(pool.imap_unordered(work, todo), 1):
            rows += result
            file.writelines(json.dumps(row) + "\n" for row in result)
            file.flush()
            print(f"{n} of {len(todo)}, {time.monotonic() - begun:.0f} s: {result[0]['hull']}, {result[0]['train']}", file=sys.stderr, flush=True)
    if not rows:
        sys.exit("no record found")
    rows.sort(key=lambda row: (row["hull"], row["train"], row.get("test", "")))
    options.out.write_text(tables.document(rows, [hull.name for hull in hulls], with_octave))


if __name__ == "__main__":
    main()
