# SPDX-License-Identifier: Apache-2.0
"""Table that compares the search with the rival methods."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from functools import partial
from statistics import mean
from typing import Any

from flatplank_sim.sealed.score import LAW, UNEXPLAINED_VERDICTS
from flatplank_validation.blind.markdown import table
from flatplank_validation.blind.points import points_of, share

GROUPS = {"none": "nothing hidden", "single": "one effect", "pair": "two effects"}


def rival_scores(entries: Sequence[Mapping[str, Any]]) -> str:
    """One row per group, one column per method; strict scores."""
    ways = list(entries[0]["ways"])
    points = {w: [points_of(dict(e, diagnosis=e["ways"][w])) for e in entries] for w in ways}
    hidden = {w: [p for p in points[w] if p["group"] in ("single", "pair")] for w in ways}

    def of(way: str, group: str) -> list[dict[str, Any]]:
        return [p for p in points[way] if p["group"] == group]

    def row(text: str, value: Callable[[str], Any]) -> list[str]:
        return [text, *(str(value(w)) for w in ways)]

    def right(group: str, way: str) -> Any:
        return share(p["right"] for p in of(way, group))

    rows = [row(f"{text}: right", partial(right, g)) for g, text in GROUPS.items()]
    rows += [
        row(
            "outside the library: `none of these` or `partly`",
            lambda w: share(p["verdict"] in UNEXPLAINED_VERDICTS for p in of(w, "outside")),
        ),
        row("hidden effects all named", lambda w: share(p["all"] for p in hidden[w])),
        row("false terms per campaign", lambda w: f"{mean(p['false'] for p in points[w]):.2f}"),
        row(
            "90 % intervals that cover",
            lambda w: share(m["covered"] for p in hidden[w] for m in p["sizes"]),
        ),
    ]
    return f"{len(entries)} {_TOLD}\n\n{table(['', *ways], rows)}"


_TOLD = f"""campaigns of the kit, the same base, the same candidates, scored by the same strict
rule: a rival, too, names a group (columns that correlate above 0.95 once the tire has taken its
part) and says whether its error is at the scatter of the repeats. Its BIC counts the independent
samples that the correlation of what is left leaves. The place of what is outside the library is
not asked of anybody here. A force law of another form (`{LAW}`) is not counted as false for
anybody."""
