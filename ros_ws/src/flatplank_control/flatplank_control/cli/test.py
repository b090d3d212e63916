# SPDX-License-Identifier: Apache-2.0
"""Run the project's tests: [--long] [-k EXPR] [FILE ...]; further options go to pytest."""

from __future__ import annotations

import os
import sys

from flatplank_control.cli.root import project_root


def main(argv: list[str]) -> int:
    """Become pytest, in the checkout: its closing line is the last, its exit code ours."""
    os.chdir(project_root())
    sys.stdout.flush()
    os.execv(sys.executable, [sys.executable, "-m", "pytest", *argv])
