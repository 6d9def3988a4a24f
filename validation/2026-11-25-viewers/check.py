"""Shows a recording in Rerun, and builds the layout for Foxglove from Foxglove's own types: python3 check.py SEATRIAL [SCREENSHOT.png]"""

import io
import json
import re
import subprocess
import sys
import tempfile
import time
from pathlib import Path

import foxglove.layouts as fl
from PIL import Image
from rerun.experimental import ViewerClient

EXAMPLES = Path(__file__).parents[2] / "docs" / "examples"
PATIENCE_S = 120
# A line in a view of this size has more pixels of its colour.
LINE = 200


def wait_for(what, is_there):
    begun = time.monotonic()
    while not (found := is_there()):
        assert time.monotonic() - begun < PATIENCE_S, what
        time.sleep(0.5)
    return found


def coloured(png):
    """Pixels that are neither grey nor black: those of lines and their legends."""
    pixels = Image.open(io.BytesIO(png)).convert("HSV").tobytes()
    return sum(1 for saturation, value in zip(pixels[1::3], pixels[2::3]) if saturation > 90 and value > 90)


def views_of(client, recording):
    client.open(str(recording))
    loaded = lambda: (state := client.get_state()).recordings and not state.loading and state
    return wait_for(f"{recording} is not loaded", loaded).views


def in_rerun(folder, screenshot):
    recording, shown = folder / "trial.mcap", folder / "trial.rrd"
    subprocess.run([sys.executable, EXAMPLES / "rerun_trial.py", recording, shown], check=True)
    client = ViewerClient.spawn(headless=True, port=9877)
    try:
        views = wait_for("no views", lambda: views_of(client, shown))
        for view in views:
            drawn = lambda: coloured(client.take_screenshot(view.view_id)) > LINE
            wait_for(f"nothing is drawn in {view.name}", drawn)
        for view in client.get_state().views:
            assert not view.reports, (view.name, view.reports)
        print(f"Rerun: {len(views)} views with lines: {', '.join(view.name for view in views)}")
        if screenshot:
            Path(screenshot).write_bytes(client.take_screenshot(max_size=1000))
        client.close(store_ids=[recording.store_id for recording in client.get_state().recordings])
        print(f"Rerun without the views: {len(views_of(client, recording))} views")
    finally:
        client.quit()


def snake(name):
    return re.sub(r"(?<!^)(?=[A-Z])", "_", name).lower()


def typed(kind, config):
    """Fails on a field that Foxglove does not have."""
    return kind(**{snake(name): value for name, value in config.items()})


def of_foxglove():
    layout = json.loads((EXAMPLES / "foxglove-layout.json").read_text())
    for name, config in layout["configById"].items():
        config = {key: value for key, value in config.items() if not key.endswith("PanelTitle")}
        kind, series = {
            "Plot": (fl.PlotConfig, fl.PlotSeries),
            "StateTransitions": (fl.StateTransitionsConfig, fl.StateTransitionsSeries),
        }[name.split("!")[0]]
        paths = [typed(series, path) for path in config.pop("paths")]
        typed(kind, {**config, "paths": paths}).to_json()
    print(f"Foxglove: {len(layout['configById'])} panels have fields of its types")


with tempfile.TemporaryDirectory() as folder:
    folder = Path(folder)
    trial = [Path(sys.argv[1]).absolute(), "trial", "--yes", "--record", "trial.mcap"]
    subprocess.run(trial, cwd=folder, check=True, capture_output=True)
    of_foxglove()
    in_rerun(folder, sys.argv[2] if len(sys.argv) > 2 else None)
