# SPDX-License-Identifier: Apache-2.0
"""Reads the YAML of a plan and collects its faults: file, line, what, what to do."""

from __future__ import annotations

from collections.abc import Collection, Mapping, Sequence
from typing import Any

import yaml

from flatplank_data.names import nearest_hint
from flatplank_data.values import is_number
from flatplank_data.yaml_text import parse_yaml


class Located(dict):
    """A mapping with the line of each key, counted from 1."""

    def __init__(self) -> None:
        super().__init__()
        self.line = 0
        self.lines: dict[str, int] = {}

    def line_of(self, key: str) -> int:
        """Line of a key, else of the mapping itself."""
        return self.lines.get(key, self.line)


class _Loader(yaml.SafeLoader):
    def _located(self, node: yaml.MappingNode):
        found = Located()
        found.line = node.start_mark.line + 1
        yield found
        self.flatten_mapping(node)
        for key_node, value_node in node.value:
            key = str(self.construct_object(key_node, deep=True))
            if key in found.lines:
                raise yaml.constructor.ConstructorError(
                    None, None, f"'{key}' is given twice", key_node.start_mark
                )
            found[key] = self.construct_object(value_node, deep=True)
            found.lines[key] = key_node.start_mark.line + 1


_Loader.add_constructor(yaml.resolver.BaseResolver.DEFAULT_MAPPING_TAG, _Loader._located)


def load_with_lines(text: str, where: str) -> Any:
    """Plain YAML with `Located` mappings; ValueError names the line."""
    try:
        return parse_yaml(text, _Loader)
    except yaml.YAMLError as error:
        mark = getattr(error, "problem_mark", None)
        line = f":{mark.line + 1}" if mark else ""
        what = getattr(error, "problem", None) or "not YAML"
        raise ValueError(f"{where}{line}: {what}; correct the file") from None


Span = tuple[float, float]
Hints = Mapping[str, str]
_NONE: Hints = {}


class PlanReader:
    """Reader of the values of a plan; it collects `problems` instead of stopping at the first.

    Each method returns the value in the plan, or the default when the value is refused.
    """

    def __init__(self, where: str) -> None:
        self.where = where
        self.problems: list[str] = []

    def add_problem(self, line: int, text: str) -> None:
        """Add a problem; the same text is added once."""
        problem = f"{self.where}:{line}: {text}"
        if problem not in self.problems:
            self.problems.append(problem)

    def check_keys(
        self, data: Located, known: Collection[str], prefix: str = "", not_here: Hints = _NONE
    ) -> None:
        """Check the keys; `not_here`: key that belongs elsewhere -> remedy."""
        for key in data:
            if key in not_here:
                self.add_problem(
                    data.line_of(key), f"{prefix}{key} does not belong here; {not_here[key]}"
                )
            elif key not in known:
                self.add_problem(
                    data.line_of(key), f"{prefix}unknown key '{key}'{nearest_hint(key, known)}"
                )

    def section(
        self, data: Located, key: str, known: Collection[str], not_here: Hints = _NONE
    ) -> Located:
        """A mapping with known keys; empty when the plan lacks it."""
        value = data.get(key)
        if isinstance(value, Located):
            self.check_keys(value, known, f"{key}: ", not_here)
            return value
        if value is not None:
            self._refuse(data, key, "keys and values, as in {key: value}")
        return Located()

    def choice(self, data: Located, key: str, allowed: Sequence[str]) -> str:
        """One of `allowed`; the first is the default."""
        value = data.get(key, allowed[0])
        if value in allowed:
            return str(value)
        self.add_problem(
            data.line_of(key), f"{key} is '{value}'{nearest_hint(str(value), allowed)}"
        )
        return allowed[0]

    def integer(self, data: Located, key: str, default: int, least: int) -> int:
        value = data.get(key, default)
        if isinstance(value, int) and not isinstance(value, bool) and value >= least:
            return value
        self._refuse(data, key, f"a whole number, {least} or more")
        return default

    def number(self, data: Located, key: str, default: float, span: Span) -> float:
        """A number within `span`."""
        value = data.get(key, default)
        if is_number(value) and span[0] <= value <= span[1]:
            return float(value)
        self._refuse(data, key, f"a number of {span[0]:g} .. {span[1]:g}")
        return default

    def positive(self, data: Located, key: str) -> float:
        value = data[key]
        if is_number(value) and value > 0:
            return float(value)
        self._refuse(data, key, "a number above 0")
        return 1.0

    def text(self, data: Located, key: str, default: str = "") -> str:
        """A text; a number is read as its digits."""
        value = data.get(key, default)
        if isinstance(value, str) or is_number(value):
            return str(value)
        self._refuse(data, key, "text")
        return default

    def spans(self, data: Located, key: str) -> tuple[Span, ...]:
        """A list of pairs of numbers."""
        value = data.get(key, [])
        if isinstance(value, list) and all(_is_pair(v) for v in value):
            return tuple((float(low), float(high)) for low, high in value)
        self._refuse(data, key, "pairs of numbers, as in [[100, 130], [350, 10]]")
        return ()

    def _refuse(self, data: Located, key: str, wanted: str) -> None:
        self.add_problem(data.line_of(key), f"{key} is {plain(data[key])!r}; give {wanted}")


def _is_pair(value: Any) -> bool:
    return isinstance(value, list) and len(value) == 2 and all(map(is_number, value))


def plain(value: Any) -> Any:
    """Plain values, without line numbers."""
    return dict(value) if isinstance(value, Located) else value
