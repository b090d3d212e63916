# SPDX-License-Identifier: Apache-2.0
"""Chapter 4: the software; its one result is the parasitic filter."""

from __future__ import annotations

from functools import partial

from flatplank_validation.thesis import appendix_c
from flatplank_validation.thesis.appendix_c import ABOUT, LEFT, amplitude
from flatplank_validation.thesis.registry import AtMost, Chapter, Entry, Row

SCREEN = "a picture of the software, no result; ours is the page of the panel"
PLACE = "section 4.1"

CHAPTER = Chapter(
    "4",
    "Chapter 4: software",
    (
        Entry("4.1", "Effect of the parasitic filter", appendix_c.before_and_after, (
            Row("amplitude without the filter", "N", 300.0, PLACE,
                partial(amplitude, "fx", False), ABOUT, "the plant's preload is 250 N"),
            Row("amplitude with the filter", "N", 15.0, PLACE, partial(amplitude, "fx", True),
                AtMost("reduced ‘from 300 N to 15 N’"), LEFT),
        )),
        Entry("4.2", "Picture of the interface", absent=SCREEN),
        Entry("4.3", "Picture of the wheel rotation actuator's tab", absent=SCREEN),
        Entry("4.4", "Layout of the control model",
              absent="a block diagram; ours is in ARCHITECTURE.md"),
    ),
)  # fmt: skip
