# SPDX-License-Identifier: Apache-2.0
"""Generates docs/reference/glossary.md from the words of the code:
`python -m flatplank_validation.pages.glossary FILE`."""

from __future__ import annotations

import sys
from collections.abc import Mapping
from pathlib import Path

from flatplank_analysis import effect_words
from flatplank_analysis.column_words import COLUMNS, SWEEPS
from flatplank_analysis.words import BASE, COORDINATES, OUTPUTS, Word
from flatplank_data.wording import NO_UNIT, displayed

HEAD = """\
# Glossary

Written by `python -m flatplank_validation.pages.glossary docs/reference/glossary.md`; a test keeps
it so. `./flatplank explain WORD` prints a line of the glossary. Words of single effects are on
[their pages](effects/README.md), troubles in [troubles](troubles.md).
"""


def page() -> str:
    """The whole file."""
    parts = [HEAD, "## Words of the outputs\n", _table(OUTPUTS)]
    parts += ["\n## Coordinates of effects and residuals\n", _table(COORDINATES)]
    parts += ["\n## Parameters of the base of the search\n", _table(BASE)]
    parts += ["\n## Parameters and coordinates of sweeps\n", _table(SWEEPS)]
    parts += ["\n## Parameters of effects\n", _table(effect_words.parameters())]
    return "\n".join([*parts, "\n## Columns of tables\n", _table(COLUMNS)]) + "\n"


def _shown(unit: str) -> str:
    """The display unit; empty where a number has none."""
    name = displayed(unit)[1]
    return "" if name in NO_UNIT else name


def _table(words: Mapping[str, Word]) -> str:
    rows = ["| word | title | symbol | unit | meaning |", "|---|---|---|---|---|"]
    rows += [
        f"| `{name}` | {w.title} | {w.symbol} | {_shown(w.unit)} | {w.sentence} |"
        for name, w in words.items()
    ]
    return "\n".join(rows)


if __name__ == "__main__":
    Path(sys.argv[1]).write_text(page(), encoding="utf-8")
