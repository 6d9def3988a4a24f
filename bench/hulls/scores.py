"""How well a model predicts a record that it has not seen."""

import numpy as np

import models

MOST_SAMPLES = 800
DRAWS = 200


def r2(measured, predicted):
    return 1.0 - np.sum((measured - predicted) ** 2) / np.sum((measured - measured.mean()) ** 2)


def free_run(model, record):
    """R^2 of heading and of yaw rate over the whole record, with its own start and offset."""
    record = record.thinned(MOST_SAMPLES)
    start = models.own_start(model, record)
    heading, rate = model.run(record, start[:, None])
    return r2(record.heading, heading[:, 0]), r2(record.rate, rate[:, 0])


def windows(record, length_s):
    """Beginnings of windows that follow each other, each at most a third of the record, and their samples."""
    samples = max(8, round(min(length_s, record.time[-1] / 3.0) / record.h))
    return np.arange(samples // 2, record.time.size - samples, samples), samples


def rate_before(record, place):
    """Yaw rate from what was measured until then: over one second or four samples."""
    back = max(4, round(1.0 / record.h))
    part = slice(max(0, place - back), place + 1)
    if record.logged_rate is not None:
        return record.logged_rate[part].mean() if record.h < 0.5 else record.logged_rate[place]
    return np.polyfit(record.time[part], record.heading[part], 1)[0]


def short_runs(model, record, length_s=30.0):
    """Root mean square error of the heading over windows, rad, with the offset of the training; None stands for 'keeps turning as now'."""
    record = record.thinned(4 * MOST_SAMPLES)
    places, samples = windows(record, length_s)
    rates = np.array([rate_before(record, place) for place in places])
    starts = np.stack([record.heading[places], rates, 0.0 * rates])
    measured = np.stack([record.heading[place : place + samples] for place in places], axis=1)
    if model is None:
        predicted = starts[0] + rates * (np.arange(samples) * record.h)[:, None]
    elif isinstance(model, models.Hull):
        acting = model.acting(record)
        ahead = np.stack([acting[place : place + samples] for place in places], axis=1)
        predicted = model.integrate(ahead, record.h, np.vstack([starts, model.states_at(record, places)]))[0]
    else:
        predicted = np.stack([from_here(model, record, starts[:, n], place, samples) for n, place in enumerate(places)], axis=1)
    return float(np.sqrt(np.mean(np.square(np.clip(measured - predicted, -1e3, 1e3)))))


def from_here(model, record, start, place, samples):
    """One window of a model in samples, which goes on from what was measured before."""
    back = min(place, int(np.ceil(10 * model.interval / record.h)))
    past = record.part("past", place - back, place + samples)
    if isinstance(model, models.StateSpace):
        known = record.part("past", place - back, place + 1)
        lead = models.own_start(model, known, rounds=2, offset=False)
        heading = model.run(past, lead[:, None])[0][back:, 0]
        return heading - heading[0] + start[0]
    ahead = record.part("ahead", place, place + samples)
    time, _, _, rudder = model.series(ahead)
    measured = model.series(record.part("past", place - back, place + 1))[2]
    order = max([lag for term in model.terms for _, lag in term], default=1)
    last = np.full(order, start[1])
    last[max(0, order - measured.size):] = measured[-order:] if measured.size else start[1]
    rate = model.rates(rudder[:, None], start[:, None], past=last[:, None])
    return model.on_record(ahead, time, rate, start[:, None])[0][:, 0]


def coverage(hull, covariance, noise_rad, record, seed=1):
    """Share of the measured headings inside the 95 % band of first-order models drawn from the covariance, each with its own start and offset."""
    record = record.thinned(MOST_SAMPLES // 2)
    draws = np.random.default_rng(seed).multivariate_normal([hull.a, hull.b], np.asarray(covariance)[:2, :2], DRAWS)
    draws[:, 0] = np.clip(draws[:, 0], None, 2.0 / record.time[-1])
    headings = with_own_start(*draws.T, record)
    spread = np.sqrt(headings.var(axis=1) + noise_rad**2)
    return float(np.mean(np.abs(record.heading - headings.mean(axis=1)) <= 1.96 * spread))


def with_own_start(a, b, record):
    """Headings of r' = a r + b delta + c, one a column, whose start and c are those of least squares."""
    starts = np.tile(np.array([[0.0, 1.0, 0.0, 0.0], [0.0, 0.0, 1.0, 0.0], [0.0, 0.0, 0.0, 1.0]]), a.size)
    runs = models.Hull(np.repeat(a, 4), np.repeat(b, 4)).run(record, starts)[0].reshape(-1, a.size, 4)
    headings = np.empty(runs.shape[:2])
    for n in range(a.size):
        basis = runs[:, n, 1:] - runs[:, n, :1]
        headings[:, n] = runs[:, n, 0] + basis @ np.linalg.lstsq(basis, record.heading - runs[:, n, 0], rcond=None)[0]
    return headings
