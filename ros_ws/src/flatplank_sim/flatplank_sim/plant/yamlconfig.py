# SPDX-License-Identifier: Apache-2.0
"""Plain data of the plant's configuration: read from YAML, merged, and sealed."""

from __future__ import annotations

import base64
import dataclasses
import json
import zlib
from collections.abc import Mapping
from pathlib import Path
from typing import Any

from flatplank_data.params import ParameterError
from flatplank_data.yaml_text import load_yaml


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
        raise ParameterError(f"{path}: cannot be read ({error.strerror})") from None
    if content is None:
        return {}
    if not isinstance(content, dict):
        raise ParameterError(f"{path}: expected keys with values")
    return content


def read_overlay(path: Path) -> dict[str, Any]:
    """Read overrides of the plant from a file, also from the sealed file of a challenge."""
    content = read_yaml(path)
    if "sealed" not in content:
        return content
    try:
        return decode_word(content["sealed"])
    except ValueError:
        raise ParameterError(f"{path}: sealed: is damaged; make the challenge again") from None


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
