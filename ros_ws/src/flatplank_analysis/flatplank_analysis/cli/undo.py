# SPDX-License-Identifier: Apache-2.0
"""Take back the last `add` or `remove`: the model file is what it was, to the number."""

from __future__ import annotations

from collections.abc import Sequence

from flatplank_analysis.cli import common, loop
from flatplank_analysis.discovery.modelfile import load_model, save_unchanged
from flatplank_data.arguments import Parser


def main(argv: Sequence[str] | None = None) -> int:
    """`flatplank undo [DIR] [--model FILE] [--json]`."""
    parser = Parser(prog="flatplank undo", description=__doc__)
    parser.add_argument("folder", metavar="DIR", nargs="?", help="campaign folder")
    parser.add_argument("--model", metavar="FILE", help="model file (YAML)")
    parser.add_argument("--json", action="store_true", help="print JSON for programs")
    arguments = parser.parse_args(argv)
    return common.guarded("undo", lambda: _run(arguments))


def _run(arguments) -> int:
    path = loop.model_path(arguments)
    model = load_model(path)
    before = model.undone()
    save_unchanged(before, path)
    taken, now = model.history[-1], before.history[-1]
    if arguments.json:
        names = [e.name for e in before.effects]
        common.print_json(
            {"model": str(path), "undone": {k: taken[k] for k in ("action", "effect")},
             "effects": names, **{k: now.get(k) for k in ("rmse", "held_out", "floor")}}
        )  # fmt: skip
        return 0
    error = f": error of Fx {now['rmse']:.1f} N" if now.get("rmse") is not None else ""
    print(f"{taken['action']} {taken['effect']} undone{error}; written to {path}")
    return 0
