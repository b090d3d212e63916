# SPDX-License-Identifier: Apache-2.0
"""Who is in charge: a client that has claimed operation must be heard of, or the axis stops."""

from __future__ import annotations


class Charge:
    """The claim of one client. Times are bench times [ns]; a beat counts from the cycle that sees
    it."""

    __slots__ = ("_beat_at", "_heard", "client")

    def __init__(self) -> None:
        self.client = ""
        self._beat_at = 0
        self._heard = False

    def claim(self, client: str) -> None:
        """Take charge; the claim is the first beat, its renewal by the same client is none."""
        self._heard |= client != self.client
        self.client = client

    def release(self) -> None:
        """Give it back; nobody is in charge."""
        self.client = ""

    def beat(self) -> None:
        """The client was heard of."""
        self._heard = True

    def age(self, now: int) -> int:
        """Time since the last beat [ns]."""
        if self._heard:
            self._heard, self._beat_at = False, now
        return now - self._beat_at
