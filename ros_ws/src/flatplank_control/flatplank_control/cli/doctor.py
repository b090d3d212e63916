# SPDX-License-Identifier: Apache-2.0
"""Say what is there and what is not."""


def main(argv: list[str]) -> int:
    """Stub."""
    return 0
