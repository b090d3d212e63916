# SPDX-License-Identifier: Apache-2.0
"""Encoder counters of any width, continued to 32 bits."""

from __future__ import annotations


class Counter:
    """Follows a counter that wraps at its own width; 32 bits pass through as int32."""

    def __init__(self, bits: int) -> None:
        self._bits = bits
        self._value: int | None = None

    def see(self, raw: int) -> int:
        """Next raw value; a step of less than half the range is taken as the way it went."""
        if self._bits >= 32:
            return (raw + 2**31) % 2**32 - 2**31
        if self._value is None:
            self._value = raw
        half = 1 << (self._bits - 1)
        step = (raw - self._value + half) % (2 * half) - half
        self._value += step
        return (self._value + 2**31) % 2**32 - 2**31
