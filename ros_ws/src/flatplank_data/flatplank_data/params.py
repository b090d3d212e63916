# SPDX-License-Identifier: Apache-2.0
"""Parameters as frozen dataclasses: each field has unit, range and note; all sources are checked.

A parameter set is any frozen dataclass whose fields are made by `param`. The base class `Params`
adds the check on construction. An optional method `check(self) -> str | None` returns why values
do not fit together.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping
from dataclasses import Field, dataclass, field, fields
from pathlib import Path
from typing import Any, ClassVar, NamedTuple, Protocol, TypeVar

from flatplank_data.errors import FlatplankError
from flatplank_data.limits import Limit
from flatplank_data.names import nearest_hint
from flatplank_data.yaml_text import load_yaml

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
    """One field of a parameter set; `bounds` hold for every element of an array (a tuple)."""
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


def from_mapping(cls: type[P], mapping: Mapping[str, Any], where: str) -> P:
    """Checked parameters from a plain mapping; `where` names its file or node in errors."""
    known = {info.name for info in parameter_infos(cls)}
    for key in mapping:
        if key not in known and key not in SHELL_KEYS:
            raise ParameterError(f"{where}: unknown parameter '{key}'{nearest_hint(key, known)}")
    try:
        values = cls(**{key: value for key, value in mapping.items() if key in known})
        validate(values, where)
    except ParameterError as error:
        text = str(error)
        prefix = f"{cls.__name__}: "
        raise ParameterError(text.replace(prefix, f"{where}: ", 1)) from None
    return values


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
    floats where the default is one."""
    for f in fields(values):
        value = _coerced(getattr(values, f.name), f.default, f"{where}: {f.name}")
        reason = _refusal(f.name, value, f.metadata)
        if reason:
            raise ParameterError(f"{where}: {reason}")
        object.__setattr__(values, f.name, value)
    check = getattr(values, "check", None)
    if check and (reason := check()):
        raise ParameterError(f"{where}: {reason}")


def _coerced(value: Any, default: Any, where: str) -> Any:
    if isinstance(default, tuple):
        if isinstance(value, (str, bytes)) or not hasattr(value, "__iter__"):
            raise ParameterError(f"{where} must be a list, not {value!r}")
        kind = default[0] if default else 0.0
        return tuple(_coerced(v, kind, where) for v in value)
    if isinstance(default, bool):
        if not isinstance(value, bool):
            raise ParameterError(f"{where} must be true or false, not {value!r}")
    elif isinstance(default, int):
        if isinstance(value, bool) or not isinstance(value, int):
            raise ParameterError(f"{where} must be a whole number, not {value!r}")
    elif isinstance(default, float):
        if isinstance(value, bool) or not isinstance(value, (int, float)):
            raise ParameterError(f"{where} must be a number (as in 5.0e-4), not {value!r}")
        return float(value)
    elif not isinstance(value, str):
        raise ParameterError(f"{where} must be text, not {value!r}")
    return value


def _refusal(name: str, value: Any, metadata: Mapping[str, Any]) -> str:
    if isinstance(value, tuple):
        return next((r for v in value if (r := _refusal(name, v, metadata))), "")
    if isinstance(value, str):
        choices = metadata.get("choices", ())
        known = not choices or value in choices
        return "" if known else f"{name} is '{value}'{nearest_hint(value, choices)}"
    if isinstance(value, bool):
        return ""
    low, high = metadata.get("bounds") or (-math.inf, math.inf)
    return Limit(low, high, metadata.get("unit", "").replace("-", "")).refusal(name, value)
