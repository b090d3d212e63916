# SPDX-License-Identifier: Apache-2.0
"""Errors in words."""

from __future__ import annotations


def one_line(error: Exception) -> str:
    """The error on one line; for an OSError its file and reason, without its number."""
    if isinstance(error, OSError) and error.strerror:
        return f"{error.filename}: {error.strerror}" if error.filename else error.strerror
    return " ".join(str(error).split())
