# SPDX-License-Identifier: Apache-2.0
"""The notebooks run from their first cell to their last, on campaigns of their kind."""

from __future__ import annotations

import ast
import io
import json
import os
import re
import sys
from base64 import b64encode
from collections.abc import Iterator
from contextlib import redirect_stdout
from pathlib import Path
from typing import Any

import pytest
import yaml
from bristles import Truth, campaign, save
from matplotlib.figure import Figure

from flatplank_data.errors import FlatplankError
from flatplank_validation.sweep_sets.brush import Brush, Plan, sweeps, text_of

ROOT = Path(__file__).resolve().parents[2]
BOOKS = ROOT / "examples" / "notebooks"
SLIPS = (-0.05, -0.01, 0.01, 0.05)


STORE = bool(os.environ.get("FLATPLANK_NOTEBOOKS"))
"""write what the cells show into the notebooks"""


def run_cells(path: Path) -> tuple[dict[str, Any], list[str]]:
    """The names at the end, and per cell that shows something its HTML or its text.

    What the notebook shows to a reader who does not run it is what its cells show here, but for
    numbers.
    """
    book = json.loads(path.read_text(encoding="utf-8"))
    assert book["nbformat"] == 4 and book["metadata"]["kernelspec"]["language"] == "python"
    names: dict[str, Any] = {}
    shown = []
    for number, cell in enumerate((c for c in book["cells"] if c["cell_type"] == "code"), 1):
        value, printed = run_cell("".join(cell["source"]), f"{path.name}, cell {number}", names)
        outputs = outputs_of(value, printed, number)
        if STORE:
            cell["outputs"], cell["execution_count"] = outputs, number
        assert list(map(words, cell["outputs"])) == list(map(words, outputs)), number
        if value is not None:
            shown.append(str(next(iter(outputs[-1]["data"].values()))))
    if STORE:
        path.write_text(json.dumps(book, indent=1, ensure_ascii=False) + "\n", encoding="utf-8")
    return names, shown


def run_cell(text: str, where: str, names: dict[str, Any]) -> tuple[Any, str]:
    """The value of the last expression of a cell, and what the cell prints."""
    body = ast.parse(text)
    last = body.body.pop() if isinstance(body.body[-1], ast.Expr) else None
    with redirect_stdout(io.StringIO()) as printed:
        exec(compile(body, where, "exec"), names)
        value = None
        if last is not None:
            value = eval(compile(ast.Expression(last.value), where, "eval"), names)
    return value, printed.getvalue()


def outputs_of(value: Any, printed: str, number: int) -> list[dict[str, Any]]:
    """Outputs of a cell as notebooks keep them."""
    out: list[dict[str, Any]] = []
    if printed:
        out.append({"name": "stdout", "output_type": "stream", "text": printed})
    if value is not None:
        data = dict(_kinds(value)) | {"text/plain": _plain(value)}
        out.append({"data": data, "execution_count": number, "metadata": {},
                    "output_type": "execute_result"})  # fmt: skip
    return out


def _kinds(value: Any) -> Iterator[tuple[str, str]]:
    for way, kind in (("_repr_html_", "text/html"), ("_repr_png_", "image/png")):
        found = getattr(value, way)() if hasattr(value, way) else None
        if found is not None:
            yield kind, found if isinstance(found, str) else b64encode(found).decode()
    if isinstance(value, Figure):
        with io.BytesIO() as stream:
            value.savefig(stream, format="png", dpi=80, metadata={"Software": None})
            yield "image/png", b64encode(stream.getvalue()).decode()


def _plain(value: Any) -> str:
    return re.sub(r" at 0x[0-9a-f]+", "", repr(value))


def words(output: dict[str, Any]) -> list[tuple[str, str]]:
    """What an output says without its numbers and pictures."""
    texts = output.get("data") or {"text": output["text"]}
    return [
        (kind, "" if kind == "image/png" else _NUMBERS.sub("", _PICTURES.sub("", "".join(text))))
        for kind, text in sorted(texts.items())
    ]


_NUMBERS = re.compile(r"[-+]?\d[\d.,e+-]*|\s+|nan")
PNG = b64encode(b"\x89PNG").decode()[:5]
_PICTURES = re.compile(r"base64,[A-Za-z0-9+/=]+")


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
    assert names == {"slip_step", "discovery_loop", "own_effect", "sweeps"}


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
    assert sum("<img" in text or text.startswith(PNG) for text in shown) == 5


def test_an_effect_of_ones_own(here):
    names, shown = run_cells(BOOKS / "own_effect.ipynb")
    assert names["model"].effects == ["rail_friction"]
    assert any("rail_friction" in text for text in shown)
    with pytest.raises(FlatplankError):
        names["model"].add("rail_friction")
    assert "rail_friction" not in sys.modules


def test_from_sweeps_to_a_named_effect(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    columns = sweeps(Brush(over_temperature=0.003), Plan(), seed=31)
    (tmp_path / "lateral.csv").write_text(text_of(columns), encoding="utf-8")
    names, _ = run_cells(BOOKS / "sweeps.ipynb")
    assert list(names["told"].effects["name"]) == ["grip_temperature"]
    assert names["told"].verdict == "found" and names["grown"].verdict == "at floor"
