# SPDX-License-Identifier: Apache-2.0
"""Tracebacks of unforeseen errors, in a file: the user sees one line that names the file."""

from __future__ import annotations

import os
import tempfile
import traceback


def keep_trace(error: BaseException) -> str:
    """Path of a file with the traceback; empty when nothing can be written."""
    text = "".join(traceback.format_exception(error))
    try:
        handle, path = tempfile.mkstemp(prefix="flatplank-trace-", suffix=".txt")
        with os.fdopen(handle, "w", encoding="utf-8") as file:
            file.write(text)
    except OSError:
        return ""
    return path
