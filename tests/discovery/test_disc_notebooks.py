# SPDX-License-Identifier: Apache-2.0
"""The notebooks run from their first cell to their last, on campaigns of their kind."""

from __future__ import annotations

import ast
import json
import sys
from pathlib import Path
from typing import Any

import pytest
import yaml
from bristles import Truth, campaign, save

from flatplank_data.errors import FlatplankError

ROOT = Path(__file__).resolve().parents[2]
BOOKS = ROOT / "examples" / "notebooks"
SLIPS = (-0.05, -0.01, 0.01, 0.05)


def cells(path: Path) -> list[str]:
    """Texts of the code cells; a notebook is kept without results."""
    book = json.loads(path.read_text(encoding="utf-8"))
    assert book["nbformat"] == 4 and book["metadata"]["kernelspec"]["language"] == "python"
    code = [c for c in book["cells"] if c["cell_type"] == "code"]
    assert all(c["outputs"] == [] and c["execution_count"] is None for c in code)
    return ["".join(c["source"]) for c in code]


def run_cells(path: Path) -> tuple[dict[str, Any], list[str]]:
    """The names at the end, and per cell that shows something its HTML or its text."""
    names: dict[str, Any] = {}
    shown = []
    for i, text in enumerate(cells(path)):
        body = ast.parse(text)
        last = body.body.pop() if isinstance(body.body[-1], ast.Expr) else None
        where = f"{path.name}, cell {i + 1}"
        exec(compile(body, where, "exec"), names)
        if last is not None:
            value = eval(compile(ast.Expression(last.value), where, "eval"), names)
            shown.append(_shown(value))
    return names, shown


def _shown(value: Any) -> str:
    for way in ("_repr_html_", "_repr_png_"):
        if hasattr(value, way) and (text := getattr(value, way)()) is not None:
            return str(text)
    return repr(value)


@pytest.fixture
def here(tmp_path, monkeypatch):
    """A campaign with a backlash of half a millimetre in the working directory."""
    monkeypatch.chdir(tmp_path)
    folder = tmp_path / "campaign"
    folder.mkdir()
    save(campaign(Truth(seed=41, slips=SLIPS, repeats=2, backlash=5e-4)), folder)
    return tmp_path


def test_every_notebook_is_run_here():
    names = {path.stem for path in BOOKS.glob("*.ipynb")}
    assert names == {"slip_step", "discovery_loop", "own_effect"}


def test_a_slip_step_from_bag_to_report(tmp_path, monkeypatch):
    monkeypatch.syspath_prepend(str(ROOT / "tests" / "analysis_data"))
    from bagmaker import write_run
    from steptable import step_table

    monkeypatch.chdir(tmp_path)
    for kappa in (-0.05, 0.05):
        table = step_table(kappa, noise=5.0)
        name = f"TOY_{100 * kappa:+.0f}"
        columns = {k: v for k, v in table.columns.items()}
        record = yaml.safe_dump(table.info.to_dict() | {"tire": "TOY"})
        write_run(tmp_path / "campaign" / name, columns, record, name)
    names, shown = run_cells(BOOKS / "slip_step.ipynb")
    assert names["page"].is_file() and len(names["runs"]) == 2
    assert "-0.05" in shown[0] and "<table" in shown[0]


def test_the_loop_of_discovery(here):
    names, shown = run_cells(BOOKS / "discovery_loop.ipynb")
    assert "drive_backlash" in names["grown"].effects
    assert names["grown"].numbers["rmse"] < 0.5 * names["grown"].numbers["rmse_before"]
    assert (here / "model.yaml").is_file()
    assert sum("<img" in text or "PNG" in text for text in shown) == 5


def test_an_effect_of_ones_own(here):
    names, shown = run_cells(BOOKS / "own_effect.ipynb")
    assert names["model"].effects == ["rail_friction"]
    assert any("rail_friction" in text for text in shown)
    with pytest.raises(FlatplankError):
        names["model"].add("rail_friction")
    assert "rail_friction" not in sys.modules
