# SPDX-License-Identifier: Apache-2.0
"""Naps, and answers every line of its input with how late it was woken up at the worst [s]."""

from __future__ import annotations

import select
import sys
import time

NAP_S = 0.002


def main() -> None:
    poll = select.poll()
    poll.register(sys.stdin, select.POLLIN)
    longest = 0.0
    due = time.monotonic() + NAP_S
    while True:
        asked = poll.poll(1e3 * max(due - time.monotonic(), 0.0))
        now = time.monotonic()
        longest = max(longest, now - due)
        due = now + NAP_S
        if asked:
            if not sys.stdin.readline():
                return
            print(longest, flush=True)
            longest = 0.0


if __name__ == "__main__":
    main()
