# SPDX-License-Identifier: Apache-2.0
"""YAML that knows its lines, so that a refusal can name one."""

from __future__ import annotations

from typing import Any

import yaml


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


def load(text: str, where: str) -> Any:
    """Plain YAML with `Located` mappings; ValueError names the line."""
    try:
        return yaml.load(text, _Loader)
    except yaml.YAMLError as error:
        mark = getattr(error, "problem_mark", None)
        line = f":{mark.line + 1}" if mark else ""
        what = getattr(error, "problem", None) or "not YAML"
        raise ValueError(f"{where}{line}: {what}; correct the file") from None
