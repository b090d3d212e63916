# SPDX-License-Identifier: Apache-2.0
"""A proposed next run in the words of run records, with what its campaign holds constant."""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import Any

import numpy as np

from flatplank_analysis.contact_patch.session import Session
from flatplank_data.run_record import RunRecord

CONSTANT = ("fz", "pressure", "alpha_deg", "gamma_deg")


def runs_of(session: Session, proposal: Mapping[str, Any]) -> dict[str, Any]:
    """The proposal with `tire` and `runs`: a mapping of settings for every run that it means.

    `conditions` among its settings are labels of the campaign; each becomes a run of its own.
    """
    settings = dict(proposal.get("settings") or {})
    if not settings:
        return dict(proposal)
    infos = {run.info.name: run.info for run in session.campaign.runs}
    runs = session.data.runs
    known = {
        label: infos[runs.names[rows[0]]]
        for label, rows in zip(runs.condition_names, runs.groups, strict=True)
    }
    if "conditions" not in settings:
        made = [_usual(list(known.values())) | settings]
    else:
        labels = settings.pop("conditions")
        made = [_slip(known[label]) | settings for label in labels]
    return {**proposal, "tire": next(iter(known.values())).tire, "runs": made}


def _usual(infos: list[RunRecord]) -> dict[str, float]:
    """Median of what the runs hold constant."""
    values = {k: [getattr(i, k) for i in infos] for k in CONSTANT}
    return _finite({k: float(np.median(v)) for k, v in values.items()})


def _slip(info: RunRecord) -> dict[str, float]:
    return _finite({k: float(getattr(info, k)) for k in ("kappa", *CONSTANT)})


def _finite(values: Mapping[str, float]) -> dict[str, float]:
    return {k: v for k, v in values.items() if math.isfinite(v)}
