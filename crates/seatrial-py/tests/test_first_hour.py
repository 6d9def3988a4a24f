"""What a researcher does in the first hour: simulate, predict, residuals, uncertainty, plots, tables and units of all kinds."""

from __future__ import annotations

import pickle
from datetime import datetime, timedelta, timezone
from pathlib import Path
from typing import Any, Union, get_args, get_origin, get_type_hints, is_typeddict
from zipfile import ZipFile

import matplotlib
import numpy as np
import pandas
import pint
import polars
import pytest
from test_package import doublet

import seatrial
from seatrial import _documents

matplotlib.use("agg")


@pytest.mark.parametrize("model", [seatrial.Model(-0.9, 0.7, 0.01), seatrial.Model(-1e-9, 0.7), seatrial.Model(0.0, 0.7)])
def test_exact_a_simulation_is_the_same_at_any_interval(model: seatrial.Model) -> None:
    time_s = np.concatenate([np.arange(0.0, 4.0, 0.5), np.arange(4.0, 10.0, 0.3)])
    rudder = np.where(time_s < 4.0, 0.2, -0.1)
    found = seatrial.simulate(model, time_s, rudder, heading_rad=1.0, yaw_rate_rad_s=0.05)
    fine = np.arange(0.0, 4.0, 0.0005)
    dense = seatrial.simulate(model, fine, np.full(fine.size, 0.2), heading_rad=1.0, yaw_rate_rad_s=0.05)
    at = fine.searchsorted(time_s[1:8] - 1e-9)
    # 8,000 steps of rounding.
    assert found.heading_rad[1:8] == pytest.approx(dense.heading_rad[at], abs=1e-10)
    assert found.yaw_rate_rad_s[1:8] == pytest.approx(dense.yaw_rate_rad_s[at], abs=1e-10)
    with pytest.raises(seatrial.UsageError, match="increase"):
        seatrial.simulate(model, [0.0, 0.0], [0.1, 0.1])


def test_exact_the_model_of_a_simulation_leaves_no_residuals() -> None:
    model = seatrial.Model(-0.9, 0.7, 0.01)
    time_s, _, rudder = doublet()
    true = seatrial.simulate(model, time_s, rudder, heading_rad=3.0, yaw_rate_rad_s=0.1)
    wrapped = np.degrees(true.heading_rad) % 360.0
    wrapped[7] = np.nan
    units: dict[str, Any] = {"heading_unit": "deg", "rudder_unit": "deg"}
    left = seatrial.residuals(model, time_s, wrapped, np.degrees(rudder), **units)
    assert left.size == time_s.size - 1 and np.abs(left).max() < 1e-9
    predicted = seatrial.predict(model, time_s, wrapped, np.degrees(rudder), **units)
    assert predicted.yaw_rate_rad_s[0] == pytest.approx(0.1, abs=1e-9)
    assert np.abs(seatrial.residuals(seatrial.Model(-0.5, 0.7), time_s, true.heading_rad, rudder)).max() > 0.01


def test_parity_residuals_are_those_of_the_validation(log: Path) -> None:
    found = seatrial.identify_log(log)
    validation = found.validation
    assert validation is not None
    measured = found.predict().heading_rad + found.residuals()
    r2 = 1.0 - np.mean(found.residuals() ** 2) / np.var(measured)
    assert validation["r2_heading"] is not None
    # The start is fitted here, and is the mean of the lead-in there: it fits as well or a little better.
    assert 0.0 <= r2 - validation["r2_heading"] < 0.05
    again = pickle.loads(pickle.dumps(found))
    assert (again.residuals() == found.residuals()).all()


def test_recover_drawn_models_spread_as_the_intervals_say(log: Path) -> None:
    found = seatrial.identify_log(log)
    drawn = found.samples(4000, seed=1)
    assert found.interval_95 is not None and found.covariance is not None and drawn.shape == (4000, 3)
    low, high = np.percentile(drawn[:, 0], [2.5, 97.5])
    # Three standard errors of a percentile of 4000 draws, and an interval of another shape than a normal one.
    assert high - low == pytest.approx(np.diff(found.interval_95["a22_per_s"])[0], rel=0.15)
    assert np.cov(drawn.T)[0, 1] == pytest.approx(found.covariance[0, 1], rel=0.2)
    assert (drawn == found.samples(4000, seed=1)).all()
    time_s, heading, rudder = doublet()
    with pytest.raises(seatrial.UsageError, match="no covariance"):
        seatrial.identify(time_s, heading, rudder, estimate="online").samples(3)


def test_exact_a_plot_has_measured_model_and_band(log: Path, tmp_path: Path) -> None:
    found = seatrial.identify_log(log)
    assert found.plot().get_legend_handles_labels()[1] == ["measured", "model", "95 %"]
    assert len(found.plot_models().containers) == 2
    swapped = tmp_path / "swapped.csv"
    swapped.write_text(log.read_text().replace("heading_rad", "course", 1))
    reading = seatrial.Reading(columns={"heading": "course"}, units={"heading": "rad"})
    # Read again without its reading, the log has no heading.
    assert seatrial.inspect(swapped, reading).plot().lines
    matplotlib.pyplot.close("all")


