# SPDX-License-Identifier: Apache-2.0
"""Command-line parser of the verbs, which reports an error in one line."""

from __future__ import annotations

import argparse
from typing import NoReturn


class Parser(argparse.ArgumentParser):
    """Parser that prints an error as one line on stderr, without the usage; exit code 2."""

    def error(self, message: str) -> NoReturn:
        """Print the error and how to list the options; raise SystemExit with code 2."""
        line = " ".join(message.split())
        self.exit(2, f"{self.prog}: {line}; `{self.prog} --help` lists the options\n")
