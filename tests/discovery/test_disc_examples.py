# SPDX-License-Identifier: Apache-2.0
"""The engine on machines that are not ours: what it names in their data, and what it refuses."""

from __future__ import annotations

import importlib.util
import sys
from pathlib import Path

import pytest

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


def test_drag_of_falling_balls_is_named_and_nothing_else(falling_balls, capsys):
    result = falling_balls.main().result
    assert [f.decision.term.effect.identifier for f in result.found] == ["drag_quadratic"]
    # one drag coefficient for all closed balls is not the whole truth, and it says so
    assert result.verdict == "partly"
    assert result.rmse_after < 0.3 * result.rmse_before
    assert result.held_out_after < 1.1 * result.rmse_after < 2.0 * result.floor
    sizes = result.found[0].decision.term.named()
    assert 0.1 < sizes["cd"] < 0.5 < sizes["cd_holes"] < 1.0
    refused = {
        d.term.effect.identifier: d.reasons for d in result.search.steps[0].refits if d.reasons
    }
    assert set(refused) == {"drag_linear", "updraft"}
    assert "not the same size in every condition" in refused["drag_linear"]
    said = capsys.readouterr().out
    assert "error of fallen: 1.4" in said and " N" not in said and "5 cm" not in said


def test_the_table_of_examples_has_their_numbers(falling_balls, capsys):
    result = falling_balls.main().result
    page = (EXAMPLES / "README.md").read_text(encoding="utf-8")
    numbers = (result.rmse_before, result.rmse_after, result.held_out_after, result.floor)
    assert (
        "error {:.2f} m before, {:.2f} m after, {:.2f} m in balls that were held out, "
        "floor of the repeats {:.2f} m".format(*numbers)
    ) in page
