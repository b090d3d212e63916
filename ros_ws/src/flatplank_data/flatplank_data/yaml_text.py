# SPDX-License-Identifier: Apache-2.0
"""Reads and writes YAML; every YAML text of the project comes through this module.

Aliases (`*name`) are refused: a text of a few lines with nested aliases stands for billions of
values. Deep nesting is refused, too: the C loader crashes on it.
"""

from __future__ import annotations

from pathlib import Path
from typing import Any

import yaml

from flatplank_data.errors import FlatplankError, YamlError

_LOADER = getattr(yaml, "CSafeLoader", yaml.SafeLoader)
_DEPTH = 100
"""largest nesting; Python itself stops near 1000, and a plan has about 6"""


class _Dumper(getattr(yaml, "CSafeDumper", yaml.SafeDumper)):  # type: ignore[misc]
    def ignore_aliases(self, data: Any) -> bool:
        return True


def parse_yaml(text: str | bytes, loader: Any = _LOADER) -> Any:
    """Content of a YAML text. Raises yaml.YAMLError, or ValueError for an impossible value."""
    _check(text)
    return yaml.load(text, loader)


def load_yaml(text: str | bytes, where: str | Path) -> Any:
    """Content of a YAML text. Raises YamlError, which names the line where possible."""
    try:
        return parse_yaml(text)
    except (yaml.YAMLError, ValueError) as error:
        what, remedy = "not YAML", "correct the syntax"
        if isinstance(error, _Refused):
            what, remedy = str(error.problem), str(error.note)
        mark = getattr(error, "problem_mark", None)
        place = f"{where} line {mark.line + 1}" if mark else str(where)
        raise YamlError(what, place, remedy) from None


def load_format(text: str | bytes, where: str | Path, kind: str) -> dict[str, Any]:
    """The keys of a YAML file that begins with `format: kind`; FlatplankError for another one."""
    content = load_yaml(text, where)
    if not isinstance(content, dict) or content.get("format") != kind:
        raise FlatplankError(f"format is not {kind}", str(where), f"begin with format: {kind}")
    return {key: value for key, value in content.items() if key != "format"}


def dump_yaml(content: Any, **options: Any) -> str:
    """YAML text of plain data, keys in their order, without aliases."""
    return yaml.dump(content, **{"Dumper": _Dumper, "sort_keys": False, **options})


class _Refused(yaml.MarkedYAMLError):
    """Valid YAML that is not read."""


def _check(text: str | bytes) -> None:
    depth = 0
    for event in yaml.parse(text, _LOADER):
        depth += isinstance(event, yaml.CollectionStartEvent)
        depth -= isinstance(event, yaml.CollectionEndEvent)
        if isinstance(event, yaml.AliasEvent):
            what, remedy = f"the alias '*{event.anchor}' is not read", "write its values out"
        elif depth > _DEPTH:
            what, remedy = f"nested deeper than {_DEPTH} levels", "correct the brackets"
        else:
            continue
        raise _Refused(problem=what, note=remedy, problem_mark=event.start_mark)  # type: ignore[arg-type]
