# SPDX-License-Identifier: Apache-2.0
"""The worker process: reads a JSON request per line, writes progress and an answer."""

from __future__ import annotations

import json
import math
import os
import sys
from collections.abc import Mapping
from importlib import import_module
from typing import Any

from flatplank_data.errors import FlatplankError
from flatplank_hw.process import end_with_parent
from flatplank_panel.analysis.client import Progress

JOBS = {
    "browse_jobs": ("campaigns", "runs", "curves", "turns", "identify"),
    "fit_jobs": ("open", "compare", "diagnose", "add", "undo", "report", "simulate"),
    "proposing": ("propose", "accept", "rename", "confirm"),
    "investigating": ("investigation", "decide", "measure", "refuse"),
}
MODULES = {job: module for module, jobs in JOBS.items() for job in jobs}
"""job -> module with a function of that name (`open_` for `open`)"""


def plain(value: Any) -> Any:
    """Convert to strict JSON: numpy as lists, non-finite numbers as null, rounded floats."""
    if isinstance(value, Mapping):
        return {str(k): plain(v) for k, v in value.items()}
    if isinstance(value, (list, tuple)):
        return [plain(v) for v in value]
    if hasattr(value, "tolist"):
        return plain(value.tolist())
    if isinstance(value, float):
        return float(f"{value:.6g}") if math.isfinite(value) else None
    return value


def do(request: Mapping[str, Any], progress: Progress) -> dict[str, Any]:
    """Do one request; {"result": ...} or {"error": text}."""
    name = request["do"]
    module = import_module(f"flatplank_panel.analysis.{MODULES[name]}")
    job = getattr(module, "open_" if name == "open" else name)
    try:
        return {"result": plain(job(progress, **request.get("with", {})))}
    except (FlatplankError, ValueError, OSError) as error:
        return {"error": " ".join(str(error).split())}


def main() -> int:
    end_with_parent()
    # output of libraries must not mix with the answers
    out = os.fdopen(os.dup(1), "w", encoding="utf-8")
    os.dup2(2, 1)

    def tell(message: Mapping[str, Any]) -> None:
        out.write(json.dumps(message, allow_nan=False) + "\n")
        out.flush()

    for line in sys.stdin:
        tell(do(json.loads(line), lambda text, share: tell({"progress": text, "share": share})))
    return 0


if __name__ == "__main__":
    raise SystemExit(main())
