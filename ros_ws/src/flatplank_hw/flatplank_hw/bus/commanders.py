# SPDX-License-Identifier: Apache-2.0
"""Which commands the owner of the bus takes: an axis has one commander."""

from __future__ import annotations

from collections import Counter

QUIET_NS = 1_000_000_000
"""bench time without a second command after which an axis is not contested any more [ns]"""


class CommandGate:
    """Takes one command of an axis per message of the bus; a stamp [ns] identifies the message.

    A command from another process is refused where a node of this process commands the axis. If
    all commands come from other processes, nobody can tell which of two nodes is the right one:
    then the axis is contested, and the owner of the bus passes on no command of either. A node
    answers in order, so a second answer to a message, however late, is that of another node.
    """

    def __init__(self) -> None:
        self.sent_ns = 0
        """stamp of the latest inputs [ns]"""
        self._first_ns = 0
        """stamp of the first inputs of this clock [ns]"""
        self._answered: dict[int, int] = {}
        self._inside: set[int] = set()
        self._contested_until: dict[int, int] = {}
        self._refused: Counter[int] = Counter()

    def send(self, stamp_ns: int) -> None:
        """Register the inputs that are about to be published."""
        if stamp_ns < self.sent_ns:  # another clock, which no command has answered
            self._first_ns = 0
            self._answered.clear()
            self._contested_until.clear()
        self._first_ns = self._first_ns or stamp_ns
        self.sent_ns = stamp_ns

    def accept(self, axis: int, stamp_ns: int, *, inside: bool = False) -> bool:
        """True for the first answer of the axis to published inputs. `inside`: it comes from a
        node of this process."""
        if inside:
            self._inside.add(axis)
        last = self._answered.get(axis, -1)
        if inside == (axis in self._inside) and last < stamp_ns <= self.sent_ns:
            self._answered[axis] = stamp_ns
            return True
        self._refused[axis] += 1
        answers = stamp_ns > 0 and self._first_ns <= stamp_ns <= last
        if axis not in self._inside and answers:
            self._contested_until[axis] = self.sent_ns + QUIET_NS
        return False

    def contested(self, axis: int) -> bool:
        """True while two nodes of other processes command the axis."""
        return self.sent_ns <= self._contested_until.get(axis, -1)

    def take_refused(self) -> dict[int, int]:
        """Axis -> number of commands refused since the last call."""
        refused, self._refused = dict(self._refused), Counter()
        return refused
