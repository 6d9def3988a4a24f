"""A record of one hull on an even grid, in SI units, and the public and shared sets that the bench reads."""

import csv
from collections.abc import Callable
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np

DEGREE = np.pi / 180.0


@dataclass
class Record:
    """Heading (unwrapped) and rudder of one run, evenly sampled; speed and yaw rate where they were logged."""

    name: str
    time: np.ndarray
    heading: np.ndarray
    rudder: np.ndarray
    speed: np.ndarray | None = None
    logged_rate: np.ndarray | None = None
    source: str = ""

    @property
    def h(self):
        return (self.time[-1] - self.time[0]) / (self.time.size - 1)

    @property
    def rate(self):
        """The logged yaw rate, or the slope of the heading."""
        return np.gradient(self.heading, self.h) if self.logged_rate is None else self.logged_rate

    def part(self, name, begin, end):
        cut = lambda x: None if x is None else x[begin:end]
        return replace(
            self, name=name, time=self.time[begin:end] - self.time[begin], heading=cut(self.heading), rudder=cut(self.rudder),
            speed=cut(self.speed), logged_rate=cut(self.logged_rate),
        )

    def halves(self):
        middle = self.time.size // 2
        return [self.part(f"{self.name} 1st half", 0, middle), self.part(f"{self.name} 2nd half", middle, None)]

    def thinned(self, most):
        """At most `most` samples: every n-th heading, the yaw rate averaged about it, the mean rudder until the next."""
        n = -(-self.time.size // most)
        if n == 1:
            return self
        rows = self.time.size // n
        mean = lambda x: None if x is None else x[: rows * n].reshape(rows, n).mean(axis=1)
        padded = lambda x: np.pad(x, (n // 2, (n - 1) // 2), mode="edge")
        about = lambda x: None if x is None else np.convolve(padded(x), np.full(n, 1.0 / n), "valid")[: rows * n : n]
        return replace(
            self, time=self.time[: rows * n : n], heading=self.heading[: rows * n : n], rudder=mean(self.rudder),
            speed=mean(self.speed), logged_rate=about(self.logged_rate),
        )

    def write(self, path):
        """The table that `seatrial identify` reads; every unit is in its column's name."""
        columns = {"time_s": self.time, "heading_rad": self.heading, "rudder_rad": self.rudder}
        columns |= {} if self.speed is None else {"speed_m_s": self.speed}
        columns |= {} if self.logged_rate is None else {"yaw_rate_rad_s": self.logged_rate}
        np.savetxt(path, np.stack(list(columns.values()), axis=1), delimiter=",", header=",".join(columns), comments="", fmt="%.9g")


def even(name, source, time, heading, rudder, speed=None, rate=None):
    """Sorted, without repeated times, on the grid of the median interval."""
    keep = np.concatenate([[True], np.diff(time) > 0.0]) & np.isfinite(time + heading + rudder)
    time, heading, rudder = time[keep] - time[keep][0], np.unwrap(heading[keep]), rudder[keep]
    grid = np.arange(0.0, time[-1], np.median(np.diff(time)))
    on_grid = lambda x: None if x is None else np.interp(grid, time, x[keep])
    return Record(
        name, grid, np.interp(grid, time, heading), np.interp(grid, time, rudder), on_grid(speed), on_grid(rate), str(source)
    )


# Names of columns that tables use, with the factor to SI units.
NAMES = {
    "time": {"t": 1.0, "time_s": 1.0, "t [s]": 1.0, "time": 1.0},
    "heading": {"yaw": 1.0, "heading_rad": 1.0, "heading_deg": DEGREE, "psi_hat [rad]": 1.0, "psi": 1.0},
    "rudder": {"rudder_rad": 1.0, "rudder_deg": DEGREE, "delta_rudder [rad]": 1.0, "delta": -1.0, "rudder": 1.0},
    "speed": {"speed": 1.0, "speed_m_s": 1.0, "u_velo [m/s]": 1.0},
    "rate": {"yaw_rate": 1.0, "yaw_rate_rad_s": 1.0, "r_angvelo [rad/s]": 1.0},
}


def named(path):
    """A table whose first line has names."""
    with open(path, newline="") as file:
        names = next(csv.reader(file))
        table = dict(zip(names, np.genfromtxt(file, delimiter=",").T))
    found = {}
    for quantity, known in NAMES.items():
        name = next((name for name in known if name in table), None)
        found[quantity] = None if name is None else table[name] * known[name]
    return found


def numbered(path, header, time, heading, rudder, speed, rate):
    """A table without names: the numbers of the columns, angles in degrees."""
    table = np.loadtxt(path, skiprows=header, encoding="latin-1")
    return {
        "time": table[:, time], "heading": table[:, heading] * DEGREE, "rudder": table[:, rudder] * DEGREE,
        "speed": table[:, speed], "rate": table[:, rate] * DEGREE,
    }


def hsva(path):
    return numbered(path, 4, 0, 3, 8, 4, 6)


def marin(path):
    return numbered(path, 3, 0, 4, 9, 5, 8)


def vtec(path):
    """A bag of the catamaran of Tecnologico de Monterrey: the difference of its thrusters, 100 N as 1 rad, for the rudder."""
    from rosbags.highlevel import AnyReader

    fields = {"/ins_pose": "theta", "/left_thruster": "data", "/right_thruster": "data", "/local_vel": "x"}
    series = {topic: [] for topic in [*fields, "rate"]}
    with AnyReader([path]) as bag:
        wanted = [connection for connection in bag.connections if connection.topic in fields]
        for connection, stamp, raw in bag.messages(wanted):
            message = bag.deserialize(raw, connection.msgtype)
            series[connection.topic].append((stamp * 1e-9, getattr(message, fields[connection.topic])))
            if connection.topic == "/local_vel":
                series["rate"].append((stamp * 1e-9, message.z))
    series = {topic: np.array(rows).T for topic, rows in series.items()}
    time, heading = series["/ins_pose"]
    # Messages that waited arrive together: the first of them has the wrong time.
    spaced = np.append(np.diff(time) > 0.03, True)
    time, heading = time[spaced], heading[spaced]
    at = lambda topic: np.interp(time, *series[topic])
    return {
        "time": time, "heading": heading, "rudder": (at("/left_thruster") - at("/right_thruster")) / 100.0,
        "speed": at("/local_vel"), "rate": at("rate"),
    }


@dataclass
class Hull:
    """Records of one hull in one condition: every ordered pair of them is trained and predicted, or the halves of each."""

    name: str
    folder: str  # of the shared data, or of a public repository
    files: list
    read: Callable = named
    halves: bool = False
    same_as: str = ""  # a larger set that has these records, too

    def records(self, roots):
        """Those that are there."""
        for root in roots:
            found = [Path(root, self.folder, file) for file in self.files if Path(root, self.folder, file).exists()]
            if found:
                return [even(path.stem, path, **self.read(path)) for path in found]
        return []

    def pairs(self, records):
        if self.halves:
            parts = [record.halves() for record in records]
            return [pair for first, second in parts for pair in ((first, second), (second, first))]
        return [(one, other) for one in records for other in records if one is not other]


OSAKA_FOLDER = "FRT-DS-ESSO/data"
SIMMAN = "System-identification-of-Vessel-Manoeuvring-Models/data/01_raw"
HSVA_RUNS = "05_01 10_01 10_05 10_10_P 10_10_S 15_01 15_05 20_05 20_10_P 20_10_S 25_05 30_05 35_05".split()
ZIG_ZAG = "zigzag/zigzag_31-Jul-2020_"
RANDOM = (
    "03-Aug-2020_11_04_37 06-Aug-2020_16_24_25_1 06-Aug-2020_16_24_25_3 06-Aug-2020_16_24_25_4 06-Aug-2020_16_24_25_5 "
    "06-Aug-2020_16_24_25_6 31-Jul-2020_12_29_58 31-Jul-2020_12_48_39 31-Jul-2020_14_52_18"
).split()
BERTHING = "11_07_23 11_14_47 11_21_46 11_38_50 11_49_21 13_09_11 13_21_03 13_37_05".split()


def osaka(name, files, halves=False):
    return Hull(name, OSAKA_FOLDER, [f"{file}.csv" for file in files], halves=halves)


def bags(name, files, halves=False):
    return Hull(name, "vtec_usv_ros_pkg/bags/asmc", [f"{file}.bag" for file in files], vtec, halves)


HULLS = [
    Hull("KVLCC2, HSVA", "real", [f"kvlcc2hsva_Z_{run}.csv" for run in HSVA_RUNS], same_as="KVLCC2, HSVA, all runs"),
    Hull("KVLCC2, MARIN 10/10", "real", ["marin_zz_10_m.csv", "marin_zz_-10_m.csv"]),
    Hull("Esso Osaka, shared zig-zags", "real", [f"esso_zigzag_{x}.csv" for x in "abc"]),
    Hull("Fuzhou boat, halves", "real", ["fuzhou_zz.csv"], halves=True),
    Hull("Slocum glider, halves", "real", ["slocum_amadeus.csv"], halves=True),
    Hull("Hakusan in waves, halves", "real", ["hakusan_ship.csv"], halves=True),
    Hull("KVLCC2, MARIN 20/20", SIMMAN, [f"kvlcc2/MARIN_FREE_KVLCC2_zz_{x}_m.dat" for x in ("20", "-20")], marin),
    bags("VTec catamaran, line of sight", [
        "LOS2_2016-02-11-11-17-13", "LOS2_2016-02-11-11-19-59", "LOS2_2016-02-11-11-30-16", "LOS2_2019-11-06-13-00-44"]),
    bags("VTec catamaran, line of sight, payload", ["p_LOS2_2016-02-11-14-36-37", "p_LOS2_2016-02-11-14-38-48"]),
    bags("VTec catamaran, course changes, halves", [
        "0,7_speed_0,4_heading_2016-02-11-14-23-37", "0,7_speed_0,4_heading_2019-11-06-12-29-52", "p_0,7_speed_0,4_heading_2016-02-11-14-05-50",
        "p_0,7_speed_0,4_heading_2019-11-06-13-27-24", "p_0,7_speed_0,4_heading_2019-11-06-13-41-00"], halves=True),
    bags("VTec catamaran, course kept at 1.2 m/s", [
        "ftc_1,2_speed_ref_heading_2016-02-11-10-59-32", "ftc_1,2_speed_ref_heading_2_2016-02-11-11-02-58",
        "pftc_1,2_speed_ref_heading_2016-02-11-11-09-03", "pftc_1,2_speed_ref_heading_2_2016-02-11-11-10-40"]),
    osaka("Esso Osaka, zig-zags, 12 rps", [ZIG_ZAG + x for x in ("13_29_19", "13_50_28", "14_03_39", "14_10_05")]),
    osaka("Esso Osaka, zig-zags, 10 rps", [ZIG_ZAG + x for x in ("13_22_52", "13_42_53")]),
    osaka("Esso Osaka, zig-zags, 16.7 rps", [ZIG_ZAG + x for x in ("13_04_24", "13_14_21")]),
    osaka("Esso Osaka, turns, 10 rps", [f"turning/turn_14-{x}" for x in (
        "Oct-2020_14_29_49", "Oct-2020_14_56_07", "Oct-2020_15_21_57", "Sep-2020_13_39_32")]),
    osaka("Esso Osaka, random, halves", [f"random/random_{x}" for x in RANDOM], halves=True),
    osaka("Esso Osaka, random, 6 August", [f"random/random_{x}" for x in RANDOM if x.startswith("06")]),
    osaka("Esso Osaka, berthing, halves", [f"berthing/berthing_12-Nov-2020_{x}" for x in BERTHING], halves=True),
    Hull("KVLCC2, HSVA, all runs", SIMMAN, [f"kvlcc2_hsva/raw_data/HSVA_CPMC_KVLCC2_Z_{run}.dat" for run in HSVA_RUNS], hsva),
]
