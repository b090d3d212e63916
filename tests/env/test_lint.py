# SPDX-License-Identifier: Apache-2.0
"""Style, types and layers, as the developer's tools see them."""

from __future__ import annotations

import subprocess
import sys
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parents[2]
BIN = Path(sys.executable).parent

TOOLS = {
    "check": ["ruff", "check", "--output-format", "concise"],
    "format": ["ruff", "format", "--check"],
    "types": ["mypy"],
    "contracts": ["lint-imports", "--no-logo"],
}


@pytest.mark.parametrize("tool", TOOLS)
def test_tool_is_content(tool: str) -> None:
    name, *options = TOOLS[tool]
    done = subprocess.run([BIN / name, *options], cwd=ROOT, capture_output=True, text=True)
    assert done.returncode == 0, f"{name}:\n{done.stdout[-6000:]}{done.stderr[-2000:]}"
