# SPDX-License-Identifier: Apache-2.0
"""Columns and keys of the run record whose sign is the other way round in somebody's files.

`mapping: {turn: [fy, alpha_deg]}` in campaign.yaml or a mapping file turns them, in every run.
"""

from __future__ import annotations

import dataclasses
from collections.abc import Mapping
from typing import Any

import numpy as np

from flatplank_data.errors import FlatplankError
from flatplank_data.run_record import RunRecord
from flatplank_data.table import COLUMN_UNITS

KEYS = ("kappa", "alpha_deg", "gamma_deg")
"""of a run record that have a sign"""


def turned_names(mapping: Mapping[str, Any] | None) -> tuple[str, ...]:
    """What a mapping wants to be turned; FlatplankError names what is neither."""
    names = (mapping or {}).get("turn") or ()
    names = (names,) if isinstance(names, str) else tuple(str(n) for n in names)
    for name in names:
        if name not in KEYS and name not in COLUMN_UNITS:
            known = ", ".join([*KEYS, *COLUMN_UNITS])
            raise FlatplankError(f"no column or key '{name}'", "mapping, turn", f"known: {known}")
    return names


def turned_columns(
    columns: Mapping[str, np.ndarray], mapping: Mapping[str, Any] | None
) -> dict[str, np.ndarray]:
    """The columns, some of them with the other sign."""
    names = turned_names(mapping)
    return {k: -v if k in names else v for k, v in columns.items()}


def turned_facts(facts: Mapping[str, Any], mapping: Mapping[str, Any] | None) -> dict[str, Any]:
    """What a file says of its run, some keys with the other sign."""
    names = [n for n in turned_names(mapping) if n in KEYS and facts.get(n)]
    return {**facts, **{n: -float(facts[n]) for n in names}}


def turned_info(info: RunRecord, mapping: Mapping[str, Any] | None) -> RunRecord:
    """The run record, some keys with the other sign."""
    names = [n for n in turned_names(mapping) if n in KEYS and getattr(info, n)]
    return dataclasses.replace(info, **{n: -getattr(info, n) for n in names})
