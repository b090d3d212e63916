# SPDX-License-Identifier: Apache-2.0
"""The library of effects: list, explain, check your own."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

from flatplank_analysis.cli import common
from flatplank_analysis.discovery.effect import Effect
from flatplank_analysis.effects.registry import find, library, load_file
from flatplank_data.arguments import Parser
from flatplank_data.wording import table


def main(argv: Sequence[str] | None = None) -> int:
    """`flatplank effects [NAME] [--effects FILE] [--trust FILE] [--write DIR] [--json]`,
    `... check FILE`."""
    parser = Parser(prog="flatplank effects", description=__doc__)
    parser.add_argument("what", nargs="*", help="nothing: all; NAME: one; check FILE: test a file")
    common.effect_arguments(parser)
    parser.add_argument("--write", metavar="DIR", help="a page with a picture for every effect")
    parser.add_argument("--json", action="store_true", help="print JSON for programs")
    arguments = parser.parse_args(argv)
    files = common.effect_files(arguments)
    if arguments.what[:1] == ["check"]:
        if len(arguments.what) != 2:
            parser.error("check FILE")
        return _check(arguments.what[1], arguments.json)
    if arguments.write:
        from flatplank_analysis.cli.effect_pages import write

        count = write(library(files), Path(arguments.write))
        print(f"{count} pages in {arguments.write}")
        return 0
    if arguments.what:
        return _one(find(arguments.what[0], files), arguments.json)
    return _all(library(files), arguments.json)


def describe(effect: type[Effect]) -> dict:
    """Texts and parameters of an effect as plain values, for JSON."""
    words = ("title", "kind", "coordinate", "source", "what", "check", "removes")
    return {
        "name": effect.identifier,
        **{k: getattr(effect, k) for k in words},
        "parameters": [
            {k: getattr(p, k) for k in ("name", "unit", "null")}
            | {"bounds": [p.lower, p.upper]}
            | {k: getattr(p, k) for k in ("screen", "matters", "note")}
            for p in effect.parameters()
        ],
    }


def _all(known: dict[str, type[Effect]], as_json: bool) -> int:
    if as_json:
        common.print_json([describe(e) for e in known.values()])
        return 0
    rows = [(e.identifier, e.kind, e.title) for e in known.values()]
    common.print_rows(("name", "kind", "what"), rows)
    return 0


def _one(effect: type[Effect], as_json: bool) -> int:
    data = describe(effect)
    if as_json:
        common.print_json(data)
        return 0
    print(f"{data['name']}: {data['title']} ({data['kind']}; shows over {data['coordinate']})")
    for key in ("what", "check", "removes", "source"):
        print(f"  {key}: {data[key]}")
    rows = [("parameter", "unit", "null", "range", "matters")]
    for p in data["parameters"]:
        low, high = p["bounds"]
        cells = (f"{p['null']:g}", f"{low:g} .. {high:g}", f"{p['matters']:g}")
        rows.append((p["name"], p["unit"], *cells))
    print(table(rows))
    return 0


def _check(path: str, as_json: bool) -> int:
    from flatplank_analysis.effects.checks import check_effect

    faults = {e.identifier: check_effect(e) for e in load_file(path)}
    if as_json:
        common.print_json({name: {"ok": not f, "faults": f} for name, f in faults.items()})
    else:
        for name, found in faults.items():
            print(f"{name}: " + ("passes the contract" if not found else "; ".join(found)))
    return 1 if any(faults.values()) else 0
