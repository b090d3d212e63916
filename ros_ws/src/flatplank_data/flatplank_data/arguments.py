# SPDX-License-Identifier: Apache-2.0
"""The command line of a verb; what is wrong with it is told in one line."""

from __future__ import annotations

import argparse
from typing import NoReturn


class Parser(argparse.ArgumentParser):
    """A parser whose errors are one line on stderr and exit code 2, without the usage."""

    def error(self, message: str) -> NoReturn:
        """Say what is wrong and where the options stand; SystemExit with code 2."""
        line = " ".join(message.split())
        self.exit(2, f"{self.prog}: {line}; `{self.prog} --help` lists the options\n")
