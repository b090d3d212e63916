# SPDX-License-Identifier: Apache-2.0
"""What a word of the outputs means, parameters included.

Without a word: the whole glossary.
"""

from __future__ import annotations

from collections.abc import Sequence

from flatplank_analysis import words
from flatplank_analysis.cli import common, effects
from flatplank_analysis.effects.registry import library
from flatplank_analysis.slip_sweeps import effects as sweeps
from flatplank_data.arguments import Parser, add_json


def sweep_effects() -> dict[str, words.Word]:
    """Effects that only sweeps show, as words."""
    return {
        e.identifier: words.Word(
            e.title, f"{e.what[0].upper()}{e.what[1:]}.", e.main_parameter().unit
        )
        for e in sweeps.effects()
    }


def main(argv: Sequence[str] | None = None) -> int:
    """`flatplank explain [WORD] [--json]`."""
    parser = Parser(prog="flatplank explain", description=__doc__)
    parser.add_argument("word", nargs="*", help="as printed: patch_order, at floor, road_play")
    add_json(parser)
    options = parser.parse_args(argv)
    name = " ".join(options.word)
    if name in library():
        return effects.main([name, *["--json"] * options.json])
    chosen = {name: sweep_effects().get(name) or words.explain(name)} if name else words.ALL
    if options.json:
        common.print_json({key: word._asdict() for key, word in chosen.items()})
    else:
        print("\n".join(words.line(key, word) for key, word in chosen.items()))
    return 0
