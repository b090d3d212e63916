# SPDX-License-Identifier: Apache-2.0
"""What a word of the outputs means, parameters included.

Without a word: the whole glossary.
"""

from __future__ import annotations

from collections.abc import Sequence

from flatplank_analysis import effect_words, words
from flatplank_analysis.cli import common, effects
from flatplank_analysis.effects.registry import library
from flatplank_analysis.word import Word
from flatplank_data.arguments import Parser, add_json


def main(argv: Sequence[str] | None = None) -> int:
    """`flatplank explain [WORD] [--json]`."""
    parser = Parser(prog="flatplank explain", description=__doc__)
    parser.add_argument(
        "word", nargs="*", help="as printed: patch_order, at floor, road_play, gap"
    )
    add_json(parser)
    options = parser.parse_args(argv)
    name = " ".join(options.word)
    if name in library():
        return effects.main([name, *["--json"] * options.json])
    chosen = _words_of(name) if name else {**words.ALL, **effect_words.parameters()}
    if options.json:
        common.print_json({key: word._asdict() for key, word in chosen.items()})
    else:
        print("\n".join(words.line(key, word) for key, word in chosen.items()))
    return 0


def _words_of(name: str) -> dict[str, Word]:
    """The words of that name: of an output, of an effect, and of each parameter `effect.name`."""
    words_of = effect_words.parameters()
    every = {k: (k, k.partition(".")[2]) for k in words_of}
    named = {k: words_of[k] for k, names in every.items() if name in names}
    word = effect_words.sweep_effects().get(name) or words.known(name)
    if word or not named:
        others = {one for names in every.values() for one in names}
        named = {name: word or words.explain(name, sorted(others))} | named
    return named
