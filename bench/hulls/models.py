"""Fitted models and their free run: heading and yaw rate from the rudder alone, and a start.

A start is a column of [psi, r, offset, the model's further states ...]; `run` takes several columns at once. The offset is an
acceleration, rad/s^2, added to the model's own.
"""

from dataclasses import dataclass, field

import numpy as np

STEPS_A_TIME_CONSTANT = 8.0


def exact(a, h):
    """For r' = a r + push over h: decay, what a push adds to r, and what it adds to the heading."""
    x = np.where(np.abs(a * h) < 1e-7, 1e-7, a * h)
    decay = np.exp(np.minimum(x, 50.0))
    return decay, h * np.expm1(np.minimum(x, 50.0)) / x, h * h * (np.expm1(np.minimum(x, 50.0)) - x) / (x * x)


def moved(r, push, step):
    """Turned angle and new yaw rate."""
    decay, gain, rise = step
    return gain * r + rise * push, decay * r + gain * push


@dataclass
class Hull:
    """r' = (a - d2 |r|) r + k v + b act + c,  v' = r + a11 v,  psi' = r, behind a steering gear; Nomoto's models are among these."""

    a: float  # or an array, of as many as there are starts; b, too
    b: float
    c: float = 0.0
    d2: float = 0.0
    k: float = 0.0
    a11: float = 0.0
    shift: float = 0.0  # s; the rudder acts so much later than logged
    lag: float = 0.0  # s; (1 + lead s)/(1 + lag s)
    lead: float = 0.0
    rate_limit: float | None = None  # rad/s
    play: float | None = None  # rad, from stop to stop

    @classmethod
    def of(cls, m):
        """The model that seatrial hands over."""
        return cls(
            m["a22_per_s"], m["b2_per_s2"], m["c0_rad_per_s2"], m["quadratic_per_rad"], m["a21_per_s2"], m["a11_per_s"],
            m["rudder_shift_s"], m["rudder_lag_s"], rate_limit=m["rate_limit_rad_s"], play=m["play_rad"],
        )

    @property
    def further_states(self):
        return 0 if self.k == 0.0 else 1

    def acting(self, record):
        rudder = np.interp(record.time - self.shift, record.time, record.rudder)
        if self.play:
            rudder = behind_play(rudder, 0.5 * self.play)
        if self.lag <= 0.0 and self.rate_limit is None:
            return rudder
        slow = gear(rudder, record.h, self.lag, self.rate_limit)
        return slow + (self.lead / self.lag * (rudder - slow) if self.lag > 0.0 else 0.0)

    def run(self, record, start, begin=0, end=None):
        return self.integrate(self.acting(record)[begin:end, None], record.h, start)

    def integrate(self, acting, h, start):
        """Exact for first order, by the midpoint rule in short steps otherwise."""
        plain = self.k == 0.0 and self.d2 == 0.0
        steps = 1 if plain else min(20, max(1, int(np.ceil(h * STEPS_A_TIME_CONSTANT * (abs(self.a) + abs(self.a11) + abs(self.k) ** 0.5)))))
        g = h / steps
        psi, r = np.array(start[0], float), np.array(start[1], float)
        v = np.array(start[3], float) if self.further_states else np.zeros_like(r)
        heading, rate = np.empty((len(acting), r.size)), np.empty((len(acting), r.size))
        linear = exact(self.a, g)
        for i, push in enumerate(self.b * acting + self.c + start[2]):
            heading[i], rate[i] = psi, r
            for _ in range(steps):
                if plain:
                    turned, r = moved(r, push, linear)
                else:
                    half = r + 0.5 * g * ((self.a - self.d2 * np.abs(r)) * r + self.k * v + push)
                    half_v = v + 0.5 * g * (r + self.a11 * v)
                    turned = g * half
                    r = r + g * ((self.a - self.d2 * np.abs(half)) * half + self.k * half_v + push)
                    v = v + g * (half + self.a11 * half_v)
                psi, r = psi + turned, np.minimum(np.maximum(r, -1e3), 1e3)
        return heading, rate

    def states_at(self, record, places):
        """v as the measured yaw rate leaves it."""
        if not self.further_states:
            return np.zeros((0, len(places)))
        v, decay = np.zeros(record.time.size), np.exp(self.a11 * record.h)
        gain = record.h if self.a11 == 0.0 else (decay - 1.0) / self.a11
        for i in range(1, v.size):
            v[i] = decay * v[i - 1] + gain * record.rate[i - 1]
        return v[None, places]


def gear(command, h, lag, rate_limit):
    """First-order lag with a largest rate."""
    share = 1.0 if lag <= 0.0 else 1.0 - np.exp(-h / lag)
    most = np.inf if rate_limit is None else rate_limit * h
    angle = np.empty_like(command)
    angle[0] = command[0]
    for i in range(1, command.size):
        angle[i] = angle[i - 1] + np.clip(share * (command[i - 1] - angle[i - 1]), -most, most)
    return angle


def behind_play(command, half):
    angle = np.empty_like(command)
    angle[0] = command[0]
    for i in range(1, command.size):
        angle[i] = np.clip(angle[i - 1], command[i] - half, command[i] + half)
    return angle


