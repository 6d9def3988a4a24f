"""Measures what a person waits for, each beside its peer in the same rounds, and writes the table.

    measure.py SEATRIAL OUT.md [BEFORE]     BEFORE is another seatrial binary, whose times stand beside

Processor time (user and system, all threads) and time by the clock of whole commands, the least of the rounds: what else the machine
does only adds. Logs are made by make.py. Peers run in the Python that REFBENCH_PYTHON names (numpy, scipy, pymavlink); without it they
are left out. Exits with 1 where a goal is missed.
"""

import os
import resource
import subprocess
import sys
import tempfile
import time
from pathlib import Path

HERE = Path(__file__).resolve().parent
ROUNDS = int(os.environ.get("ROUNDS", "5"))
DATA = Path(os.environ.get("SEATRIAL_DATA", HERE.parents[2] / "shared/data"))
ZIG_ZAG = DATA / "real/kvlcc2hsva_Z_20_10_P.csv"


def run(command):
    """Processor time and time by the clock, s."""
    before, started = resource.getrusage(resource.RUSAGE_CHILDREN), time.monotonic()
    done = subprocess.run(command, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True)
    clock = time.monotonic() - started
    after = resource.getrusage(resource.RUSAGE_CHILDREN)
    # 3 and 4 say that a model is not to be used: an answer, too.
    if done.returncode not in (0, 3, 4):
        sys.exit(f"{' '.join(map(str, command))}: {done.returncode}\n{done.stderr}")
    return after.ru_utime - before.ru_utime + after.ru_stime - before.ru_stime, clock


def least(commands):
    """Of each command the least processor time and the least time by the clock, by turns in every round; what takes over 5 s runs once."""
    times = {name: [] for name in commands}
    for _ in range(ROUNDS):
        for name, command in commands.items():
            if not times[name] or times[name][0][1] < 5.0:
                times[name].append(run(command))
    return {name: tuple(min(part) for part in zip(*of)) for name, of in times.items()}


def made(folder, kind, size, name):
    path = folder / name
    subprocess.run([sys.executable, HERE / "make.py", kind, path, str(size)], check=True)
    return path


def log_commands(binaries, log, window):
    """Each binary's `identify` and `inspect` of a log, and the reading: the same log with a window of one manoeuvre."""
    commands = {}
    for name, binary in binaries.items():
        commands[f"{name} identify"] = [binary, "identify", log]
        commands[f"{name} inspect"] = [binary, "inspect", log]
        commands[f"{name} reading"] = [binary, "identify", log, "--from", window[0], "--to", window[1]]
    return commands


class Table:
    def __init__(self):
        self.lines, self.missed = [], []

    def head(self, title, columns):
        self.lines += ["", f"## {title}", "", "| " + " | ".join(columns) + " |", "|---" * len(columns) + "|"]

    def row(self, *cells):
        self.lines.append("| " + " | ".join(cells) + " |")

    def goal(self, what, found, most):
        is_met = found <= most
        if not is_met:
            self.missed.append(what)
        self.lines += ["", f"{what}: {found:.2f}, goal at most {most}: {'met' if is_met else 'missed'}."]


def ms(seconds):
    return f"{1000 * seconds:.0f}"


def of_a_trial(table, binaries, folder, python):
    log = made(folder, "bin", 62, "trial.BIN")
    commands = log_commands(binaries, log, ("149.87", "173.13"))
    if python:
        part = made(folder, "bin", 6, "part.BIN")
        commands["pymavlink, reading a log of 6 MB"] = [python, HERE.parent / "read.py", part]
    times = least(commands)
    table.head("A DataFlash log of 62 MB, a trial of five speeds, no option", ["command", "processor, ms", "clock, ms"])
    for name, (processor, clock) in times.items():
        table.row(name, ms(processor), ms(clock))
    of = {name: processor for name, (processor, _) in times.items()}
    table.goal("`identify` over `inspect`, processor", of["seatrial identify"] / of["seatrial inspect"], 2.0)
    table.goal("`identify` over reading, processor", of["seatrial identify"] / of["seatrial reading"], 2.0)
    clock = times["seatrial identify"][1] / times["seatrial reading"][1]
    table.goal("`identify` over reading, clock", clock, 2.0)


