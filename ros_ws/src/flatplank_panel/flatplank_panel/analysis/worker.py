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

from flatplank_analysis.effects.consent import ConsentError, digest, shown
from flatplank_data.progress import Progress
from flatplank_hw.process import end_with_parent

JOBS = {
    "browse_jobs": ("campaigns", "runs", "curves", "turns", "identify"),
    "catalogue_jobs": ("catalogue",),
    "chart_jobs": ("reference_chart",),
    "fit_jobs": ("open", "compare", "diagnose", "add", "undo", "report", "simulate", "allow"),
    "proposing": ("propose", "accept", "rename", "confirm"),
    "investigating": ("investigation_state", "choose_batch", "measure_batch", "refuse_batch"),
}
MODULES = {job: module for module, jobs in JOBS.items() for job in jobs}
"""job -> module with a function of that name (`open_` for `open`)"""


def to_strict_json(value: Any) -> Any:
    """Convert to strict JSON: numpy as lists, non-finite numbers as null, rounded floats."""
    if isinstance(value, Mapping):
        return {str(k): to_strict_json(v) for k, v in value.items()}
    if isinstance(value, (list, tuple)):
        return [to_strict_json(v) for v in value]
    if hasattr(value, "tolist"):
        return to_strict_json(value.tolist())
    if isinstance(value, float):
        return float(f"{value:.6g}") if math.isfinite(value) else None
    return value


def do_request(request: Mapping[str, Any], progress: Progress) -> dict[str, Any]:
    """Do one request; {"result": ...} or {"error": text}."""
    name = request["do"]
    module = import_module(f"flatplank_panel.analysis.{MODULES[name]}")
    job = getattr(module, "open_" if name == "open" else name)
    try:
        return {"result": to_strict_json(job(progress, **request.get("with", {})))}
    except ConsentError as error:
        text = shown(error.text)
        asked = {"file": str(error.path), "text": text, "digest": digest(error.content)}
        return {"error": str(error), "consent": asked}
    except (ValueError, OSError) as error:
        return {"error": " ".join(str(error).split())}


def main() -> int:
    end_with_parent()
    # output of libraries must not mix with the answers
    out = os.fdopen(os.dup(1), "w", encoding="utf-8")
    os.dup2(2, 1)

    def write_message(message: Mapping[str, Any]) -> None:
        out.write(json.dumps(message, allow_nan=False) + "\n")
        out.flush()

    for line in sys.stdin:
        write_message(
            do_request(
                json.loads(line),
                lambda text, share: write_message({"progress": text, "share": share}),
            )
        )
    return 0


if __name__ == "__main__":
    raise SystemExit(main())
