# SPDX-License-Identifier: Apache-2.0
"""The model file: base, parameters, effects, and the history of how it came about (YAML).

Written to a new file that replaces the old one at once, so that it is never half there.
"""

from __future__ import annotations

import os
import tempfile
from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Any

import yaml

from flatplank_analysis.errors import FlatplankError

FORMAT = "flatplank-discovery-model/1"


@dataclass(frozen=True)
class Entry:
    """An effect in a model file."""

    name: str
    parameters: Mapping[str, float] = field(default_factory=dict)
    file: str = ""
    """the user's file that defines it; empty for a shipped one"""


@dataclass(frozen=True)
class ModelFile:
    """Content of a model file."""

    base: str = "contact_patch"
    campaign: str = ""
    parameters: Mapping[str, float] = field(default_factory=dict)
    effects: tuple[Entry, ...] = ()
    history: tuple[Mapping[str, Any], ...] = ()

    def to_dict(self) -> dict[str, Any]:
        """Plain values for YAML."""
        return {
            "format": FORMAT,
            "base": self.base,
            "campaign": self.campaign,
            **self.state(),
            "history": [dict(h) for h in self.history],
        }

    def state(self) -> dict[str, Any]:
        """What a step of the history keeps: base parameters and effects with their files."""
        return {
            "parameters": {k: float(v) for k, v in self.parameters.items()},
            "effects": [
                {"name": e.name, "parameters": {k: float(v) for k, v in e.parameters.items()}}
                | ({"file": e.file} if e.file else {})
                for e in self.effects
            ],
        }

    def with_step(self, action: str, effect: str, numbers: Mapping[str, Any]) -> ModelFile:
        """The same with one more line of history; it keeps the model as it is now."""
        step = {"step": len(self.history), "action": action, "effect": effect, **numbers}
        return replace(self, history=(*self.history, step | self.state()))

    def undone(self) -> ModelFile:
        """The model as it was before the last step, whose line of history goes."""
        if len(self.history) < 2:
            raise FlatplankError("nothing to undo", "model file", "its history has no step")
        before = self.history[-2]
        if "parameters" not in before:
            raise FlatplankError(
                "the history keeps no base parameters", "model file",
                "written before steps could be undone; use `flatplank remove EFFECT DIR`",
            )  # fmt: skip
        return replace(
            self,
            parameters=_numbers(before["parameters"], "history"),
            effects=tuple(_entry(e, "history") for e in before.get("effects") or ()),
            history=self.history[:-1],
        )


_KEYS = {"format", "base", "campaign", "parameters", "effects", "history"}


def load_model(path: str | os.PathLike[str]) -> ModelFile:
    """Read a model file."""
    where = os.fspath(path)
    try:
        raw = yaml.safe_load(Path(path).read_text(encoding="utf-8"))
    except FileNotFoundError as error:
        raise FlatplankError("no such model file", where, "`flatplank add` makes one") from error
    except yaml.YAMLError as error:
        raise FlatplankError(f"not YAML ({error})", where, "mend the file") from error
    if not isinstance(raw, Mapping) or raw.get("format") != FORMAT:
        raise FlatplankError(f"is not of format {FORMAT}", where, "write 'format: ...' first")
    unknown = sorted(set(raw) - _KEYS)
    if unknown:
        raise FlatplankError(f"unknown key '{unknown[0]}'", where, f"known: {sorted(_KEYS)}")
    return ModelFile(
        base=str(raw.get("base") or "contact_patch"),
        campaign=str(raw.get("campaign") or ""),
        parameters=_numbers(raw.get("parameters"), where),
        effects=tuple(_entry(e, where) for e in raw.get("effects") or ()),
        history=tuple(dict(h) for h in raw.get("history") or ()),
    )


def _entry(raw: Any, where: str) -> Entry:
    if isinstance(raw, str):
        return Entry(raw)
    if not isinstance(raw, Mapping) or "name" not in raw:
        raise FlatplankError("effect without 'name'", where, "write '- name: road_play'")
    return Entry(
        str(raw["name"]), _numbers(raw.get("parameters"), where), str(raw.get("file") or "")
    )


def _numbers(raw: Any, where: str) -> dict[str, float]:
    try:
        return {str(k): float(v) for k, v in (raw or {}).items()}
    except (AttributeError, TypeError, ValueError) as error:
        raise FlatplankError(f"parameters hold {raw!r}", where, "write 'name: number'") from error


def save_model(model: ModelFile, path: str | os.PathLike[str]) -> None:
    """Write a model file atomically."""
    text = yaml.safe_dump(model.to_dict(), sort_keys=False, allow_unicode=True)
    write_atomic(path, text)


def write_atomic(path: str | os.PathLike[str], text: str) -> None:
    """Replace a text file at once: it is the old one or the new one, never half."""
    target = Path(path)
    try:
        handle, temporary = tempfile.mkstemp(dir=target.parent, prefix=f".{target.name}.")
    except OSError as error:
        raise FlatplankError(
            f"cannot be written ({error.strerror})", str(target), "choose another place"
        ) from error
    try:
        with os.fdopen(handle, "w", encoding="utf-8") as stream:
            stream.write(text)
            stream.flush()
            os.fsync(stream.fileno())
        os.chmod(temporary, 0o644)
        os.replace(temporary, target)
    except BaseException:
        Path(temporary).unlink(missing_ok=True)
        raise