def test_val_python_control_has_the_model() -> None:
    control = pytest.importorskip("control")
    model = seatrial.Model(-0.9, 0.7)
    time_s = np.linspace(0.0, 5.0, 101)
    expected = seatrial.simulate(model, time_s, np.full(101, 0.5)).heading_rad
    for system in (model.to_control(), model.to_control("state space")[0, 0]):
        _, heading = control.step_response(system, time_s)
        assert 0.5 * heading == pytest.approx(expected, abs=1e-6)


def test_exact_tables_of_all_kinds_are_read() -> None:
    time_s, heading, rudder = doublet()
    expected = seatrial.identify(time_s, heading, rudder).model
    columns = {"time_s": time_s, "heading_rad": heading, "rudder_rad": rudder}
    frame = polars.DataFrame(columns)
    record = np.rec.fromarrays(list(columns.values()), names=list(columns))
    for table in (columns, frame, frame.lazy(), frame.to_arrow(), pandas.DataFrame(columns), record):
        assert seatrial.identify_table(table).model == expected, type(table)
    with pytest.raises(seatrial.InputError, match="no column 'course'"):
        seatrial.identify_table(frame.lazy(), heading="course")
    with pytest.raises(seatrial.UsageError, match="is no table"):
        seatrial.identify_table(3)


def test_exact_times_may_have_a_zone() -> None:
    time_s, heading, rudder = doublet()
    expected = seatrial.identify(time_s, heading, rudder).model
    start = datetime(2026, 6, 1, 12, tzinfo=timezone(timedelta(hours=2)))
    dates = [start + timedelta(seconds=t) for t in time_s]
    series = pandas.Series(dates)
    for times in (dates, series, series.dt.tz_localize(None), polars.Series(dates).to_list()):
        found = seatrial.identify(times, heading, rudder).model
        # Microseconds are rounded.
        assert found.theta == pytest.approx(expected.theta, rel=1e-4, abs=1e-6)
    with pytest.raises(seatrial.UsageError, match="time zone"):
        seatrial.identify([dates[0].replace(tzinfo=None), *dates[1:]], heading, rudder)


def test_exact_quantities_are_converted() -> None:
    units: Any = pint.UnitRegistry()
    time_s, heading, rudder = doublet()
    expected = seatrial.identify(time_s, heading, rudder, np.full(400, 0.5)).model
    found = seatrial.identify(
        units.Quantity(time_s * 1e3, "ms"), units.Quantity(np.degrees(heading), "deg"),
        units.Quantity(np.degrees(rudder), "deg"), units.Quantity(np.full(400, 1.8), "km/hour"),
    ).model
    assert found.theta == pytest.approx(expected.theta, rel=1e-6, abs=1e-9)
    with pytest.raises(seatrial.UsageError, match="heading is in meter; expected what converts to rad"):
        seatrial.identify(time_s, units.Quantity(heading, "m"), rudder)


def test_io_an_fmu_is_a_file(tmp_path: Path) -> None:
    model = seatrial.Model(-1.07, 1.08)
    with pytest.raises(seatrial.UsageError, match="out=FILE.fmu"):
        seatrial.export(model, "fmu", surge_speed_m_s=1.6)
    with pytest.warns(seatrial.SeatrialWarning):
        assert seatrial.export(model, "fmu", surge_speed_m_s=1.6, out=tmp_path / "boat.fmu") == ""
    assert "modelDescription.xml" in ZipFile(tmp_path / "boat.fmu").namelist()


def test_exact_results_can_be_kept_in_sets(log: Path) -> None:
    found = seatrial.identify_log(log)
    assert len({found, seatrial.identify_log(log)}) == 1
    assert {seatrial.inspect(log), seatrial.heading_gains(found), seatrial.turning_limits(found)}


def conforms(value: Any, kind: Any, place: str) -> None:
    """Fails where a part of a document is not of its type."""
    if kind is Any:
        return
    if is_typeddict(kind):
        names = get_type_hints(kind)
        missing = kind.__required_keys__ - value.keys()
        assert not missing, f"{place}: no {missing}"
        for name in names.keys() & value.keys():
            conforms(value[name], names[name], f"{place}.{name}")
    elif get_origin(kind) is Union:
        if value is not None:
            conforms(value, next(part for part in get_args(kind) if part is not type(None)), place)
    elif get_origin(kind) is list:
        for each in value:
            conforms(each, get_args(kind)[0], f"{place}[]")
    elif get_origin(kind) is dict:
        assert isinstance(value, dict), place
    elif kind is float:
        assert isinstance(value, (int, float)), place
    elif get_args(kind):
        assert value in get_args(kind), f"{place}: {value!r}"
    else:
        assert isinstance(value, kind), f"{place}: {value!r}"


def test_exact_documents_are_of_their_types(log: Path) -> None:
    found = seatrial.identify_log(log)
    documents: list[tuple[Any, Any]] = [
        (found, _documents.IdentificationDocument),
        (seatrial.identify_log(log, estimate="paper", training=(12, 28)), _documents.IdentificationDocument),
        (seatrial.inspect(log), _documents.InspectionDocument),
        (seatrial.compare(log), _documents.ComparisonDocument),
        (seatrial.validate(log, found), _documents.ValidationDocument),
        (seatrial.heading_gains(found), _documents.GainsDocument),
        (seatrial.turning_limits(found), _documents.TurningDocument),
        (seatrial.trial("sim:starfish", [0.8]), _documents.TrialDocument),
    ]
    for result, kind in documents:
        conforms(result.document, kind, kind.__name__)
