# SPDX-License-Identifier: Apache-2.0
"""The model file: base, parameters, effects, and their history (YAML).

A new file replaces the old one atomically, so that it is never incomplete. The paths in it are
relative to its folder, so that a moved campaign stays whole; in memory they are as Python needs
them.
"""

from __future__ import annotations

import math
import os
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import partial
from pathlib import Path
from typing import Any

import yaml

from flatplank_data.errors import FlatplankError
from flatplank_data.files import only_writer, write_atomic
from flatplank_data.wording import one_of
from flatplank_data.yaml_text import dump_yaml, parse_yaml

FORMAT = "flatplank-discovery-model/1"
TIR = ".tir"
"""how a base that is a tire file ends"""


@dataclass(frozen=True)
class Entry:
    """An effect in a model file."""

    name: str
    parameters: Mapping[str, float] = field(default_factory=dict)
    file: str = ""
    """path of the user's file that defines it; empty for a shipped effect"""
    alike: tuple[str, ...] = ()
    """other members of its class: the runs cannot tell which of them it is"""

    @property
    def words(self) -> str:
        """'A or B'."""
        return one_of([self.name, *self.alike])

    def to_dict(self) -> dict[str, Any]:
        """Plain values for YAML."""
        more: dict[str, Any] = {"file": self.file} if self.file else {}
        more |= {"or": list(self.alike)} if self.alike else {}
        parameters = {k: float(v) for k, v in self.parameters.items()}
        return {"name": self.name, "parameters": parameters, **more}


@dataclass(frozen=True)
class ModelFile:
    """Content of a model file."""

    base: str = "contact_patch"
    campaign: str = ""
    parameters: Mapping[str, float] = field(default_factory=dict)
    effects: tuple[Entry, ...] = ()
    history: tuple[Mapping[str, Any], ...] = ()
    path: str = field(default="", compare=False)
    """the file that it was read from; empty for a new model"""
    read: bytes | None = field(default=None, compare=False, repr=False)
    """content of that file when it was read; None when there was none"""

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
        """State for a step of the history: base parameters and effects with their files."""
        return {
            "parameters": {k: float(v) for k, v in self.parameters.items()},
            "effects": [e.to_dict() for e in self.effects],
        }

    def with_class(self, alike: Sequence[str]) -> ModelFile:
        """The model in which the last effect is one of a class, by the names of the others."""
        *others, last = self.effects
        return replace(self, effects=(*others, replace(last, alike=tuple(alike))))

    def with_step(self, action: str, effect: str, numbers: Mapping[str, Any]) -> ModelFile:
        """The model with one more line of history, which stores the present state."""
        step = {"step": len(self.history), "action": action, "effect": effect, **numbers}
        return replace(self, history=(*self.history, step | self.state()))

    def renamed(self, old: str, new: str, file: str) -> ModelFile:
        """The model with a user's effect renamed, in the history, too."""

        def renamed_line(line: Mapping[str, Any]) -> dict[str, Any]:
            out = dict(line)
            if line.get("effect") == old:
                out["effect"] = new
            if line.get("effects"):
                then = [_entry(e, "history") for e in line["effects"]]
                out |= replace(self, parameters={}, effects=entries(then)).state()
                out["parameters"] = line.get("parameters", {})
            return out

        def entries(known: Iterable[Entry]) -> tuple[Entry, ...]:
            return tuple(replace(e, name=new, file=file) if e.name == old else e for e in known)

        history = tuple(renamed_line(line) for line in self.history)
        return replace(self, effects=entries(self.effects), history=history)

    def undone(self) -> ModelFile:
        """The model before the last step, without that step's line of history."""
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
_ENTRY_KEYS = {"name", "parameters", "file", "or"}


def load_model(path: str | os.PathLike[str]) -> ModelFile:
    """Read a model file; FlatplankError when it does not exist or is wrong."""
    where = os.fspath(path)
    try:
        read = Path(path).read_bytes()
        raw = parse_yaml(read.decode("utf-8"))
    except FileNotFoundError as error:
        raise FlatplankError("no such model file", where, "`flatplank add` makes one") from error
    except OSError as error:
        what = f"cannot be read ({error.strerror})"
        raise FlatplankError(what, where, "name a model file (YAML)") from error
    except UnicodeDecodeError as error:
        raise FlatplankError("is no UTF-8 text", where, "name a model file (YAML)") from error
    except (yaml.YAMLError, ValueError) as error:
        raise FlatplankError(f"not YAML ({error})", where, "mend the file") from error
    if not isinstance(raw, Mapping) or raw.get("format") != FORMAT:
        raise FlatplankError(f"is not of format {FORMAT}", where, "write 'format: ...' first")
    unknown = sorted(set(raw) - _KEYS)
    if unknown:
        raise FlatplankError(f"unknown key '{unknown[0]}'", where, f"known: {sorted(_KEYS)}")
    raw = _with_paths(raw, partial(_found, folder=Path(path).parent))
    return ModelFile(
        base=str(raw.get("base") or ModelFile.base),
        campaign=str(raw.get("campaign") or ""),
        parameters=_numbers(raw.get("parameters"), where),
        effects=tuple(_entry(e, where) for e in _list(raw, "effects", where)),
        history=tuple(_line(h, where) for h in _list(raw, "history", where)),
        path=where,
        read=read,
    )


