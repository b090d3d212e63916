# SPDX-License-Identifier: Apache-2.0
"""What can keep a bus from starting: always one line that says what, where and what to do."""

from __future__ import annotations


class BusError(ValueError):
    """The bus cannot be used."""
