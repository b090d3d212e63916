# SPDX-License-Identifier: Apache-2.0
"""Damaged device descriptions of makers."""

from __future__ import annotations

import random
import tempfile
from pathlib import Path

from flatplank_validation.trust.esi_damage import damaged, failure
from flatplank_validation.trust.registry import Options, Tally, row

NIGHT = 20_000
"""damaged files of a night"""


@row(
    "esi", "damaged ESI files of a drive",
    "not refused in one line, or read otherwise than by another reader",
)  # fmt: skip
def damaged_esi(o: Options) -> Tally:
    """Drawn by the seed."""
    out, count = Tally(), o.count(NIGHT)
    with tempfile.TemporaryDirectory(prefix="fp-esi-") as folder:
        for k in range(count):
            out.add(failure(damaged(random.Random(f"{o.seed} {k}")), Path(folder) / "drive.xml"))
            if k % 100 == 99 or k == count - 1:
                o.progress(k + 1, count)
    return out
