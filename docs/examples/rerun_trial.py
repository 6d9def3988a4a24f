"""A recording of `seatrial trial --record trial.mcap` with views for Rerun: python3 rerun_trial.py trial.mcap trial.rrd"""

import sys

import rerun as rr
import rerun.blueprint as rrb
from rerun.blueprint.encodings import ComponentSourceKind, VisualizerComponentMapping

# Rerun keeps a message as one component; a plot takes its numbers from the field `data` of it.
NUMBERS = VisualizerComponentMapping(
    target="Scalars:scalars",
    source_kind=ComponentSourceKind.SourceComponent,
    source_component="std_msgs.msg.Float64:message",
    selector=".data",
)

COLUMNS = [
    {
        "Heading, rad": ["heading_rad"],
        "Yaw rate, rad/s": ["yaw_rate_rad_s"],
        "Rudder, rad": ["rudder_rad"],
        "Stage: 1 settle, 2 train, 3 validate": ["stage"],
    },
    {
        "Live estimates": ["estimate_a22_per_s", "estimate_b2_per_s2", "estimate_c0_rad_per_s2"],
        "Half widths of the 95 % intervals": [
            "half_width_a22_per_s",
            "half_width_b2_per_s2",
            "half_width_c0_rad_per_s2",
        ],
        "Convergence: step norm": ["estimate_step_norm"],
        "Thrust of full, surge speed in m/s": ["thrust_fraction", "surge_speed_m_s"],
    },
    {
        "Track, m": ["north_m", "east_m"],
        "Roll and pitch, rad": ["roll_rad", "pitch_rad"],
        "Depth and altitude, m": ["depth_m", "altitude_m"],
    },
]


def plot(title: str, topics: list[str]) -> rrb.TimeSeriesView:
    lines = {f"/{topic}": rr.SeriesLines(names=topic).visualizer(mappings=[NUMBERS]) for topic in topics}
    return rrb.TimeSeriesView(origin="/", contents=list(lines), name=title, overrides=lines)


def blueprint() -> rrb.Blueprint:
    columns = [rrb.Vertical(*[plot(title, topics) for title, topics in column.items()]) for column in COLUMNS]
    return rrb.Blueprint(rrb.Horizontal(*columns), collapse_panels=True)


if __name__ == "__main__":
    _, recording, out = sys.argv
    rr.init("seatrial")
    rr.save(out, default_blueprint=blueprint())
    rr.log_file_from_path(recording)
