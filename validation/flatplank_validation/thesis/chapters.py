# SPDX-License-Identifier: Apache-2.0
"""The chapters with results, in the order of the thesis."""

from __future__ import annotations

from flatplank_validation.thesis import (
    appendices,
    appendix_c,
    chapter4,
    chapter5,
    chapter6,
    chapter7,
)
from flatplank_validation.thesis.registry import Chapter

CHAPTERS: dict[str, Chapter] = {
    chapter.key: chapter
    for chapter in (
        chapter4.CHAPTER, chapter5.CHAPTER, chapter6.CHAPTER, chapter7.CHAPTER,
        appendices.A, appendices.B, appendix_c.CHAPTER, appendices.E, appendices.G,
        appendices.H, appendices.I,
    )
}  # fmt: skip
"""key of --chapter -> chapter"""
