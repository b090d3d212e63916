# SPDX-License-Identifier: Apache-2.0
"""The engine on something that is no tire: a ball that falls, with and without drag."""

from __future__ import annotations

import re
import subprocess
import sys
from dataclasses import replace
from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pytest
from ball import Drag, Wind, throw
from matplotlib.text import Text

from bare_numbers import text_of_page
from flatplank_analysis.discovery.descent import bounded_step
from flatplank_analysis.discovery.opening import Options
from flatplank_analysis.discovery.report import figures, page
from flatplank_analysis.discovery.report.figures import short_names
from flatplank_analysis.discovery.verdict import AT_FLOOR, FOUND, diagnose, undecidable
from flatplank_analysis.discovery.where import make_maps
from flatplank_analysis.inference.search import run_search
from flatplank_data.errors import FlatplankError


@pytest.mark.parametrize("seed", [1, 2])
def test_drag_is_found_with_its_size(seed):
    search = run_search(throw(seed, 0.02), [Drag, Wind], Options())
    result = diagnose(search)
    assert result.verdict == FOUND, result.reason
    assert [f.decision.term.effect.identifier for f in result.found] == ["drag"]
    low, high = result.found[0].decision.interval
    assert result.found[0].decision.term.size == pytest.approx(0.02, rel=0.1)
    assert low < 0.0215 and high > 0.0185
    assert result.rmse_after < 0.5 * result.rmse_before


def test_page_and_figures_have_the_channel_and_unit_of_the_runs(tmp_path):
    ball = throw(1, 0.02)
    ball.runs = replace(ball.runs, units=("m",))
    result = diagnose(run_search(ball, [Drag, Wind], Options()))
    search, runs = result.search, ball.runs
    written = page.write_report(result, tmp_path, "throws").read_text(encoding="utf-8")
    told = f"The error of z is {result.rmse_before:.2f} m with the base alone"
    assert told in text_of_page(written)
    (table,) = make_maps(runs, search.steps[0].state.residual[0], result.floor)
    drawn = {
        "RMSE of z [m]": figures.conditions(search.steps),
        "measured - model [m]": figures.map_of(table, runs),
        "z: left without it (dots), effect (line) [m]": figures.collapse(search, 0),
        "RMSE of z [m] ": figures.waterfall(figures.steps_of(search), result.floor, runs),
        " m between the lines": figures.residual(search.last),
    }
    for label, figure in drawn.items():
        words = [text.get_text() for text in figure.findobj(Text)]
        assert any(label.rstrip() in w for w in words), words
        assert not any(re.search(r"Fx|\bN\b", w) for w in words)


@pytest.mark.parametrize(("step", "told"), [(np.nan, False), (1.5, True)])
def test_one_step_position_is_told_and_none_is_no_fault(step, told):
    ball = throw(3, 0.0)
    facts = {**ball.runs.facts, "step": np.full(ball.runs.runs, step)}
    ball.runs = replace(ball.runs, facts=facts)
    result = diagnose(run_search(ball, [Drag], Options()))
    assert any("one step position" in note for note in result.notes) is told


def test_two_effects_are_found():
    found = run_search(throw(1, 0.02, a=1.0), [Drag, Wind], Options()).last.found
    assert {f.decision.term.effect for f in found} == {Drag, Wind}


def test_nothing_is_found_where_nothing_is():
    result = diagnose(run_search(throw(3, 0.0), [Drag, Wind], Options()))
    assert result.verdict == AT_FLOOR, result.reason
    assert not result.found
    assert result.to_dict()["effects"] == []
    assert result.to_dict()["unexplained"]["varying"] == pytest.approx(result.varying, rel=1e-5)
    size, unit = result.detectable["drag"]
    assert 0.0 < size < 0.02 and unit == "1/m"


def test_too_little_is_said_to_be_too_little():
    assert "no repeats" in undecidable(throw(4, 0.0, repeats=1).runs)
    assert "runs" in undecidable(throw(4, 0.0).runs.subset(np.arange(4)))


def test_a_hole_in_a_run_is_named():
    runs = throw(4, 0.0).runs
    measured = runs.measured.copy()
    measured[0, 7, 20:30] = np.nan
    with pytest.raises(FlatplankError, match="run throw 7: .*NaN|NaN.*throw 7"):
        replace(runs, measured=measured)


def test_example_of_the_docs():
    """docs/explanation/engine.md shows the engine: what it prints stands beside it."""
    text = (Path(__file__).resolve().parents[2] / "docs/explanation/engine.md").read_text("utf-8")
    (code,) = re.findall(r"```python\n(.*?)```", text, re.DOTALL)
    wanted = re.findall(r"^ *# prints: (.*)$", code, re.MULTILINE)
    done = subprocess.run(
        [sys.executable, "-c", code], capture_output=True, text=True, timeout=100
    )
    assert done.stdout.splitlines() == wanted, done.stderr


def test_engine_knows_no_tires():
    code = (
        "import sys, flatplank_analysis.inference.search, flatplank_analysis.discovery.verdict, "
        "flatplank_analysis.inference.nextrun\n"
        "bad = [m for m in sys.modules if m.startswith(('flatplank_analysis.contact_patch', "
        "'flatplank_analysis.effects', 'flatplank_analysis.models'))]\n"
        "sys.exit(repr(bad) if bad else 0)"
    )
    subprocess.run([sys.executable, "-c", code], check=True, timeout=60)


def test_bounded_step_holds_the_box():
    hessian = np.array([[2.0, 0.5], [0.5, 1.0]])
    slope = np.array([4.0, -1.0])
    free = bounded_step(hessian, slope, np.full(2, -10.0), np.full(2, 10.0), 0.0)
    np.testing.assert_allclose(hessian @ free, slope, rtol=1e-6)
    held = bounded_step(hessian, slope, np.full(2, -10.0), np.array([1.0, 10.0]), 0.0)
    assert held[0] == pytest.approx(1.0)
    assert held[1] == pytest.approx(-1.5, rel=1e-6)


def test_conditions_are_named_by_what_differs_between_them():
    names = (
        "κ -10 %, Fz 3700 N, 2.5 bar",
        "κ -10 %, Fz 2590 N, 2.5 bar",
        "κ +0 %, Fz 3700 N, 2.5 bar",
    )
    runs = SimpleNamespace(condition_names=names)
    assert short_names(runs) == ["κ -10 %, Fz 3700 N", "κ -10 %, Fz 2590 N", "κ +0 %, Fz 3700 N"]
    assert short_names(SimpleNamespace(condition_names=names[:1])) == ["κ -10 %"]
