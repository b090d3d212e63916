# SPDX-License-Identifier: Apache-2.0
"""Checks inputs from a page on the server: numbers, names, folders, files.

Every function returns the clean value or raises ValueError with one line: what, and what to do.
"""

from __future__ import annotations

from collections.abc import Iterable
from pathlib import Path
from typing import Any, NamedTuple

from flatplank_data.errors import RecordingError
from flatplank_data.limits import LIMITS, Limit
from flatplank_data.names import nearest_hint
from flatplank_data.naming import check_name
from flatplank_data.params import ParamInfo, parameter_infos
from flatplank_hw.encoders import EncoderParameters
from flatplank_hw.encoders.params import SETUP_CONSTANTS as OF_ENCODERS
from flatplank_hw.hub import HubParameters
from flatplank_hw.hub.params import SETUP_CONSTANTS as OF_HUB

NOTE_LENGTH = 2000


def number(value: Any, what: str, low: float, high: float, unit: str = "") -> float:
    """A finite number within its range."""
    try:
        result = float(value)
    except (TypeError, ValueError):
        raise ValueError(f"{what}: give a number, not {str(value)[:40]!r}") from None
    if reason := Limit(low, high, unit).refusal(what, result):
        raise ValueError(reason)
    return result


def setting(value: Any, name: str) -> float:
    """A setting of the machine within its limit."""
    limit = LIMITS[name]
    return number(value, name, limit.low, limit.high, limit.unit)


def choice(value: Any, known: Iterable[str], what: str) -> str:
    """One of the known names."""
    names = list(known)
    if value not in names:
        raise ValueError(
            f"{what} {str(value)[:40]!r} is not known{nearest_hint(str(value), names)}"
        )
    return value


def name(value: Any) -> str:
    """A measurement's name: one plain file name."""
    try:
        return check_name(str(value or "").strip())
    except RecordingError as error:
        raise ValueError(str(error)) from None


def note(value: Any) -> str:
    """Free text, without control characters."""
    text = "".join(c for c in str(value or "") if c.isprintable() or c == "\n")
    if len(text) > NOTE_LENGTH:
        raise ValueError(f"the note has {len(text)} characters, at most {NOTE_LENGTH} are kept")
    return text


def inside(root: Path, value: Any, what: str = "folder") -> Path:
    """A path below `root` after resolving links, so that no page leaves the data folder."""
    text = str(value or "").strip()
    if not text.isprintable() or len(text) > 500:
        raise ValueError(f"{what}: not a path")
    base = root.resolve()
    target = (base / text).resolve()
    if target != base and base not in target.parents:
        raise ValueError(f"{what} {text[:80]!r} is outside the data folder; name one below it")
    return target


def folder_below(root: Path, value: Any) -> Path:
    """A data folder below `root`, made if missing. Every part must be a plain name."""
    text = str(value or "").strip()
    target = inside(root, text)
    for part in Path(text).parts:
        name(part)
    target.mkdir(parents=True, exist_ok=True)
    return target


class Constant(NamedTuple):
    """One constant and the node that uses it."""

    node: str
    info: ParamInfo

    @property
    def name(self) -> str:
        return self.info.name


def _of(node: str, cls: type, names: tuple[str, ...]) -> list[Constant]:
    return [Constant(node, info) for info in parameter_infos(cls) if info.name in names]


CONSTANTS = {
    c.name: c
    for c in (
        *_of("measurement_hub", HubParameters, OF_HUB),
        *_of("encoders", EncoderParameters, OF_ENCODERS),
    )
}
"""name -> constant"""
