"""seatrial and its peers: each makes a model of a record."""

import json
import os
import shutil
import subprocess
import sys
import tempfile
from pathlib import Path

import numpy as np

from models import Hull, Polynomial, StateSpace, in_intervals

HERE = Path(__file__).resolve().parent
sys.path.insert(0, str(HERE.parent / "peers"))
MOST_SAMPLES = 1000
# Samples of a model in samples: its interval is chosen among these shares of the record's length.
INTERVALS = (1000, 500, 250, 125)
RUNS_AWAY = -1.0  # R^2


def seatrial(program, record):
    """What `seatrial identify --json` says, and the models in it by name."""
    with tempfile.TemporaryDirectory() as folder:
        table = Path(folder, "record.csv")
        record.write(table)
        done = subprocess.run([program, "identify", "--json", table], capture_output=True, text=True)
    if not done.stdout.strip():
        return {"outcome": "no answer", "codes": [], "text": done.stderr.strip()}, {}
    answer = json.loads(done.stdout)
    verdict, refined, higher = answer["verdict"], answer.get("refined"), answer.get("higher_order")
    said = {
        "outcome": verdict["outcome"], "codes": [reason["code"] for reason in verdict["reasons"]],
        "text": verdict["reasons"][0]["text"] + " " + verdict["reasons"][0]["detail"], "refined": refined,
        "higher_order": higher,
    }
    if refined is None:
        return said, {}
    # What is handed over behind a lag is the vehicle without its gear.
    gear = higher["model"] if refined["method"] == "rudder_lag" and higher and higher.get("model") else {}
    first = Hull(
        refined["a22_per_s"], refined["b2_per_s2"], refined["c0_rad_per_s2"],
        shift=gear.get("rudder_shift_s", 0.0), lag=gear.get("rudder_lag_s", 0.0),
    )
    predictor = Hull.of(higher["model"]) if higher and higher.get("model") else first
    return said, {"seatrial": predictor, "seatrial, first order": first}


def output_error(record):
    """The two fits of bench/peers/identify.py."""
    import identify

    record = record.thinned(MOST_SAMPLES)
    times = record.time[-1] * np.array([0.01, 0.03, 0.1, 0.3])
    one, two = identify.fits(record.time, record.heading, record.rudder, times)
    a, b, c = one[0].x[:3]
    first = Hull(a, b, c, shift=one[2] * record.h)
    a, b, c, _, _, log_t2, t3 = two[0].x
    second = Hull(a, b, c, shift=two[2] * record.h, lag=float(np.exp(log_t2)), lead=t3)
    return {"output error, 1st order": first, "output error, 2nd order": second}


def best_interval(record, fit):
    """Of models at several intervals, fitted to the first two thirds, the one that predicts the last third; then fitted to all.

    One that then runs away from its own training is passed over.
    """
    from scores import free_run

    cut = 2 * record.time.size // 3
    known, ahead = record.part("known", 0, cut), record.part("ahead", cut, None)
    tried = []
    for interval in intervals(record):
        try:
            model = fit(known, interval)
            tried.append((-np.nan_to_num(free_run(model, ahead)[0], nan=-1e9, neginf=-1e9), interval))
        except (np.linalg.LinAlgError, ValueError, RuntimeError, IndexError):
            continue
    for _, interval in sorted(tried):
        model = fit(record, interval)
        if free_run(model, record)[0] > RUNS_AWAY:
            return model
    return fit(record, min(tried)[1])


def intervals(record):
    wanted = sorted({max(record.h, record.time[-1] / n) for n in INTERVALS})
    return wanted[:-1] if len(wanted) > 3 and record.time.size < 300 else wanted


def arx(record):
    """Least squares of y_k on two past yaw rates and three rudders."""
    return {"ARX": best_interval(record, arx_at)}


