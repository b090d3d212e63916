# SPDX-License-Identifier: Apache-2.0
"""A new effect file from a few answers: what changes, over which coordinate, by how much."""

from __future__ import annotations

import keyword
import sys
from collections.abc import Collection, Sequence
from pathlib import Path
from typing import NamedTuple

from flatplank_analysis.contact_patch.tire_runs import coordinates_of
from flatplank_analysis.effects.checks import KINDS, probe_model
from flatplank_data.arguments import Parser
from flatplank_data.errors import FlatplankError
from flatplank_data.files import write_atomic
from flatplank_data.names import nearest_hint


class Target(NamedTuple):
    """What an effect changes."""

    text: str
    hook: str
    """hook of `TireEffect`, and the name of its argument"""
    line: str
    """how the argument changes by `self.amount` times `shape`"""
    unit: str
    matters: float
    """[unit]"""


TARGETS = {
    "fx": Target("reading of the longitudinal force", "signal",
                 "signal.fx = signal.fx + self.amount * shape", "N", 5.0),
    "fy": Target("reading of the lateral force", "signal",
                 "signal.fy = signal.fy + self.amount * shape", "N", 5.0),
    "load": Target("load on the tire, as a share of it", "tire",
                   "tire.load = tire.load * (1.0 + self.amount * shape)", "1", 0.005),
    "friction": Target("friction of the road, as a share of it", "tire",
                       "tire.friction = tire.friction * (1.0 + self.amount * shape)", "1", 0.01),
}  # fmt: skip
STEPS = 2.0
"""step of the screening over the size that matters [-]"""
MOST = 60.0
"""largest size over the size that matters [-]"""
FORM = '''"""{title}. The shape over the {coordinate} is a line until you change it."""

from dataclasses import dataclass

import numpy as np

from flatplank_analysis.contact_patch.tire_runs import coordinate_of
from flatplank_analysis.discovery.parameters import param
from flatplank_analysis.effects.base import {argument}, TireEffect


@dataclass(frozen=True)
class {class_name}(TireEffect):
    identifier = "{name}"
    title = "{title}"
    kind = "{kind}"
    coordinate = "{coordinate}"
    source = "{source}"
    what = "{what}"
    check = "{check}"
    removes = "{removes}"

    amount: float = param(
        0.0, unit="{unit}", bounds=({low:g}, {high:g}), screen={screen:g}, matters={matters:g},
    )

    def {hook}(self, {hook}: {argument}) -> None:
        at = coordinate_of({hook}.data, "{coordinate}").values
        shape = (at - np.mean(at)) / max(np.ptp(at), 1e-12)  # a line of height 1 over the runs
        {line}
'''


TEXTS = {
    "title": "what is it called", "what": "what happens on the machine",
    "check": "how is it checked on the machine", "removes": "what removes it",
    "source": "where does the idea come from",
}  # fmt: skip
"""text of an effect -> question"""


def main(argv: Sequence[str]) -> int:
    """`flatplank effects new NAME [--changes ...] [--over ...]`; asks for what is not given."""
    places = sorted(coordinates_of(probe_model().data))
    parser = Parser(prog="flatplank effects new", description=__doc__)
    parser.add_argument("name", help="identifier: small letters, digits and _")
    changes = "; ".join(f"{name}: {t.text}" for name, t in TARGETS.items())
    parser.add_argument("--changes", help=changes)
    parser.add_argument("--over", help=f"coordinate: {', '.join(places)}")
    parser.add_argument("--kind", help=", ".join(KINDS))
    for option, text in TEXTS.items():
        parser.add_argument(f"--{option}", help=text)
    parser.add_argument("--out", type=Path, help="file; default: NAME.py")
    given = parser.parse_args(argv)
    name = _name(given.name)
    file = given.out or Path(f"{name}.py")
    if file.exists():
        raise FlatplankError("is there already", str(file), "choose another name, or --out FILE")
    target = TARGETS[_known(_answer(given.changes, changes, "fx"), TARGETS, "target")]
    question = f"over which coordinate: {', '.join(places)}"
    place = _known(_answer(given.over, question, "plank position"), places, "coordinate")
    kind = _known(_answer(given.kind, f"of: {', '.join(KINDS)}", "machine"), KINDS, "kind")
    texts = {k: _answer(getattr(given, k), text, text.capitalize()) for k, text in TEXTS.items()}
    words = {k: " ".join(v.split()).replace("\\", "/").replace('"', "'") for k, v in texts.items()}
    high = MOST * target.matters
    text = FORM.format(
        name=name, class_name="".join(map(str.capitalize, name.split("_"))), kind=kind,
        coordinate=place, hook=target.hook, argument=target.hook.capitalize(), line=target.line,
        unit=target.unit, low=-high, high=high, screen=STEPS * target.matters,
        matters=target.matters, **words,
    )  # fmt: skip
    write_atomic(file, text)
    print(f"{file}: change the shape where the physics needs it, then")
    print(f"  flatplank effects check {file} --trust {file}")
    print(f"  flatplank effects try {file} DIR      # the error that it would remove, in seconds")
    return 0


def _name(name: str) -> str:
    if not name.replace("_", "").isalnum() or not name.islower() or not name.isidentifier():
        raise FlatplankError(f"'{name}' is no name", "effects new", "small letters, digits and _")
    if keyword.iskeyword(name):
        raise FlatplankError(f"'{name}' is a word of Python", "effects new", "choose another one")
    return name


def _answer(given: str | None, question: str, usual: str) -> str:
    """What an option gives, else the answer to a question, else what is usual."""
    if given is not None:
        return given
    if not sys.stdin.isatty():
        return usual
    return input(f"{question} [{usual}]: ").strip() or usual


def _known(answer: str, known: Collection[str], what: str) -> str:
    if answer not in known:
        hint = nearest_hint(answer, known)
        raise FlatplankError(f"unknown {what} '{answer}'{hint}", "effects new", ", ".join(known))
    return answer
