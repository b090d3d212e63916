# SPDX-License-Identifier: Apache-2.0
"""Run names of the thesis, Appendix F: XXX_VVV_ZZZ_T_pXX_FzYYYY_N, further runs with _rNN."""

from __future__ import annotations

import re
from typing import Any

from flatplank_data.info import RunInfo

_TAIL = re.compile(
    r"_T_p(?P<p>\d+)_Fz(?P<fz>[\d.]+)_(?P<start>\d+)(?:_r(?P<repeat>\d+))?$", re.IGNORECASE
)
_SLIP = re.compile(r"^(-?[\d.]+)perc$")
_ANGLE = re.compile(r"^(-?[\d.]+)deg$")
_KINDS = ("REL_COM_CAM", "REL_LNG_CAM", "REL_COM", "REL_LNG", "REP_REL", "STF")


def parse_name(stem: str) -> dict[str, Any]:
    """Facts of the run record that the name tells; empty when it is not of this form."""
    match = _TAIL.search(stem)
    if match is None:
        return {}
    tire, _, rest = stem[: match.start()].partition("_")
    facts: dict[str, Any] = {
        "tire": tire,
        "pressure": int(match["p"]) / 10.0,
        "fz": float(match["fz"]),
        "start": int(match["start"]),
        "repeat": int(match["repeat"] or 1),
        "measurement": "slip",
    }
    if rest.startswith("ERR_") or rest == "ERR":
        facts["measurement"] = "free_rolling"
        rest = rest.removeprefix("ERR").lstrip("_")
    kind = next((k for k in _KINDS if rest == k or rest.startswith(k + "_")), "")
    if kind == "STF":
        facts["measurement"] = "stiffness"
    words = rest.removeprefix(kind).strip("_").split("_")
    shape = [w for w in words if w.isalpha()] if kind.startswith("REL") else []
    if shape:
        facts["waveform"] = {"name": "_".join(shape).lower()}
    return facts | _settings(kind, words)


def _settings(kind: str, words: list[str]) -> dict[str, float]:
    """Slip, side slip and camber; with `_CAM` the first angle is the camber."""
    out: dict[str, float] = {}
    angles = [float(m[1]) for w in words if (m := _ANGLE.match(w))]
    slips = [float(m[1]) for w in words if (m := _SLIP.match(w))]
    if slips:
        out["kappa"] = slips[0] / 100.0
    if kind.endswith("_CAM") and angles:
        out["gamma_deg"] = angles.pop(0)
    if angles:
        out["alpha_deg"] = angles[0]
    return out


def run_name(info: RunInfo) -> str:
    """Name of a run without suffix, the inverse of `parse_name`."""
    combined, cambered = bool(info.alpha_deg), bool(info.gamma_deg)
    kind = ("REL_COM" if combined else "REL_LNG") + ("_CAM" if cambered else "")
    if info.measurement == "stiffness":
        kind = "STF"
    words = [info.tire or "XXX"]
    if info.measurement == "free_rolling":
        words.append("ERR")
    words.append(kind)
    shape = info.kind.removeprefix("slip").strip()
    if info.measurement == "slip" and shape and shape != "reversed":
        words.append(shape.split()[0].upper())
    if cambered:
        words.append(f"{info.gamma_deg:g}deg")
    if combined:
        words.append(f"{info.alpha_deg:g}deg")
    if info.measurement == "slip":
        words.append(f"{100.0 * info.kappa:.10g}perc")
    words += ["T", f"p{round(info.pressure * 10.0):02d}", f"Fz{info.fz:.10g}", str(info.start)]
    return "_".join(words) + (f"_r{info.repeat:02d}" if info.repeat > 1 else "")
