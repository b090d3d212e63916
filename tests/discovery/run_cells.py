# SPDX-License-Identifier: Apache-2.0
"""Runs the cells of a notebook in one namespace; what ends a cell is shown as it is there."""

from __future__ import annotations

import ast
import json
from pathlib import Path
from typing import Any


def cells(path: Path) -> list[str]:
    """Texts of the code cells; a notebook is kept without results."""
    book = json.loads(path.read_text(encoding="utf-8"))
    assert book["nbformat"] == 4 and book["metadata"]["kernelspec"]["language"] == "python"
    code = [c for c in book["cells"] if c["cell_type"] == "code"]
    assert all(c["outputs"] == [] and c["execution_count"] is None for c in code)
    return ["".join(c["source"]) for c in code]


def run(path: Path) -> tuple[dict[str, Any], list[str]]:
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