def arx_at(record, interval):
    _, _, y, u = in_intervals(record, interval)
    terms = [(("y", 1),), (("y", 2),), (("u", 0),), (("u", 1),), (("u", 2),), ()]
    return polynomial(y, u, interval, terms, np.linalg.lstsq(regressors(y, u, terms), y[2:], rcond=None)[0])


def regressors(y, u, terms, order=2):
    sources = {"y": y, "u": u}
    shifted = lambda name, lag: sources[name][order - lag : y.size - lag]
    return np.stack([np.prod([shifted(*factor) for factor in term] or [np.ones(y.size - order)], axis=0) for term in terms], axis=1)


def polynomial(y, u, interval, terms, theta):
    """A rudder's worth of yaw acceleration, so that the offset is one of acceleration."""
    direct = sum(abs(t) for t, term in zip(theta, terms) if len(term) == 1 and term[0][0] == "u")
    return Polynomial(interval, max(direct / interval, 1e-6), np.asarray(theta), terms)


def narmax(record):
    """SysIdentPy: polynomial NARX of second degree, structure by FROLS."""
    return {"SysIdentPy, NARX": best_interval(record, narmax_at)}


def narmax_at(record, interval):
    import warnings

    from sysidentpy.basis_function import Polynomial as Basis
    from sysidentpy.model_structure_selection import FROLS
    from sysidentpy.parameter_estimation import LeastSquares

    _, _, y, u = in_intervals(record, interval)
    model = FROLS(
        order_selection=True, n_info_values=8, ylag=2, xlag=3, info_criteria="aic", estimator=LeastSquares(),
        basis_function=Basis(degree=2), model_type="NARMAX",
    )
    # Its inputs act from lag 1 on: shifted by one, so that the rudder of the interval itself is among them.
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        model.fit(X=np.append(u[1:], u[-1])[:, None], y=y[:, None])
    terms = [tuple(factor(code) for code in row if code) for row in model.final_model]
    return polynomial(y, u, interval, terms, np.ravel(model.theta))


def factor(code):
    """1002 is y two samples ago; 2001 is the shifted rudder one sample ago, the rudder of now."""
    kind, lag = divmod(int(code), 1000)
    return ("y", lag) if kind == 1 else ("u", lag - 1)


def octave_here():
    return shutil.which("octave") is not None and "moen4" in ask_octave("disp(which('moen4'))")


def ask_octave(script):
    """Output of a script with the package `control`, from wherever Octave finds it."""
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder, "script.m")
        path.write_text("try pkg load control; catch end\n" + script)
        environment = {**os.environ, "OMP_NUM_THREADS": "1"}
        return subprocess.run(
            ["octave", "-q", "--no-gui", path], capture_output=True, text=True, env=environment, timeout=120
        ).stdout


def octave(record):
    """Subspace identification of second order, MOESP and N4SID together, of the package `control`."""
    return {"Octave, moen4": best_interval(record, octave_at)}


def octave_at(record, interval):
    _, _, y, u = in_intervals(record, interval)
    means = y.mean(), u.mean()
    script = (
        f"y = [{' '.join(map(repr, (y - means[0]).tolist()))}]';\nu = [{' '.join(map(repr, (u - means[1]).tolist()))}]';\n"
        f"s = moen4(iddata(y, u, {float(interval)!r}), 'n', 2); printf('%.15g ', s.a', s.b, s.c, s.d);"
    )
    numbers = np.array(ask_octave(script).split(), float)
    if numbers.size != 9:
        raise ValueError("moen4 gave no model")
    a, b, c, d = numbers[:4].reshape(2, 2), numbers[4:6], numbers[6:8], numbers[8]
    return StateSpace(interval, max(abs(c @ b + d) / interval, 1e-6), a, b, c, d, means)


PEERS = {"output error": output_error, "ARX": arx, "SysIdentPy": narmax, "Octave": octave}
NAMES = [
    "seatrial", "seatrial, first order", "output error, 1st order", "output error, 2nd order", "ARX", "SysIdentPy, NARX",
    "Octave, moen4",
]
