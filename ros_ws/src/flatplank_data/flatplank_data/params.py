# SPDX-License-Identifier: Apache-2.0
"""Parameters and records of files as frozen dataclasses, read and checked in one way.

The type of a field may be a number, bool, text, tuple, mapping or another dataclass; `param` adds
unit, range, choices and note. The base class `Params` adds the check on construction. An optional
method `check(self) -> str | None` returns why values do not fit together.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping
from contextlib import suppress
from dataclasses import MISSING, Field, dataclass, field, fields, is_dataclass
from datetime import date
from functools import cache
from itertools import repeat
from pathlib import Path
from typing import (
    Any,
    ClassVar,
    NamedTuple,
    Protocol,
    TypeVar,
    get_args,
    get_origin,
    get_type_hints,
)

from flatplank_data.errors import FlatplankError
from flatplank_data.limits import Limit
from flatplank_data.names import nearest_hint
from flatplank_data.yaml_text import load_yaml

NO_KEY = {"no_key": True}
"""metadata of a field that no file has"""
SHELL_KEYS = frozenset({"use_sim_time", "autostart", "fifo_priority", "constants_from"})
"""Keys of a parameter file that belong to the ROS node, not to its core."""


class AnyDataclass(Protocol):
    """Bound of the types that are made from a mapping: any dataclass."""

    __dataclass_fields__: ClassVar[dict[str, Field[Any]]]


P = TypeVar("P", bound=AnyDataclass)
Bounds = tuple[float, float]


class ParameterError(FlatplankError):
    """A parameter that cannot be used; the text is one line: where, what, what to do."""


class ParamInfo(NamedTuple):
    """All that a node needs to declare one parameter."""

    name: str
    default: Any
    note: str
    unit: str
    bounds: Bounds | None
    placeholder: bool
    read_only: bool
    choices: tuple[str, ...]

    @property
    def description(self) -> str:
        """One line with unit, for the parameter descriptor."""
        text = f"{self.note} [{self.unit}]"
        if self.choices:
            text += f" one of {', '.join(self.choices)}"
        if self.placeholder:
            text += " (placeholder: not in the thesis, set it for the machine)"
        return text


def param(
    default: Any,
    note: str,
    *,
    unit: str = "-",
    bounds: Bounds | None = None,
    placeholder: bool = False,
    read_only: bool = False,
    choices: Iterable[str] = (),
) -> Any:
    """One field of a parameter set; `bounds` hold for every element of an array (a tuple).

    default: MISSING where a file must have the key.
    """
    metadata = {
        "note": note,
        "unit": unit,
        "bounds": bounds,
        "placeholder": placeholder,
        "read_only": read_only,
        "choices": tuple(choices),
    }
    return field(default=default, metadata=metadata)


@dataclass(frozen=True)
class Params:
    """Base of the parameter sets of the cores."""

    def __post_init__(self) -> None:
        validate(self, type(self).__name__)

    def check(self) -> str | None:
        """Reason why these values do not fit together, or None."""
        return None


def parameter_infos(cls: type) -> tuple[ParamInfo, ...]:
    """Every parameter of a set in order, for declaration and documentation."""
    return tuple(ParamInfo(name=f.name, default=f.default, **f.metadata) for f in fields(cls))


def from_mapping(cls: type[P], mapping: Any, where: str) -> P:
    """Checked values from plain ones; `where` names their file or node in errors."""
    if not isinstance(mapping, Mapping):
        raise ParameterError(f"{where}: expected keys with values, not {mapping!r}")
    known = {f.name: f for f in fields(cls) if f.init and "no_key" not in f.metadata}
    for key in mapping:
        if key not in known and key not in SHELL_KEYS:
            raise ParameterError(f"{where}: unknown parameter '{key}'{nearest_hint(key, known)}")
    missing = [f.name for f in known.values() if _is_required(f) and f.name not in mapping]
    if missing:
        raise ParameterError(f"{where}: missing {', '.join(missing)}")
    values = {k: _checked(cls, f, mapping[k], where) for k, f in known.items() if k in mapping}
    try:
        made = cls(**values)
    except ParameterError as error:
        text = str(error)
        prefix = f"{cls.__name__}: "
        raise ParameterError(text.replace(prefix, f"{where}: ", 1)) from None
    _check_together(made, where)
    return made


def _is_required(f: Field) -> bool:
    return f.default is MISSING and f.default_factory is MISSING


def to_mapping(values: Any) -> dict[str, Any]:
    """Plain values by name; arrays as lists, as YAML and ROS have them."""
    raw = ((f.name, getattr(values, f.name)) for f in fields(values))
    return {name: list(v) if isinstance(v, tuple) else v for name, v in raw}


def require_changes_only(old: P, new: P, allowed: Iterable[str], where: str) -> None:
    """Raise ParameterError when two sets differ in a parameter that is not in `allowed`."""
    known = set(allowed)
    for f in fields(old):
        if f.name not in known and getattr(old, f.name) != getattr(new, f.name):
            raise ParameterError(
                f"{where}: {f.name} is read when the node is configured: set it in the "
                f"parameter file; {', '.join(sorted(known))} can be changed now"
            )


def load_parameter_set(cls: type[P], path: str | Path, node: str = "") -> P:
    """A parameter set from a ROS parameter file."""
    return from_mapping(cls, load_parameters(path, node), str(path))


def load_parameters(path: str | Path, node: str = "") -> dict[str, Any]:
    """The `ros__parameters` of a file: those for every node (`/**`), overridden by those of
    `node`."""
    try:
        content = load_yaml(Path(path).read_bytes(), path) or {}
    except OSError as error:
        raise ParameterError(f"{path}: cannot be read ({error.strerror})") from None
    if not isinstance(content, dict):
        raise ParameterError(f"{path}: expected '/**:' with 'ros__parameters:' below it")
    merged: dict[str, Any] = {}
    for section in ("/**", node, f"/{node}"):
        block = content.get(section)
        if block is None:
            continue
        if not isinstance(block, dict) or not isinstance(block.get("ros__parameters"), dict):
            raise ParameterError(f"{path}: '{section}' has no 'ros__parameters:' below it")
        merged.update(block["ros__parameters"])
    return merged


def validate(values: Any, where: str) -> None:
    """Check types, finiteness, ranges, choices and `check` of a parameter set; integers become
    floats where the type is one."""
    for f in fields(values):
        value = _checked(type(values), f, getattr(values, f.name), where)
        object.__setattr__(values, f.name, value)
    _check_together(values, where)


def _check_together(values: Any, where: str) -> None:
    check = getattr(values, "check", None)
    if check and (reason := check()):
        raise ParameterError(f"{where}: {reason}")


@cache
def _kinds(cls: type) -> dict[str, Any]:
    return get_type_hints(cls)


def _checked(cls: type, f: Field, value: Any, where: str) -> Any:
    """The value of a field in its type; ParameterError outside its range or choices."""
    value = _read(_kinds(cls)[f.name], value, f"{where}: {f.name}")
    if reason := _refusal(f.name, value, f.metadata):
        raise ParameterError(f"{where}: {reason}")
    return value


def _read(kind: Any, value: Any, where: str) -> Any:
    if isinstance(kind, type) and is_dataclass(kind):
        return value if isinstance(value, kind) else from_mapping(kind, value, where)
    inner = get_args(kind)
    if get_origin(kind) is tuple:
        if isinstance(value, (str, bytes, Mapping)) or not hasattr(value, "__iter__"):
            raise ParameterError(f"{where} must be a list, not {value!r}")
        values = tuple(value)
        if inner[-1] is not ... and len(values) != len(inner):
            raise ParameterError(f"{where} must have {len(inner)} values, not {value!r}")
        kinds = repeat(inner[0]) if inner[-1] is ... else inner
        return tuple(_read(k, v, where) for k, v in zip(kinds, values))  # noqa: B905
    if get_origin(kind) is Mapping:
        if not isinstance(value, Mapping):
            raise ParameterError(f"{where}: expected names with values, not {value!r}")
        return {str(k): _read(inner[1], v, f"{where}: {k}") for k, v in value.items()}
    if kind not in _WORDS:
        return value
    truth = isinstance(value, bool)
    if kind is float and isinstance(value, (int, float, str)) and not truth:
        with suppress(ValueError):  # YAML reads 5e-4 as text
            value = float(value)
    if kind is str and isinstance(value, (int, float, date)) and not truth:
        value = str(value)  # a name of digits
    if not isinstance(value, kind) or (truth and kind is not bool):
        raise ParameterError(f"{where} must be {_WORDS[kind]}, not {value!r}")
    return value


_WORDS = {bool: "true or false", int: "a whole number", float: "a number", str: "text"}


def _refusal(name: str, value: Any, metadata: Mapping[str, Any]) -> str:
    if isinstance(value, tuple):
        return next((r for v in value if (r := _refusal(name, v, metadata))), "")
    choices = metadata.get("choices", ())
    if choices and isinstance(value, (str, Mapping)):
        for word in (value,) if isinstance(value, str) else value:
            if word not in choices:
                return f"{name} is '{word}'{nearest_hint(word, choices)}"
    if isinstance(value, (int, float)) and not isinstance(value, bool):
        low, high = metadata.get("bounds") or (-math.inf, math.inf)
        unit = metadata.get("unit", "").replace("-", "")
        return Limit(low, high, unit).refusal(name, value)
    return ""
