"""Every public function says what it takes and returns, in the style of NumPy."""

from __future__ import annotations

import inspect
import re

import seatrial


def test_exact_every_parameter_of_every_function_is_documented() -> None:
    functions = [found for name in seatrial.__all__ if inspect.isfunction(found := getattr(seatrial, name))]
    assert len(functions) >= 18
    for function in functions:
        page = inspect.getdoc(function) or ""
        assert re.search(r"^Returns\n-------$", page, re.M), function.__name__
        headed = re.findall(r"^([\w*][\w*, ]*)\n    \S", page, re.M)
        named = {name.strip(" *") for line in headed for name in line.split(",")}
        parameters = {name.strip("_") for name in inspect.signature(function).parameters}
        assert parameters <= named, (function.__name__, parameters - named)


def test_exact_every_result_has_a_page_and_a_picture() -> None:
    results = ["Identification", "Inspection", "Comparison", "Validated", "Health", "Plan", "HeadingGains",
               "TurningLimits", "TrialResult"]
    for name in results:
        result = getattr(seatrial, name)
        assert callable(result.plot) and callable(result._repr_html_)
        assert "__dataclass_fields__" in vars(result), name
