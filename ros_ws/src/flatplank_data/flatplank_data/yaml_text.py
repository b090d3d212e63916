# SPDX-License-Identifier: Apache-2.0
"""Reads YAML written by hand; an error is one line."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import yaml

from flatplank_data.errors import YamlError

_LOADER = getattr(yaml, "CSafeLoader", yaml.SafeLoader)


def load_yaml(text: str | bytes, where: str | Path) -> Any:
    """Content of a YAML text. Raises YamlError, which names the line where possible."""
    try:
        return yaml.load(text, _LOADER)
    except (yaml.YAMLError, ValueError) as error:
        mark = getattr(error, "problem_mark", None)
        place = f"{where} line {mark.line + 1}" if mark else str(where)
        raise YamlError("not YAML", place, "correct the syntax") from None
