# SPDX-License-Identifier: Apache-2.0
"""A bag of 2 GB of another bench: its rows are those that were written."""

from __future__ import annotations

from flatplank_validation.fits.large_bag import measure
from flatplank_validation.trust.registry import Options, Tally, row

NIGHT_GB = 2.0
"""size of the bag [GB]"""


@row(
    "large", f"the import of a bag of {NIGHT_GB:g} GB",
    "an error, or other rows than were written",
)  # fmt: skip
def large(o: Options) -> Tally:
    """One case; its share is that of the size."""
    out = Tally()
    try:
        found = measure(NIGHT_GB * o.share)
    except (AssertionError, OSError, ValueError) as error:
        out.add(f"{type(error).__name__}: {error}")
    else:
        size = f"{found['size_gb']:.3g} GB, {found['rows']:.0f} rows"
        spent = f"{found['time_s']:.1f} s, {found['memory_mb']:.0f} MB"
        out.notes.append(f"{size}, {spent}")
        out.add("")
    o.progress(out.many, 1)
    return out
