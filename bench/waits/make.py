"""Makes long logs of known vehicles, for measuring what a person waits for. Standard library only.

    make.py bin LOG.BIN MEGABYTES     ArduPilot DataFlash: a trial of five speeds, again and again for 15 min, attitude at 50 Hz with
                                      jitter, and inertial messages until the file has this size
    make.py csv LOG.csv ROWS          the same manoeuvres at 20 Hz: time_s,heading_rad,rudder_rad,surge_speed_m_s
    make.py random LOG.csv ROWS       the same columns: one speed, the rudder to a side by chance every half second, no manoeuvre to be found

A vehicle of first order: r' = a r + b delta + c with a = -(0.15 + 0.20 u), b = 0.12 u^2, c = 0.004 at speed u.
"""

import math
import random
import struct
import sys

SPEEDS_M_S = (0.8, 1.1, 1.4, 1.7, 2.0)
FULL_RUDDER_DEG = 35.0


def stages():
    """Duration in s, speed in m/s and rudder in rad, without end: two doublets a speed, at rest before, between and after."""
    turn = 0
    while True:
        speed = SPEEDS_M_S[turn % 5]
        constant_s = 1.0 / (0.15 + 0.20 * speed)
        angle = math.radians(12.0 + turn % 3)
        for side in (1.0, -1.0):
            yield 6.0 * constant_s, speed, 0.0
            yield 1.5 * constant_s, speed, side * angle
            yield 1.5 * constant_s, speed, -side * angle
        yield 4.0 * constant_s, speed, 0.0
        turn += 1


def by_chance(seed=3):
    """The rudder to one side or the other, as a coin says, every half second."""
    draw = random.Random(seed)
    while True:
        yield 0.5, 1.4, draw.choice((-1.0, 1.0)) * math.radians(10.0)


def samples(interval_s, jitter, plan, seed=1):
    """Time in s, heading in rad (from 0 to 2 pi, noise 0.02 deg), rudder in rad, speed in m/s and yaw rate in rad/s."""
    draw = random.Random(seed)
    time, heading, rate = 0.0, 1.0, 0.0
    duration, speed, rudder = next(plan)
    while True:
        noise = draw.gauss(0.0, math.radians(0.02))
        yield time, (heading + noise) % math.tau, rudder, speed, rate
        step = interval_s * (1.0 + jitter * (draw.random() - 0.5))
        a, b = -(0.15 + 0.20 * speed), 0.12 * speed * speed
        # Exact over an interval in which the rudder stands still.
        steady = -(b * (rudder - 0.004 / b) + 0.004) / a
        decay = math.exp(a * step)
        heading += steady * step + (rate - steady) * (decay - 1.0) / a
        rate = steady + (rate - steady) * decay
        time += step
        duration -= step
        if duration <= 0.0:
            duration, speed, rudder = next(plan)


def dataflash(path, megabytes):
    def padded(text, width):
        return text.encode().ljust(width, b"\0")

    def message(number, body):
        return b"\xa3\x95" + bytes([number]) + body

    def described(number, body, name, codes, labels):
        texts = padded(name, 4) + padded(codes, 16) + padded(labels, 64)
        return message(128, bytes([number, body + 3]) + texts)

    span_s, rate_hz = 900.0, 50
    log = [
        described(128, 86, "FMT", "BBnNZ", "Type,Length,Name,Format,Columns"),
        described(2, 28, "PARM", "QNf", "TimeUS,Name,Value"),
        described(3, 72, "MSG", "QZ", "TimeUS,Message"),
        described(4, 20, "ATT", "Qfff", "TimeUS,Roll,Pitch,Yaw"),
        described(5, 14, "RCOU", "QHHH", "TimeUS,C1,C2,C3"),
        described(6, 49, "IMU", "QBffffffffff", "TimeUS,I,GyrX,GyrY,GyrZ,AccX,AccY,AccZ,T,EG,EA,Hz"),
        described(7, 22, "GPS", "QBBLLf", "TimeUS,I,Status,Lat,Lng,Spd"),
        message(3, struct.pack("<Q64s", 0, b"ArduRover V4.5.7 (0)")),
    ]
    for name, value in [("SERVO1_FUNCTION", 26.0), ("SERVO1_TRIM", 1500.0), ("SERVO3_FUNCTION", 70.0)]:
        log.append(message(2, struct.pack("<Q16sf", 0, padded(name, 16), value)))
    ticks = int(span_s * rate_hz)
    a_tick = megabytes * 1e6 / ticks - 23 - 17
    filler = max(1, round(a_tick / 52))
    draw = random.Random(2)
    made = samples(1.0 / rate_hz, 0.2, stages())
    for tick in range(ticks):
        time, heading, rudder, speed, rate = next(made)
        us = round(1e6 * (time + 10.0))
        pwm = round(1500.0 + 500.0 * math.degrees(rudder) / FULL_RUDDER_DEG)
        log.append(message(5, struct.pack("<QHHH", us, pwm, 1500, round(1100 + 400 * speed))))
        log.append(message(4, struct.pack("<Qfff", us, 0.1, 0.2, math.degrees(heading))))
        if tick % 10 == 0:
            log.append(message(7, struct.pack("<QBBLLf", us, 0, 3, 1, 1, speed)))
        for k in range(filler):
            gyro = [draw.gauss(0.0, 0.002) for _ in range(2)] + [rate + draw.gauss(0.0, 0.002)]
            body = struct.pack("<QBffffffffff", us + 10 + k, k % 2, *gyro, 0, 0, -9.8, 40, 0, 0, 400)
            log.append(message(6, body))
    with open(path, "wb") as file:
        file.write(b"".join(log))


def csv(path, rows, plan):
    made = samples(0.05, 0.0, plan)
    with open(path, "w") as file:
        file.write("time_s,heading_rad,rudder_rad,surge_speed_m_s\n")
        for _, (time, heading, rudder, speed, _) in zip(range(rows), made):
            file.write(f"{time:.3f},{heading:.6f},{rudder:.6f},{speed:.2f}\n")


if __name__ == "__main__":
    kind, path, size = sys.argv[1], sys.argv[2], int(sys.argv[3])
    if kind == "bin":
        dataflash(path, size)
    else:
        csv(path, size, stages() if kind == "csv" else by_chance())
