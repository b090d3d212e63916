# SPDX-License-Identifier: Apache-2.0
"""What a word of the outputs means, parameters included.

Without a word: the whole glossary.
"""

from __future__ import annotations

from collections.abc import Sequence

from flatplank_analysis import words
from flatplank_analysis.cli import common, effects
from flatplank_analysis.effects.registry import library
from flatplank_data.arguments import Parser, add_json


def main(argv: Sequence[str] | None = None) -> int:
    """`flatplank explain [WORD] [--json]`."""
    parser = Parser(prog="flatplank explain", description=__doc__)
    parser.add_argument("word", nargs="*", help="as printed: patch_order, at floor, road_play")
    add_json(parser)
    options = parser.parse_args(argv)
    name = " ".join(options.word)
    if name in library():
        return effects.main([name, *["--json"] * options.json])
    chosen = {name: words.explain(name)} if name else words.ALL
    if options.json:
        common.print_json({key: word._asdict() for key, word in chosen.items()})
    else:
        print("\n".join(words.line(key, word) for key, word in chosen.items()))
    return 0
