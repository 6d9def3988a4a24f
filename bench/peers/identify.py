"""Output error of first and second order with a search for the rudder's lag, as a competent person writes it with scipy.

    identify.py RECORD.csv        columns time, heading, rudder (s, rad, rad), in this order of a header's first three of these kinds

Prints one line of JSON: the parameters, their standard deviations and R^2 of each order at its best lag.
"""

import csv
import json
import sys

import numpy as np
from scipy import optimize, signal

NAMES = {
    "time": ("t", "time_s", "time"),
    "heading": ("yaw", "heading_rad", "psi", "heading"),
    "rudder": ("rudder", "rudder_rad", "delta"),
}


def read(path):
    with open(path, newline="") as file:
        header = next(csv.reader(file))
        columns = [next(header.index(n) for n in names if n in header) for names in NAMES.values()]
        rows = np.loadtxt(file, delimiter=",", usecols=columns)
    time, heading, rudder = rows.T
    return time - time[0], np.unwrap(heading), rudder


def delayed(rudder, samples):
    return np.concatenate([np.full(samples, rudder[0]), rudder[: rudder.size - samples]])


def heading_of(rate_input, pole, h, heading, rate):
    """psi of r' = a r + input, the input held between samples."""
    decay = np.exp(pole * h)
    gain = (decay - 1.0) / pole if abs(pole) > 1e-9 else h
    r, _ = signal.lfilter([0.0, gain], [1.0, -decay], rate_input, zi=[rate - 0.0 * gain])
    r = np.concatenate([[rate], r[1:]]) if r.size else r
    return heading + np.concatenate([[0.0], np.cumsum(0.5 * h * (r[1:] + r[:-1]))])


def first_order(theta, rudder, h):
    a, b, c, heading, rate = theta
    return heading_of(b * rudder + c, a, h, heading, rate)


def second_order(theta, rudder, h):
    """The rudder passes (1 + T3 s) / (1 + T2 s) before the first-order vehicle."""
    a, b, c, heading, rate, log_t2, t3 = theta
    t2 = np.exp(log_t2)
    decay = np.exp(-h / t2)
    slow, _ = signal.lfilter([0.0, 1.0 - decay], [1.0, -decay], rudder, zi=[rudder[0]])
    acting = slow + t3 / t2 * (rudder - slow)
    return heading_of(b * acting + c, a, h, heading, rate)


def fit(model, start, heading, rudder, h, scale):
    found = optimize.least_squares(
        lambda theta: model(theta, rudder, h) - heading, start, x_scale=scale, method="trf"
    )
    spread = 2.0 * found.cost / (heading.size - len(start))
    deviation = np.sqrt(np.diag(np.linalg.pinv(found.jac.T @ found.jac)) * spread)
    return found, deviation


def best_lag(model, start, heading, rudder, h, scale, lags):
    best = None
    for lag in lags:
        found, deviation = fit(model, start, heading, delayed(rudder, lag), h, scale)
        start = found.x
        if best is None or found.cost < best[0].cost:
            best = found, deviation, lag
    return best


def fits(time, heading, rudder, time_constants=()):
    """First and second order, each at its best lag: (result of scipy, deviations, lag in samples).

    The search begins at the least squares of the differences, or at whichever of `time_constants` fits best without a lag.
    """
    h = np.median(np.diff(time))
    rate = np.gradient(heading, h)
    phi = np.stack([rate[:-1], rudder[:-1], np.ones(rate.size - 1)])
    a, b, c = np.linalg.lstsq(phi.T, np.diff(rate) / h, rcond=None)[0]
    a = min(a, -2.0 / time[-1])
    start = np.array([a, b, c, heading[0], rate[0]])
    scale = np.array([abs(a), abs(b) + 1e-6, abs(b) * np.abs(rudder).max() + 1e-6, 0.1, 0.1 * abs(a)])
    starts = [start] + [np.array([-1.0 / t, b, c, heading[0], rate[0]]) for t in time_constants]
    if len(starts) > 1:
        tried = [fit(first_order, one, heading, rudder, h, scale)[0] for one in starts]
        start = min(tried, key=lambda found: found.cost).x
    # Up to half a second or eight samples, whichever is more.
    lags = range(0, 6)
    one = best_lag(first_order, start, heading, rudder, h, scale, lags)
    two_start = np.concatenate([one[0].x, [np.log(0.3 / abs(one[0].x[0])), 0.15 / abs(one[0].x[0])]])
    two_scale = np.concatenate([scale, [1.0, 1.0 / abs(one[0].x[0])]])
    two = best_lag(second_order, two_start, heading, rudder, h, two_scale, lags)
    return one, two


def identify(path):
    time, heading, rudder = read(path)
    h = np.median(np.diff(time))
    one, two = fits(time, heading, rudder)
    answers = {}
    for name, (found, deviation, lag) in (("first", one), ("second", two)):
        variance = np.var(heading) * heading.size
        answers[name] = {
            "theta": found.x.tolist(),
            "deviation": deviation.tolist(),
            "lag_s": lag * h,
            "r2": 1.0 - 2.0 * found.cost / variance,
            "evaluations": int(found.nfev),
        }
    return answers


if __name__ == "__main__":
    print(json.dumps(identify(sys.argv[1])))
