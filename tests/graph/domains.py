# SPDX-License-Identifier: Apache-2.0
"""A domain of its own for every graph of a test, whatever other tests run on this computer."""

from __future__ import annotations

import fcntl
import os
import tempfile
from collections import deque
from pathlib import Path
from typing import IO

from flatplank_control.bench.fast_dds import loopback_environment

FIRST, COUNT = 20, 80
"""up to 99: the ports of later ones are those that Linux gives to programs"""
AT_ONCE = 8
"""graphs that one process of tests may have; the domain of an earlier one is given back"""
_held: deque[IO[str]] = deque(maxlen=AT_ONCE)
_asked = 0


def next_domain() -> int:
    """One that no other process of tests has: its file stays locked while it is held."""
    global _asked
    for _ in range(COUNT):
        _asked += 1
        domain = FIRST + (os.getpid() * 7 + _asked) % COUNT
        file = (Path(tempfile.gettempdir()) / f"flatplank-tests-domain-{domain}").open("w")
        try:
            fcntl.flock(file, fcntl.LOCK_EX | fcntl.LOCK_NB)
        except BlockingIOError:
            file.close()
            continue
        if len(_held) == AT_ONCE:
            _held[0].close()
        _held.append(file)
        return domain
    raise RuntimeError(f"all of the domains {FIRST} to {FIRST + COUNT - 1} are taken by tests")


def loopback(domain: int | None = None) -> dict[str, str]:
    """Environment of a graph that nobody else hears; in the next domain where none is given."""
    domain = next_domain() if domain is None else domain
    return {"ROS_DOMAIN_ID": str(domain), **loopback_environment()}
