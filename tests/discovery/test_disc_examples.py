# SPDX-License-Identifier: Apache-2.0
"""The engine on machines that are not ours: what it names in their data, and what it refuses."""

from __future__ import annotations

import importlib.util
import sys
from pathlib import Path

import pytest

from flatplank_analysis.discovery.report.text import text_of

EXAMPLES = Path(__file__).resolve().parents[2] / "examples"


@pytest.fixture(scope="module")
def falling_balls():
    path = EXAMPLES / "falling_balls" / "falling_balls.py"
    spec = importlib.util.spec_from_file_location("falling_balls", path)
    module = importlib.util.module_from_spec(spec)
    sys.modules[spec.name] = module  # dataclasses look there
    spec.loader.exec_module(module)
    yield module
    del sys.modules[spec.name]


@pytest.fixture(scope="module")
def result(falling_balls):
    return falling_balls.main().result


def test_what_is_told_of_falling_balls(result):
    """One drag coefficient for all closed balls is not the whole truth, and it says so."""
    assert result.verdict == "partly"
    (found,) = result.found
    assert found.decision.term.effect.identifier == "drag_quadratic"
    assert 0.0 < found.decision.interval[0] < found.decision.term.size < found.decision.interval[1]
    stated = result.search.stated["effects"]
    assert stated["drag_quadratic"] > 0.7 > 0.3 > stated["updraft"]
    said = text_of(result)
    assert "error of fallen: 1.4" in said and " N" not in said and "5 cm" not in said


def test_the_table_of_examples_has_their_numbers(result):
    page = (EXAMPLES / "README.md").read_text(encoding="utf-8")
    numbers = (result.rmse_before, result.rmse_after, result.held_out_after, result.floor)
    assert (
        "error {:.2f} m before, {:.2f} m after, {:.2f} m in balls that were held out, "
        "floor of the repeats {:.2f} m".format(*numbers)
    ) in page
