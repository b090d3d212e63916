# SPDX-License-Identifier: Apache-2.0
"""The sentence of a page of results that says which search its numbers are of."""

from __future__ import annotations

from collections.abc import Iterable


def of_which_search(commits: Iterable[str]) -> str:
    """`commits`: of the entries."""
    known = sorted({commit.rstrip("+") for commit in commits})
    made = f"The numbers are of the search as it was at commit {', '.join(known)}."
    return (
        f"{made} What changed since is not in them: "
        f"`git log {known[0]}.. -- ros_ws/src/flatplank_analysis`."
    )
