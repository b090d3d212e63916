# SPDX-License-Identifier: Apache-2.0
"""Compares results of `simulate`, `fit` and `report` for all tires of the thesis with the plant's
truth.

The verbs and the table of the plant run as separate programs, so the analysis has only the files.
"""

from __future__ import annotations

import json
import subprocess
import sys
import tempfile
from collections.abc import Sequence
from pathlib import Path
from typing import Any

from flatplank_analysis.report.radii import FLAT

TIRES = ("toyo", "continental", "michelin", "racing")
TRUTHS = {
    "C_Fk": "slip_stiffness",
    "c_cx": "carcass_stiffness_x",
    "sigma_x": "relaxation_length_x",
    "r_e": "effective_rolling_radius",
}
"""quantity -> its name in the plant's table"""


def measure(tires: Sequence[str] = TIRES) -> dict[str, float]:
    """Estimate, ends of the 90 % interval, truth and error [%] of every quantity."""
    out = {}
    with tempfile.TemporaryDirectory() as folder:
        for plant in tires:
            found = measure_tire(plant, Path(folder))
            for name, row in found["rows"].items():
                key = f"{found['tire']}_{name}"
                out[key] = row["found"]
                out[f"{key}_low"], out[f"{key}_high"] = row["low"], row["high"]
                out[f"{key}_true"] = row["true"]
                out[f"{key}_error_%"] = 100.0 * (row["found"] / row["true"] - 1.0)
    return out


def measure_tire(plant: str, folder: Path) -> dict[str, Any]:
    """Measure one tire at nominal load and pressure; c_cx and sigma_x are corrected by the bias of
    the model.

    The 90 % interval is that of the report; for r_e it is the range that the report calls
    agreement.
    """
    here = folder / plant
    _verb("simulate", str(here), "--tire", plant)
    (here / "fit.json").write_text(_verb("fit", str(here), "--model", "mf", "--json"))
    _verb("report", str(here))
    report = json.loads((here / "report" / "report.json").read_text())
    (point,) = [p for p in report["points"] if p["carcass"]]
    carcass, free = point["carcass"], point["carcass"]["without_bias"]
    slip_stiffness = carcass["slip_stiffness"]["value"]
    radii = [r["radius"] * (1.0 + r["force"] / slip_stiffness) for r in report["radii"]]
    mean = sum(radii) / len(radii)
    reach = FLAT * mean
    ranges = carcass["without_bias_interval90"]
    found = {
        "C_Fk": (slip_stiffness, carcass["slip_stiffness"]["interval90"]),
        "c_cx": (free["c_cx"], ranges["c_cx"]),
        "sigma_x": (free["sigma_x"], ranges["sigma_x"]),
        "r_e": (mean, (mean - reach, mean + reach)),
    }
    truth = _truth(plant, point["point"]["fz"], point["point"]["pressure"])
    rows = {
        name: {"found": value, "low": low, "high": high, "true": truth[TRUTHS[name]]}
        for name, (value, (low, high)) in found.items()
    }
    return {"tire": report["tire"], "rows": rows}


def _verb(*words: str) -> str:
    return _run("flatplank_analysis.cli.main", *words)


def _truth(plant: str, fz: float, bar: float) -> dict[str, float]:
    """Table of the plant: one line per quantity, its name first."""
    words = ("--tire", plant, "--load", f"{fz:g}", "--pressure", f"{bar:g}")
    text = _run("flatplank_validation.truth", *words)
    rows = (line.split() for line in text.splitlines()[1:] if line.strip())
    return {name: float(value) for name, value in rows}


def _run(*words: str) -> str:
    done = subprocess.run([sys.executable, "-m", *words], capture_output=True, text=True)
    if done.returncode:
        raise RuntimeError(f"{' '.join(words)}: {done.stderr.strip()[-500:]}")
    return done.stdout
