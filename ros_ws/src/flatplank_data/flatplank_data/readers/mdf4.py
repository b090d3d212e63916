# SPDX-License-Identifier: Apache-2.0
"""Reads MDF4 files: the channel group with most of the known columns, units as the channels have
them, else SI. Needs the package asammdf (`flatplank_data.mdf`)."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np

from flatplank_data.errors import FlatplankError
from flatplank_data.guard import Budget
from flatplank_data.mdf import MASTER, channels_of, master_of, opened, record_in
from flatplank_data.readers.base import (
    Loaded,
    Request,
    canonical_names,
    columns_in_si,
    describer,
    known_name,
    reader,
)
from flatplank_data.store import Store
from flatplank_data.table import COLUMN_UNITS


@reader(".mf4")
def read_mdf4(request: Request) -> Loaded:
    """Read the wanted channels of one group."""
    with request.store.open(request.name) as stream, opened(stream, request.name) as file:
        known = [_known(file, group, request.mapping) for group in range(len(file.groups))]
        if not any(known):
            what = "no channel group has a known column"
            remedy = f"map names by a mapping file; known: {', '.join(COLUMN_UNITS)}"
            raise FlatplankError(what, request.name, remedy)
        group = max(range(len(known)), key=lambda g: len(known[g]))
        places = channels_of(file, group)
        rows = file.groups[group].channel_group.cycles_nr
        size = request.store.size_and_time(request.name)[0]
        Budget.of(request.name, size).take(8 * rows * (len(places) + 1))
        names, remarks = canonical_names(places, request.mapping, request.further)
        # the name of the master is that of the recorder: time, t, timestamps
        own = {theirs: ours for theirs, ours in names.items() if ours != MASTER}
        signals = {t: file.get(group=group, index=places[t]) for t in own if request.wants(own[t])}
        own = {
            t: o for t, o in own.items()
            if t in signals and _is_number(signals[t], o, f"{request.name}, '{t}'")
        }  # fmt: skip
        columns = columns_in_si(
            own, request, lambda t: np.asarray(signals[t].samples, np.float64),
            lambda t: signals[t].unit or None, "channel",
        )  # fmt: skip
        if request.wants(MASTER):
            columns = {MASTER: master_of(file, group)} | columns
        facts = record_in(file)
    elsewhere = {n for g, found in enumerate(known) if g != group for n in found} - known[group]
    if elsewhere:
        listed = ", ".join(sorted(elsewhere))
        remarks.append(f"{listed}: in another channel group, with its own times, and left out")
    return Loaded(columns, facts, remarks)


@describer(".mf4")
def describe_mdf4(store: Store, name: str) -> dict[str, Any]:
    """The run record that is attached to our own exports."""
    with store.open(name) as stream, opened(stream, name) as file:
        return record_in(file)


def _known(file: Any, group: int, mapping: Mapping[str, Any] | None) -> set[str]:
    """Our names of the channels of a group."""
    return {known_name(n, mapping) for n in channels_of(file, group)} & COLUMN_UNITS.keys()


def _is_number(signal: Any, ours: str, where: str) -> bool:
    """Whether a channel holds one number per sample; FlatplankError in a known column."""
    samples = signal.samples
    if samples.ndim == 1 and samples.dtype.kind in "fiub":
        return True
    if ours in COLUMN_UNITS:
        remedy = "export it as floating-point numbers"
        raise FlatplankError(f"its samples are {samples.dtype}, not numbers", where, remedy)
    return False
