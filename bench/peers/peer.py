"""The same work in Python: a line names it on stdin, a line with seconds and parameters answers.

Started by refbench, which writes the signals as raw float64 into the folder named on the command line.
"""

import sys
import time
from pathlib import Path

import filterpy.kalman
import numpy as np
import padasip
from scipy import optimize, signal

FOLDER = Path(sys.argv[1])
H, LAM, P0 = 0.05, 1.5, 1e6


def load(name):
    return np.fromfile(FOLDER / name)


X = LAM * H
E = np.exp(-X)
# q1' = lam (w - q1), q0' = lam (q1 - q0), held between samples; accelerations lam^2 (w - 2 q1 + q0), rates lam (q1 - q0).
POLES = np.array([1.0, -2.0 * E, E * E])
ONCE = np.array([0.0, 1.0 - E])
TWICE = np.array([0.0, 1.0 - E - X * E, E * E - E + X * E])


def filtered(heading, rudder):
    once = signal.lfilter(ONCE, POLES[:1].tolist() + [-E], heading)
    twice = signal.lfilter(TWICE, POLES, heading)
    delta = signal.lfilter(TWICE, POLES, rudder)
    return LAM**2 * (heading - 2.0 * once + twice), LAM * (once - twice), delta


def lfilter_normal(heading, rudder):
    y, rate, delta = filtered(heading, rudder)
    phi = np.stack([rate, delta, np.ones_like(rate)])
    return np.linalg.solve(phi @ phi.T, phi @ y)


def online(adapt):
    heading, rudder = load("heading_long")[:2000], load("rudder_long")[:2000]
    u, v, q1, q0 = -heading[0], 0.0, 0.0, 0.0
    begin = time.process_time()
    for k in range(len(heading)):
        if k > 0:
            v = E * v - X * E * u
            u = E * u - (heading[k] - heading[k - 1])
            q0 = E * q0 + X * E * q1 + (1.0 - E - X * E) * rudder[k - 1]
            q1 = E * q1 + (1.0 - E) * rudder[k - 1]
        adapt(-LAM * LAM * (u + v), np.array([LAM * v, q0, 1.0]))
    return (time.process_time() - begin) / len(heading)


def online_padasip():
    rls = padasip.filters.FilterRLS(n=3, mu=1.0, eps=1.0 / P0, w="zeros")
    seconds = online(lambda y, phi: rls.adapt(y, phi))
    return seconds, rls.w


def online_filterpy():
    kalman = filterpy.kalman.KalmanFilter(dim_x=3, dim_z=1)
    kalman.P = P0 * np.eye(3)
    kalman.R = np.eye(1)
    seconds = online(lambda y, phi: kalman.update(y, H=phi[None, :]))
    return seconds, kalman.x.ravel()


def simulate(theta, rudder):
    a, b, c, psi0, r0 = theta
    decay = np.exp(a * H)
    gain = np.expm1(a * H) / a
    u = b * rudder + c
    rate = signal.lfilter([0.0, 1.0], [1.0, -decay], gain * u)
    rate += r0 * decay ** np.arange(len(rudder))
    rise = gain * rate + (gain - H) / a * u
    return psi0 + np.concatenate([[0.0], np.cumsum(rise)[:-1]])


def refined_least_squares():
    heading, rudder, start = load("heading_short"), load("rudder_short"), load("start")
    begin = time.process_time()
    found = optimize.least_squares(
        lambda t: simulate(t, rudder) - heading, [*start, heading[0], 0.0], method="lm"
    )
    return time.process_time() - begin, [*found.x[:3], np.sqrt(np.mean(found.fun**2))]


def refined_simplex():
    heading, rudder = load("heading_short").tolist(), load("rudder_short").tolist()
    psi0 = float(np.mean(heading[:40]))

    def cost(theta):
        a, b, c = theta
        psi, r, total = psi0, 0.0, 0.0
        for measured, delta in zip(heading, rudder):
            total += (measured - psi) ** 2
            u = b * delta + c
            k1 = a * r + u
            r2 = r + 0.5 * H * k1
            k2 = a * r2 + u
            r3 = r + 0.5 * H * k2
            k3 = a * r3 + u
            r4 = r + H * k3
            k4 = a * r4 + u
            psi += H / 6.0 * (r + 2.0 * r2 + 2.0 * r3 + r4)
            r += H / 6.0 * (k1 + 2.0 * k2 + 2.0 * k3 + k4)
        return np.sqrt(total / len(heading))

    simplex = np.vstack([np.zeros(3), 0.05 * np.eye(3)])
    begin = time.process_time()
    found = optimize.minimize(
        cost, np.zeros(3), method="Nelder-Mead",
        options={"initial_simplex": simplex, "xatol": 0.01, "fatol": 1e-4, "maxiter": 600},
    )
    return time.process_time() - begin, [*found.x, found.fun]


def batch():
    heading, rudder = load("heading_long"), load("rudder_long")
    begin = time.process_time()
    theta = lfilter_normal(heading, rudder)
    return (time.process_time() - begin) / len(heading), theta


WORK = {
    "online padasip": online_padasip,
    "online filterpy": online_filterpy,
    "batch scipy": batch,
    "refined scipy least_squares": refined_least_squares,
    "refined scipy simplex, Python RK4": refined_simplex,
}

for line in sys.stdin:
    seconds, numbers = WORK[line.strip()]()
    print(seconds, *(float(x) for x in numbers), flush=True)
