# SPDX-License-Identifier: Apache-2.0
"""What a verdict may say at most on the floor that it stands on."""

from __future__ import annotations

from flatplank_analysis.discovery.sources.base import FOUND, PARTLY, Source

CLAIMS = (FOUND, "found group", "tire law only")
"""verdicts that say that everything is explained"""


def capped(source: Source, verdict: str, reason: str) -> tuple[str, str]:
    """Verdict and reason as the floor allows them; the reason names a floor that is no repeats."""
    if source.at_most == FOUND:
        return verdict, reason
    told = f"{reason}; the floor is by {source.words()}"
    if verdict not in CLAIMS:
        return verdict, told
    return PARTLY, f"{told}, which allows no more than '{PARTLY}': repeat the conditions"