@dataclass
class Discrete:
    """A model in samples: yaw rate y and rudder u, each the mean over `every` samples of the record.

    The offset enters as an angle of the rudder, `authority` rad/s^2 per rad.
    """

    interval: float
    authority: float

    def series(self, record):
        """Time, heading at the beginning, mean yaw rate and mean rudder of each interval."""
        return in_intervals(record, self.interval)

    def run(self, record, start, begin=0, end=None):
        part = record if begin == 0 and end is None else record.part(record.name, begin, end)
        time, _, _, rudder = self.series(part)
        rate = self.rates(rudder[:, None] + start[2] / self.authority, start)
        return self.on_record(part, time, rate, start)

    def on_record(self, record, time, rate, start):
        heading = start[0] + self.interval * np.vstack([np.zeros(rate.shape[1]), np.cumsum(rate, axis=0)])
        edges, middles = np.append(time, time[-1] + self.interval), time + 0.5 * self.interval
        spread = lambda x, y: np.stack([np.interp(record.time, x, column) for column in y.T], axis=1)
        return spread(edges, heading), spread(middles, rate)


def in_intervals(record, interval):
    """Means by differences of heading and of the rudder's integral, so that any interval will do."""
    edges = np.arange(record.time[0], record.time[-1], interval)
    heading = np.interp(edges, record.time, record.heading)
    area = np.concatenate([[0.0], np.cumsum(record.rudder[:-1]) * record.h])
    rudder = np.diff(np.interp(edges, record.time, area)) / interval
    rate = np.diff(heading) / interval
    if record.logged_rate is not None:
        turned = np.concatenate([[0.0], np.cumsum(0.5 * (record.logged_rate[1:] + record.logged_rate[:-1])) * record.h])
        rate = np.diff(np.interp(edges, record.time, turned)) / interval
    return edges[:-1], heading[:-1], rate, rudder


@dataclass
class Polynomial(Discrete):
    """y_k = sum of theta times products of y_(k-1), ..., u_k, u_(k-1), ...: ARX where each term has one factor."""

    theta: np.ndarray = None
    terms: list = field(default_factory=list)  # of tuples of ("y" or "u", lag)
    further_states = 0

    def rates(self, rudder, start, past=None):
        order = max([lag for term in self.terms for _, lag in term], default=1)
        columns = max(rudder.shape[1], np.size(start[1]))
        y = np.empty((order + len(rudder), columns))
        y[:order] = start[1] if past is None else past
        u = np.vstack([np.repeat(rudder[:1], order, axis=0), rudder]) * np.ones(columns)
        for k in range(order, len(y)):
            sources = {"y": y, "u": u}
            value = 0.0
            for theta, term in zip(self.theta, self.terms):
                product = theta
                for name, lag in term:
                    product = product * sources[name][k - lag]
                value = value + product
            y[k] = np.clip(value, -1e3, 1e3)
        return y[order:]

    def states_at(self, record, places):
        return np.zeros((0, len(places)))


@dataclass
class StateSpace(Discrete):
    """x_(k+1) = A x + B (u - mean),  y = C x + D (u - mean) + mean."""

    A: np.ndarray = None
    B: np.ndarray = None
    C: np.ndarray = None
    D: float = 0.0
    means: tuple = (0.0, 0.0)  # of yaw rate and rudder

    @property
    def further_states(self):
        return len(self.A) - 1

    def rates(self, rudder, start):
        u = (rudder - self.means[1]) * np.ones(np.shape(start)[1])
        x = np.vstack([start[1:2], start[3:]])
        y = np.empty(u.shape)
        for k in range(len(u)):
            y[k] = self.C @ x + self.D * u[k] + self.means[0]
            x = np.clip(self.A @ x + self.B[:, None] * u[k], -1e6, 1e6)
        return y

    def states_at(self, record, places):
        return np.zeros((self.further_states, len(places)))


GOOD_FIT = 0.9


def own_start(model, record, rounds=12, offset=True):
    """The start and, if so asked, offset with which the free run comes nearest to the heading.

    A course-unstable model leaves the record where its start is a little off: where the direct search ends under an R^2 of GOOD_FIT, another
    one fits ever longer beginnings of the record, each from the last one's start.
    """
    start, square = nearest(model, record, first_start(model, record), rounds, offset)
    if square < (1.0 - GOOD_FIT) * np.var(record.heading) or not offset:
        return start
    patient = first_start(model, record)
    for share in (0.06, 0.12, 0.25, 0.4, 0.6, 0.8, 1.0):
        part = record.part(record.name, 0, max(20, round(share * record.time.size)))
        patient, patient_square = nearest(model, part, patient, rounds if share == 1.0 else 4, offset)
    return start if square <= patient_square else patient


def first_start(model, record):
    lead = slice(0, max(3, record.time.size // 50))
    slope = np.polyfit(record.time[lead], record.heading[lead], 1)[0]
    return np.concatenate([[record.heading[0], slope, 0.0], np.zeros(model.further_states)])


def nearest(model, record, start, rounds, offset):
    """Gauss and Newton's method with shorter steps, and the mean square error, rad^2, that it ends with."""
    turn = max(np.std(record.rate), 1e-6)
    scale = np.concatenate([[0.1, turn, offset * turn / record.time[-1] * 10.0], np.full(model.further_states, turn)])
    error = lambda x: np.nan_to_num(record.heading[:, None] - model.run(record, x)[0], nan=1e9, posinf=1e9, neginf=-1e9)
    best = np.sum(error(start[:, None]) ** 2)
    for _ in range(rounds):
        steps = start[:, None] + np.column_stack([np.zeros(start.size), np.diag(1e-3 * scale)])
        errors = error(steps)
        slopes = (errors[:, 1:] - errors[:, :1]) / 1e-3
        move = -scale * np.linalg.lstsq(slopes, errors[:, 0], rcond=1e-9)[0]
        tried = start[:, None] + move[:, None] * np.array([1.0, 0.5, 0.25, 0.1, 0.02])
        sums = np.sum(error(tried) ** 2, axis=0)
        gained = sums.min() < best * (1.0 - 1e-3)
        if sums.min() < best:
            start, best = tried[:, sums.argmin()], sums.min()
        if not gained:
            break
    return start, best / record.time.size
