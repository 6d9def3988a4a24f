"""Overshoots of each KVLCC2 record, predicted from the model of each other record. Usage: overshoots.py SEATRIAL FOLDER"""

import json
import subprocess
import sys

seatrial, folder = sys.argv[1:3]
NAMES = ["05_01", "15_01", "25_05", "30_05", "10_10_S", "20_10_P", "20_10_S"]
ORDER = ["first overshoot angle", "second overshoot angle", "third overshoot angle"]


def run(*arguments):
    output = subprocess.run([seatrial, *arguments, "--json"], capture_output=True, text=True)
    if output.returncode not in (0, 4) or not output.stdout:
        return None, output.stderr.strip().splitlines()[-1]
    return json.loads(output.stdout), None


def log(name):
    return f"{folder}/kvlcc2hsva_Z_{name}.csv"


def overshoots(document, angles):
    found = {i["name"]: i for i in document["indices"] if i["manoeuvre"] == f"zig-zag {angles}"}
    return [found[name] for name in ORDER if name in found]


# The zig-zags as they were sailed: rudder and heading change of the read figures.
RECORDS, recorded, models = {}, {}, {}
for name in NAMES:
    document = run("manoeuvres", "read", log(name), "--manoeuvre", "zig-zag")[0]
    RECORDS[name] = document["indices"][0]["manoeuvre"].removeprefix("zig-zag ")
    recorded[name] = overshoots(document, RECORDS[name])
for name in RECORDS:
    document, why = run("identify", log(name))
    models[name] = f"model-{name}.json"
    with open(models[name], "w") as file:
        json.dump(document, file)
totals = {"parameters": [0, 0], "own record": [0, 0]}
near = {"parameters": [0, 0], "own record": [0, 0]}
print("| model of | predicts | recorded, deg | predicted, deg | from the parameters | with the own record |")
print("|---|---|---|---|---|---|")
for own in RECORDS:
    for other, angles in RECORDS.items():
        if own == other:
            continue
        rows = {}
        for kind, options in (("parameters", []), ("own record", ["--own-log", log(own)])):
            options = ["--model", models[own], "--speed", "1.18", "--rudder-limit-deg", "35", "--zig-zag", angles, *options]
            document, why = run("manoeuvres", "predict", *options)
            rows[kind] = (overshoots(document, angles), None) if document else (None, why)
        cells = []
        for kind, (found, why) in rows.items():
            if found is None:
                cells.append(why)
                continue
            pairs = [(a["value"], b["interval_95"]) for a, b in zip(recorded[other], found)]
            held = sum(bool(interval) and interval[0] <= value <= interval[1] for value, interval in pairs)
            totals[kind][0] += held
            totals[kind][1] += len(pairs)
            same_rudder = abs(float(angles.split("/")[0]) - float(RECORDS[own].split("/")[0])) <= 5
            if same_rudder:
                near[kind][0] += held
                near[kind][1] += len(pairs)
            last = pairs[0][1]
            cells.append(f"{held} of {len(pairs)}" + (f" (first: {last[0]:.1f} to {last[1]:.1f})" if last else " (no interval)"))
        found = rows["parameters"][0] or []
        values = lambda indices: ", ".join(f"{i['value']:.1f}" for i in indices)
        print(f"| {own} | {other}, {angles} | {values(recorded[other])} | {values(found)} | {cells[0]} | {cells[1]} |")
print(totals, "rudder within 5 deg:", near)