def of_growing_logs(table, binaries, folder):
    for kind, title in (("csv", "manoeuvres at five speeds"), ("random", "a rudder by chance, without manoeuvres")):
        table.head(
            f"CSV of {title}",
            ["rows", *(f"{name} {verb}, ms" for name in binaries for verb in ("identify", "reading")), "identify, us a row"],
        )
        for rows in (300, 3_000, 30_000, 300_000, 1_000_000):
            log = made(folder, kind, rows, "growing.csv")
            end = (rows - 1) * 0.05
            commands = log_commands(binaries, log, (f"{max(0.0, end - 40.0):.2f}", f"{end:.2f}"))
            times = least({name: of for name, of in commands.items() if not name.endswith("inspect")})
            each = [ms(times[f"{name} {verb}"][0]) for name in binaries for verb in ("identify", "reading")]
            own = times["seatrial identify"][0]
            table.row(f"{rows:,}", *each, f"{1e6 * own / rows:.2f}")
            if rows == 1_000_000:
                ratio = own / times["seatrial reading"][0]
                table.last = ratio
        table.goal(f"`identify` of a million rows over reading them, {title}, processor", table.last, 3.0)


def of_the_zig_zag(table, binaries, python):
    if not ZIG_ZAG.exists():
        table.lines += ["", f"Without {ZIG_ZAG.name}, the zig-zag was not measured."]
        return
    commands = {f"{name} identify": [binary, "identify", ZIG_ZAG] for name, binary in binaries.items()}
    if python:
        commands["scipy, output error of two orders at six lags"] = [python, HERE.parent / "peers/identify.py", ZIG_ZAG]
        commands["scipy, imports alone"] = [python, "-c", "import csv, json, numpy; from scipy import optimize, signal"]
    times = least(commands)
    table.head("The zig-zag of 3,801 rows (KVLCC2, SIMMAN 2008)", ["command", "processor, ms", "clock, ms"])
    for name, (processor, clock) in times.items():
        table.row(name, ms(processor), ms(clock))
    if python:
        of = {name: processor for name, (processor, _) in times.items()}
        scipy = of["scipy, output error of two orders at six lags"]
        table.goal("`identify` over scipy, processor", of["seatrial identify"] / scipy, 0.2)


def of_many(table, binaries, folder):
    log = made(folder, "csv", 30_000, "many.csv")
    logs = folder / "logs"
    logs.mkdir()
    for k in range(8):
        (logs / f"{k}.csv").write_bytes(log.read_bytes())
    table.head("Many manoeuvres", ["command", "processor, ms", "clock, ms", "a minute by processor, of two"])
    # What `fleet` says of these logs: 28 manoeuvres each.
    for name, binary in binaries.items():
        out = folder / "fleet.parquet"
        commands = {
            f"{name} fleet, two workers": [binary, "fleet", "--out", out, "--workers", "2", logs],
            f"{name} fleet, one worker": [binary, "fleet", "--out", out, "--workers", "1", logs],
        }
        for command, (processor, clock) in least(commands).items():
            table.row(command, ms(processor), ms(clock), f"{2 * 60 * 8 * 28 / processor:,.0f} manoeuvres")
        # Beside the other, as `cargo build --release` leaves it.
        lab = Path(binary).with_name("seatrial-lab")
        study = [lab, "estimators", "--runs", "200", "--noise-deg", "0.5", "--disturbance", "0"]
        processor, clock = least({"study": study})["study"]
        table.row(f"{name}-lab estimators, a cell of 200 runs", ms(processor), ms(clock), f"{2 * 60 * 200 / processor:,.0f} runs")


def main():
    seatrial, out = sys.argv[1], Path(sys.argv[2])
    binaries = {"seatrial": seatrial}
    if len(sys.argv) > 3:
        binaries["before"] = sys.argv[3]
    python = os.environ.get("REFBENCH_PYTHON")
    table = Table()
    with tempfile.TemporaryDirectory() as folder:
        folder = Path(folder)
        of_a_trial(table, binaries, folder, python)
        of_growing_logs(table, binaries, folder)
        of_the_zig_zag(table, binaries, python)
        of_many(table, binaries, folder)
    head = [
        "# What a person waits for",
        "",
        f"Least of {ROUNDS} rounds; `reading` is `identify --from A --to B` of one manoeuvre, which reads the whole log.",
    ]
    out.write_text("\n".join(head + table.lines) + "\n")
    print(out)
    if table.missed:
        sys.exit("missed: " + "; ".join(table.missed))


if __name__ == "__main__":
    main()
