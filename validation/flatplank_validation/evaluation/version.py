# SPDX-License-Identifier: Apache-2.0
"""The sentence of a page of results that says which search its numbers are of."""

from __future__ import annotations

from collections.abc import Iterable

from flatplank_analysis.contact_patch.session import STEPS


def of_which_search(commits: Iterable[str], search: str = STEPS) -> str:
    """`commits`: of the entries; `search`: name in `diagnose --search`."""
    known = sorted({commit.rstrip("+") for commit in commits})
    return (
        f"The numbers are of the search by {search} (`diagnose --search {search}`) as it was at "
        f"commit {', '.join(known)}. What changed since is not in them: "
        f"`git log {known[0]}.. -- ros_ws/src/flatplank_analysis`."
    )
