# SPDX-License-Identifier: Apache-2.0
"""Reads frozen dataclasses from YAML; errors state where, and name the nearest known key."""

from __future__ import annotations

import base64
import dataclasses
import json
import math
import typing
import zlib
from collections.abc import Mapping
from pathlib import Path
from typing import Any, TypeVar

from flatplank_data.errors import FlatplankError
from flatplank_data.names import nearest_hint
from flatplank_data.params import AnyDataclass
from flatplank_data.yaml_text import load_yaml

T = TypeVar("T", bound=AnyDataclass)


class PlantConfigError(FlatplankError):
    """A configuration that cannot be used; one line states where, what, what to do."""


def encode_as_word(content: Mapping[str, Any]) -> str:
    """Encode a mapping as one word that is not read by accident; this is no encryption."""
    return base64.b64encode(zlib.compress(json.dumps(content, sort_keys=True).encode())).decode()


def decode_word(text: str) -> dict[str, Any]:
    """Decode the mapping; ValueError when the word is damaged."""
    try:
        return dict(json.loads(zlib.decompress(base64.b64decode(text))))
    except (TypeError, zlib.error) as error:
        raise ValueError(str(error)) from None


def read_yaml(path: Path) -> dict[str, Any]:
    """Read a mapping from a YAML file."""
    try:
        content = load_yaml(path.read_bytes(), path)
    except OSError as error:
        raise PlantConfigError(f"{path}: cannot be read ({error.strerror})") from None
    if content is None:
        return {}
    if not isinstance(content, dict):
        raise PlantConfigError(f"{path}: expected keys with values")
    return content


def read_overlay(path: Path) -> dict[str, Any]:
    """Read overrides of the plant from a file, also from the sealed file of a challenge."""
    content = read_yaml(path)
    if "sealed" not in content:
        return content
    try:
        return decode_word(content["sealed"])
    except ValueError:
        raise PlantConfigError(f"{path}: sealed: is damaged; make the challenge again") from None


def merge(base: Mapping[str, Any], over: Mapping[str, Any]) -> dict[str, Any]:
    """Return `base` with the values of `over`, merged level by level."""
    result = dict(base)
    for key, value in over.items():
        old = result.get(key)
        if isinstance(old, Mapping) and isinstance(value, Mapping):
            result[key] = merge(old, value)
        else:
            result[key] = value
    return result


def nested(mapping: Mapping[str, Any]) -> dict[str, Any]:
    """Convert {'a.b': 1} to {'a': {'b': 1}}."""
    result: dict[str, Any] = {}
    for key, value in mapping.items():
        inner = nested(value) if isinstance(value, Mapping) else value
        for part in reversed(str(key).split(".")[1:]):
            inner = {part: inner}
        result = merge(result, {str(key).split(".")[0]: inner})
    return result


def build_dataclass(cls: type[T], data: Any, where: str) -> T:
    """Make a dataclass from plain data; supports nested dataclasses, floats, tuples of floats."""
    if not isinstance(data, Mapping):
        raise PlantConfigError(f"{where}: expected keys with values, found {data!r}")
    hints = typing.get_type_hints(cls)
    known = {f.name: f for f in dataclasses.fields(cls) if f.init}
    for key in data:
        if key not in known:
            raise PlantConfigError(f"{where}: unknown key '{key}'{nearest_hint(key, known)}")
    values = {k: checked_value(hints[k], v, f"{where}: {k}") for k, v in data.items()}
    for name, f in known.items():
        required = f.default is dataclasses.MISSING and f.default_factory is dataclasses.MISSING
        if required and name not in values:
            raise PlantConfigError(f"{where}: '{name}' is missing")
    return cls(**values)


def checked_value(hint: Any, value: Any, where: str) -> Any:
    """Check one value against the type of its field and convert it."""
    if isinstance(hint, type) and dataclasses.is_dataclass(hint):
        return build_dataclass(hint, value, where)
    if typing.get_origin(hint) is tuple:
        if not isinstance(value, list | tuple):
            raise PlantConfigError(f"{where}: expected a list, found {value!r}")
        return tuple(checked_value(typing.get_args(hint)[0], v, where) for v in value)
    if hint is float:
        # YAML reads 1e5 as text
        if isinstance(value, str):
            try:
                value = float(value)
            except ValueError:
                raise PlantConfigError(f"{where}: expected a number, found {value!r}") from None
        if isinstance(value, bool) or not isinstance(value, int | float) or math.isnan(value):
            raise PlantConfigError(f"{where}: expected a number, found {value!r}")
        return float(value)
    if hint in (int, bool, str):
        if type(value) is not hint:
            raise PlantConfigError(f"{where}: expected {hint.__name__}, found {value!r}")
        return value
    return value


def to_plain(value: Any) -> Any:
    """Convert a dataclass to plain data for YAML."""
    if dataclasses.is_dataclass(value) and not isinstance(value, type):
        return {
            f.name: to_plain(getattr(value, f.name)) for f in dataclasses.fields(value) if f.init
        }
    if isinstance(value, Mapping):
        return {k: to_plain(v) for k, v in value.items()}
    if isinstance(value, list | tuple):
        return [to_plain(v) for v in value]
    return value