def _with_paths(raw: Mapping[str, Any], change: Callable[[str], str]) -> dict[str, Any]:
    """Content of a model file, or of a line of its history, with its paths changed."""
    out = dict(raw)
    if isinstance(out.get("campaign"), str):
        out["campaign"] = change(out["campaign"])
    if str(out.get("base")).endswith(TIR):
        out["base"] = change(str(out["base"]))
    if isinstance(out.get("effects"), list):
        out["effects"] = [
            {**e, "file": change(str(e["file"]))}
            if isinstance(e, Mapping) and e.get("file")
            else e
            for e in out["effects"]
        ]
    if isinstance(out.get("history"), list):
        lines = out["history"]
        out["history"] = [_with_paths(h, change) if isinstance(h, Mapping) else h for h in lines]
    return out


def _found(path: str, folder: Path) -> str:
    """A path of a model file as it is read: from the folder of the model file; from here where
    only that exists, as earlier versions wrote it."""
    if not path or "://" in path:
        return path
    there = folder / path
    return path if Path(path).exists() and not there.exists() else str(there)


def _beside(path: str, folder: Path) -> str:
    """A path as it stands in a model file: from its folder; elsewhere as it is, if it is gone."""
    if not path or "://" in path:
        return path
    inside = folder.absolute() in Path(path).absolute().parents
    return os.path.relpath(path, folder) if inside or Path(path).exists() else path


def _list(raw: Mapping[str, Any], key: str, where: str) -> list[Any]:
    found = raw.get(key)
    if found is not None and not isinstance(found, list):
        raise FlatplankError(f"'{key}' is {found!r:.60}, no list", where, "write '- ...' lines")
    return found or []


def _line(raw: Any, where: str) -> dict[str, Any]:
    if not isinstance(raw, Mapping):
        raise FlatplankError(
            f"'history' holds {raw!r:.60}", where, "leave its lines as `flatplank add` wrote them"
        )
    return dict(raw)


def _entry(raw: Any, where: str) -> Entry:
    if isinstance(raw, str):
        return Entry(raw)
    if not isinstance(raw, Mapping) or "name" not in raw:
        raise FlatplankError("effect without 'name'", where, "write '- name: road_play'")
    name = str(raw["name"])
    unknown = sorted(str(key) for key in set(raw) - _ENTRY_KEYS)
    if unknown:
        raise FlatplankError(
            f"effect {name}: unknown key '{unknown[0]}'", where, f"known: {sorted(_ENTRY_KEYS)}"
        )
    place = f"{where}, effect {name}"
    return Entry(
        name,
        _numbers(raw.get("parameters"), place),
        str(raw.get("file") or ""),
        tuple(map(str, _list(raw, "or", place))),
    )


def _numbers(raw: Any, where: str) -> dict[str, float]:
    try:
        found = {str(k): float(v) for k, v in (raw or {}).items()}
    except (AttributeError, TypeError, ValueError) as error:
        raise FlatplankError(f"parameters hold {raw!r}", where, "write 'name: number'") from error
    for name, value in found.items():
        if not math.isfinite(value):
            raise FlatplankError(f"parameter '{name}' is {value}", where, "write a finite number")
    return found


def save_model(model: ModelFile, path: str | os.PathLike[str]) -> None:
    """Write a model file atomically, replacing any existing one."""
    write_atomic(path, _text(model, path))


def save_unchanged(model: ModelFile, path: str | os.PathLike[str]) -> ModelFile:
    """Write a model file unless it changed since `model` was read; return the written model.

    FlatplankError when another program changed, created or removed the file; nothing is written.
    Of several writers at once one writes, and the others are told.
    """
    target = Path(path)
    with only_writer(target):
        if (target.read_bytes() if target.exists() else None) != model.read:
            raise FlatplankError(
                "was changed meanwhile, nothing is written", str(target), "repeat the step"
            )
        save_model(model, target)
    return replace(model, path=str(target), read=_text(model, target).encode("utf-8"))


def _text(model: ModelFile, path: str | os.PathLike[str]) -> str:
    data = _with_paths(model.to_dict(), partial(_beside, folder=Path(path).parent))
    return dump_yaml(data, allow_unicode=True)
