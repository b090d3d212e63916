# SPDX-License-Identifier: Apache-2.0
"""Decides which page is in charge: one at a time, the others watch. Time is an argument [s]."""

from __future__ import annotations

from flatplank_data.errors import FlatplankError

HOLDER_TIMEOUT_S = 10.0
"""time without a heartbeat after which a page loses control [s]; the drive stops the wheel
earlier, after its own heartbeat time-out"""


class NotInCharge(FlatplankError):
    """The page is not in charge and may only watch."""


class PageInCharge:
    """The page in charge, by the identity of its connection."""

    def __init__(self) -> None:
        self.holder = ""
        self.name = ""
        """name shown to the other pages"""
        self._heard = 0.0

    def take_charge(self, page: str, name: str, now: float) -> None:
        """Take charge; NotInCharge while another page is in charge."""
        self.release_if_silent(now)
        if self.holder not in ("", page):
            raise NotInCharge(f"{self.name or 'another page'} is in charge; ask for a hand-over")
        self.holder, self.name, self._heard = page, name, now

    def release_page(self, page: str) -> None:
        if self.holder == page:
            self.holder = self.name = ""

    def register_heartbeat(self, page: str, now: float) -> bool:
        """Register a heartbeat; true when the page is in charge."""
        if page != self.holder or not page:
            return False
        self._heard = now
        return True

    def release_if_silent(self, now: float) -> bool:
        """Release a silent page; true when the page in charge has just been released."""
        if self.holder and now - self._heard > HOLDER_TIMEOUT_S:
            self.holder = self.name = ""
            return True
        return False

    def require_charge(self, page: str) -> None:
        """Raise NotInCharge unless the page is in charge."""
        if not page or page != self.holder:
            who = f"{self.name} is in charge" if self.holder else "take charge first"
            raise NotInCharge(f"this page only watches: {who}")
