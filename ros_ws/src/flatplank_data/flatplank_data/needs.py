# SPDX-License-Identifier: Apache-2.0
"""Which parameters a campaign can identify, and which runs are missing for the others."""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable, Sequence

from flatplank_data.run_record import RunRecord

Infos = Sequence[RunRecord]


def parameters_and_missing_runs(infos: Infos) -> list[dict[str, str]]:
    """Groups of parameters, each with its meaning and its missing runs (as text, may be empty)."""
    return [
        {"parameters": parameters, "meaning": meaning, "missing": missing(infos)}
        for parameters, meaning, missing in NEEDS
    ]


def _lack(wanted: int, there: int, runs: str) -> str:
    return "" if there >= wanted else runs.format(wanted - there)


def _of(infos: Infos, *measurements: str) -> list[RunRecord]:
    return [info for info in infos if info.measurement in measurements]


def _steps(infos: Infos) -> list[RunRecord]:
    return _of(infos, "slip")


def _rolling(infos: Infos) -> list[RunRecord]:
    return _of(infos, "free_rolling", "slip")


def _levels(infos: Infos, name: str) -> int:
    return len({getattr(info, name) for info in infos})


def _most_slips(infos: Infos) -> int:
    points: dict[object, set[float]] = {}
    for info in _steps(infos):
        points.setdefault(info.condition.operating_point, set()).add(info.kappa)
    return max((len(levels) for levels in points.values()), default=0)


def _offset(infos: Infos) -> str:
    angles = {info.alpha_deg for info in _steps(infos)}
    both = any(angle < 0 for angle in angles) and any(angle > 0 for angle in angles)
    return "" if both else "side slip of both signs, or the tire turned round on its rim"


def _vertical(infos: Infos) -> str:
    runs = _of(infos, "stiffness", "stiffness_vertical")
    if not runs:
        return "a vertical stiffness run at two pressures"
    return "" if _levels(runs, "pressure") >= 2 else "a vertical stiffness run at another pressure"


def _standing(infos: Infos) -> str:
    lack = [k for k in ("stiffness_longitudinal", "stiffness_lateral") if not _of(infos, k)]
    return f"a run of the kind {' and one of '.join(lack)}" if lack else ""


def _repeats(infos: Infos) -> str:
    groups = Counter((info.condition, info.start) for info in _steps(infos))
    if max(groups.values(), default=0) >= 2:
        return ""
    return "a run repeated from the same start angle: start angles mix it with non-uniformity"


NEEDS: tuple[tuple[str, str, Callable[[Infos], str]], ...] = (
    (
        "sigma_x, C'_Fk", "linear transient model per run",
        lambda runs: _lack(
            1, sum(bool(i.kappa) for i in _steps(runs)), "slip steps with kappa other than 0"
        ),
    ),
    (
        "c_cx", "carcass stiffness per operating point",
        lambda runs: _lack(3, _most_slips(runs), "{} more slip level(s) at one operating point"),
    ),
    (
        "r_e", "effective rolling radius",
        lambda runs: _lack(1, len(_rolling(runs)), "a free-rolling run"),
    ),
    (
        "Q_RE0, BREFF, DREFF, FREFF", "rolling radius over load",
        lambda runs: _lack(3, _levels(_rolling(runs), "fz"), "rolling runs at {} more load(s)"),
    ),
    (
        "PCX1, PDX1, PEX1, PKX1, PHX1, PVX1", "longitudinal curve at nominal load",
        lambda runs: _lack(5, _most_slips(runs), "{} more slip level(s), braking and driving"),
    ),
    (
        "PDX2, PKX2, PKX3, PEX2, PEX3", "longitudinal curve over load",
        lambda runs: _lack(3, _levels(_steps(runs), "fz"), "slip steps at {} more load(s)"),
    ),
    (
        "PPX1 and PPX2, PPX3 and PPX4", "longitudinal curve over pressure, apart",
        lambda runs: _lack(
            3, _levels(_steps(runs), "pressure"),
            "slip steps at {} more pressure(s): two cannot separate them",
        ),
    ),
    (
        "PDX3, PKY6", "camber",
        lambda runs: _lack(2, _levels(runs, "gamma_deg"), "runs at another camber angle"),
    ),
    (
        "PCY1, PDY1, PEY1, PKY1", "lateral curve",
        lambda runs: _lack(
            4, _levels(_steps(runs), "alpha_deg"), "runs at {} more side slip angle(s)"
        ),
    ),
    ("PHY1, PVY1 and the steering zero", "lateral offset of the tire or of the machine", _offset),
    (
        "RBX1, RBX2, RCX1, RBY1, RBY2, RCY1", "combined slip",
        lambda runs: _lack(
            2, _levels([i for i in _steps(runs) if i.alpha_deg and i.kappa], "alpha_deg"),
            "slip steps at {} more side slip angle(s) other than 0",
        ),
    ),
    ("C_z, PFZ1", "vertical stiffness, over pressure", _vertical),
    ("C_x, C_y at rest", "stiffness of the standing tire along and across", _standing),
    (
        "q_ra1, q_ra2", "contact length",
        lambda runs: _lack(1, len(_of(runs, "footprint")), "footprints at two loads or more"),
    ),
    (
        "M_F, eta", "friction and efficiency of the wheel drive",
        lambda runs: _lack(
            1, len(_of(runs, "unloaded_turn")),
            "a turn with the wheel hanging free, at several speeds",
        ),
    ),
    ("repeatability", "scatter from run to run", _repeats),
)  # fmt: skip
"""(parameters, meaning, function that names the missing runs)"""
