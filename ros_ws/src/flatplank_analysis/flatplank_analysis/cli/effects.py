# SPDX-License-Identifier: Apache-2.0
"""The library of effects: list, explain, check your own."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from pathlib import Path

from flatplank_analysis.cli import common
from flatplank_analysis.discovery.effect import Effect
from flatplank_analysis.discovery.modelfile import ModelFile
from flatplank_analysis.effects.registry import find, library, load_file
from flatplank_analysis.words import line
from flatplank_data.arguments import Parser, add_json
from flatplank_data.wording import quantity, sized, span, table


def main(argv: Sequence[str] | None = None) -> int:
    """`flatplank effects [NAME] [--effects FILE] [--trust FILE] [--write DIR] [--json]`,
    `... check FILE`, `... new NAME`, `... try FILE DIR`."""
    words = list(argv or ())
    if words[:1] and words[0] in COMMANDS:
        return COMMANDS[words[0]](words[1:])
    parser = Parser(prog="flatplank effects", description=__doc__)
    parser.add_argument(
        "what", nargs="*",
        help="nothing: all; NAME: one; check FILE: test a file; new NAME: begin a file; "
        "try FILE DIR: what it would remove",
    )  # fmt: skip
    common.effect_arguments(parser)
    parser.add_argument("--write", metavar="DIR", help="a page with a picture for every effect")
    add_json(parser)
    arguments = parser.parse_args(argv)
    files = common.effect_files(arguments)
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
    words = ("title", "kind", "coordinate", "source", "what", "check", "shown_by", "removes")
    return {
        "name": effect.identifier,
        **{k: getattr(effect, k) for k in words},
        "parameters": [
            {k: getattr(p, k) for k in ("name", "title", "symbol", "unit", "null")}
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
    for key in ("what", "check", "shown_by", "removes", "source"):
        if data[key]:
            print(f"  {key.replace('_', ' ')}: {data[key]}")
    rows = [("parameter", "symbol", "null", "range", "matters")]
    for p in data["parameters"]:
        (low, high), unit = p["bounds"], p["unit"]
        null, matters = (quantity(p[k], unit, axis=(low, high)) for k in ("null", "matters"))
        matters = matters if p["matters"] else "-"
        rows.append((p["name"], p["symbol"] or "-", null, span(low, high, unit), matters))
    print(table(rows))
    for p in effect.parameters():
        if p.note:
            print(f"  {line(p.name, p.word)}")
    return 0


def _check(argv: Sequence[str]) -> int:
    """Test the contract of the effects of a file."""
    from flatplank_analysis.effects.checks import check_effect

    parser = Parser(prog="flatplank effects check", description=_check.__doc__)
    parser.add_argument("file", metavar="FILE", help="effects of your own")
    common.effect_arguments(parser)
    add_json(parser)
    arguments = parser.parse_args(argv)
    common.effect_files(arguments)
    faults = {e.identifier: check_effect(e) for e in load_file(arguments.file)}
    if arguments.json:
        common.print_json({name: {"ok": not f, "faults": f} for name, f in faults.items()})
    else:
        for name, found in faults.items():
            print(f"{name}: " + ("passes the contract" if not found else "; ".join(found)))
    return 1 if any(faults.values()) else 0


def _new(argv: Sequence[str]) -> int:
    from flatplank_analysis.cli import new_effect

    return new_effect.main(argv)


def _try(argv: Sequence[str]) -> int:
    """What the effects of a file would remove from the error, each alone; nothing is written."""
    from flatplank_analysis.cli import loop

    parser = Parser(prog="flatplank effects try", description=_try.__doc__)
    parser.add_argument("file", metavar="FILE", help="effects of your own")
    parser.add_argument("folder", metavar="DIR", help="campaign folder")
    parser.add_argument("--model", metavar="FILE", help="model file (YAML); default: that of DIR")
    common.effect_arguments(parser)
    common.mapping_argument(parser)
    add_json(parser)
    arguments = parser.parse_args(argv)
    if not {arguments.file} & {*arguments.effects, *arguments.trust}:
        arguments.effects.append(arguments.file)
    session, model = loop.open_to_look(arguments, own=True)
    model = model or ModelFile(campaign=arguments.folder)
    loop.progress("the model as it is", 0.3)
    before, found = session.fit(model), {}
    for effect in load_file(arguments.file):
        loop.progress(f"refit with {effect.identifier}", 0.6)
        _, _, found[effect.identifier] = session.add(model, effect.identifier, before)
    loop.progress_done()
    if arguments.json:
        common.print_json(found)
        return 0
    for name, n in found.items():
        print(
            f"{name}: {sized(n['size'], n['interval'], n['unit'])}; error of Fx "
            f"{n['rmse_before']:.1f} -> {n['rmse']:.1f} N, held out {n['held_out']:.1f} N, "
            f"floor {n['floor']:.1f} N"
        )
        for doubt in n["doubts"]:
            print(f"  doubt: {doubt}")
    return 0


COMMANDS: dict[str, Callable[[Sequence[str]], int]] = {"check": _check, "new": _new, "try": _try}
