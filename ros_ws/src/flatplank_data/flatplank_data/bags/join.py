# SPDX-License-Identifier: Apache-2.0
"""Joins the topics of a bag to one table: the rows are the samples of the base topic."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np

from flatplank_data.bags.clocks import LOG_TIME, Times, times_to_use
from flatplank_data.bags.series import Series
from flatplank_data.bags.topics import OWN, STAMP, TopicMap
from flatplank_data.errors import FlatplankError
from flatplank_data.table import STANDARD_COLUMNS

SAME_RATE = 0.1
"""two topics have one rate when their periods differ by less, relative [-]"""
SAME_CLOCK = 0.05
"""below this share of equal stamps a topic follows another clock [-]"""


def joined(
    where: str, topics: TopicMap, series: Mapping[str, Series], damage: Sequence[str]
) -> tuple[dict[str, np.ndarray], list[str]]:
    """Columns in SI, and remarks. Raises FlatplankError, which tells the damage of the file."""
    remarks = _check_topics(where, topics, series, damage)
    tables = {}
    for topic, one in series.items():
        if one.parts:
            values, more = _columns(topics, one)
            tables[topic] = (one.order(), values)
            remarks += more
    times = {t: _times(series[t], order, values) for t, (order, values) in tables.items()}
    found, more = times_to_use(times, topics.base, one_clock=topics is OWN)
    remarks += more
    sorted_ = {}
    for topic, (order, values) in tables.items():
        stamp, values, again = _sorted(found[topic], order, values)
        sorted_[topic] = (stamp, values)
        if again:
            what = f"{again} messages of {topic} have the time of another one and are left out"
            remarks.append(what)
    columns, more = _on_rows(topics, sorted_)
    remarks += more
    columns, more = _since_trigger(columns, where, _slack(sorted_))
    return columns, remarks + more


def _slack(tables: Mapping[str, tuple[np.ndarray, Mapping[str, np.ndarray]]]) -> float:
    """Time at either end that topics need not cover: two periods of the slowest one [s]."""
    periods = [1e-9 * float(np.median(np.diff(t))) for t, _ in tables.values() if t.size > 1]
    return 2.0 * max(periods, default=0.0)


def _check_topics(
    where: str, topics: TopicMap, series: Mapping[str, Series], damage: Sequence[str]
) -> list[str]:
    """Remarks on topics without messages. FlatplankError where a column of the table needs one."""
    remarks = []
    for topic, sources in topics.sources.items():
        if series[topic].parts:
            if series[topic].stamp not in ("", STAMP) and not series[topic].has_stamps:
                what = f"no stamp '{topics.time}' in messages of {topic}"
                raise FlatplankError(what, "mapping, time", f"write {STAMP} or {LOG_TIME}")
            continue
        needed = topic == topics.base or (
            topics is not OWN and any(s.column in STANDARD_COLUMNS for s in sources)
        )
        if needed:
            what = "; ".join([f"no message on {topic}", *damage])
            has = ", ".join(t for t, s in series.items() if s.parts) or "none of the mapped topics"
            remedy = f"check that the topic was recorded, or the mapping (the bag has {has})"
            raise FlatplankError(what, where, remedy)
        if topics is not OWN:
            remarks.append(f"no message on {topic}")
    return remarks


def _columns(topics: TopicMap, series: Series) -> tuple[dict[str, np.ndarray], list[str]]:
    """Column -> values in SI, in the order of reading, and remarks."""
    values, remarks = {}, []
    for source in topics.sources[series.topic]:
        column, remark = series.column(source.path, strict=topics is not OWN)
        remarks += [remark] if remark else []
        if not np.isnan(column).all():
            values[source.column] = column * source.factor + source.offset
    return values, remarks


def _times(series: Series, order: np.ndarray, values: Mapping[str, np.ndarray]) -> Times:
    samples = np.zeros(order.size, dtype=np.uint64)
    for column in values.values():
        samples = samples * np.uint64(1_000_003) + column.view(np.uint64)
    return Times(series.topic, series.log[order], series.stamp_or_log[order], samples[order])


def _sorted(
    times: np.ndarray, order: np.ndarray, values: Mapping[str, np.ndarray]
) -> tuple[np.ndarray, dict[str, np.ndarray], int]:
    """Times in order without doubles, the columns, and the number of doubles."""
    if np.all(np.diff(times) > 0):
        return times, {name: column[order] for name, column in values.items()}, 0
    unique, first = np.unique(times, return_index=True)
    columns = {name: column[order][first] for name, column in values.items()}
    return unique, columns, times.size - unique.size


def _on_rows(
    topics: TopicMap, tables: Mapping[str, tuple[np.ndarray, Mapping[str, np.ndarray]]]
) -> tuple[dict[str, np.ndarray], list[str]]:
    base, _ = tables[topics.base]
    columns = {"time": base}
    whole, remarks = np.ones(base.size, dtype=bool), []
    for topic, (stamp, values) in tables.items():
        if any(column in STANDARD_COLUMNS for column in values):
            received = _received(base, stamp)
            whole &= received
            if not received.all():
                lacking = f"{int((~received).sum())} of {base.size} messages on {topics.base}"
                remarks.append(f"{lacking} are left out: {topic} has none with their stamp")
        columns |= {name: _on_base(base, stamp, column) for name, column in values.items()}
    return {name: values[whole] for name, values in columns.items()}, remarks


def _received(base: np.ndarray, stamp: np.ndarray) -> np.ndarray:
    """Mask (base,) of the base cycles that are kept for a topic.

    A cycle that the topic lost is dropped, not interpolated from its neighbours. All are kept when
    the topic has another clock or rate, because it is then interpolated; those outside its time
    range are always kept.
    """
    everything = np.ones(base.size, dtype=bool)
    if base.size < 3 or stamp.size < 3 or np.array_equal(base, stamp):
        return everything
    ours, theirs = (float(np.percentile(np.diff(s), 5)) for s in (base, stamp))
    present = np.isin(base, stamp, assume_unique=True)
    if abs(theirs / ours - 1.0) > SAME_RATE or present.mean() < SAME_CLOCK:
        return everything
    return present | (base < stamp[0]) | (base > stamp[-1])


def _on_base(base: np.ndarray, stamp: np.ndarray, column: np.ndarray) -> np.ndarray:
    """`column` at the base stamps: unchanged if the stamps are equal, else interpolated."""
    if base.size == stamp.size and np.array_equal(base, stamp):
        return column
    zero = base[0]
    return np.interp(
        (base - zero) * 1e-9, (stamp - zero) * 1e-9, column, left=np.nan, right=np.nan
    )


def _since_trigger(
    columns: dict[str, np.ndarray], where: str, slack: float
) -> tuple[dict[str, np.ndarray], list[str]]:
    """Samples from the motion trigger on, with time in s (given in ns): before the trigger the
    plank position has another zero.

    Cycles at the start and end that a topic does not cover are left out, with a remark when
    they are longer than `slack` [s].
    """
    first = 0
    trigger = columns.get("motion_trigger")
    if trigger is not None and trigger.any():
        first = int(np.argmax(trigger > 0.5))
    measured = [v for n, v in columns.items() if n in STANDARD_COLUMNS]
    whole = np.flatnonzero(np.all(np.isfinite(measured), axis=0))
    last = int(whole[-1]) + 1 if whole.size else len(columns["time"])
    begin = max(first, int(whole[0])) if whole.size else first
    remarks = [
        f"the {name} {b - a} rows ({gap:.3g} s) are left out: not all topics cover them"
        for name, a, b in (("first", first, begin), ("last", last - 1, len(columns["time"]) - 1))
        if whole.size and (gap := 1e-9 * float(columns["time"][b] - columns["time"][a])) > slack
    ]
    first = begin
    if last <= first:
        what = "no cycle after the motion trigger has all channels"
        raise FlatplankError(what, where, "the run ended too early: measure it again")
    out = {name: values[first:last] for name, values in columns.items()}
    out["time"] = (out["time"] - out["time"][0]) * 1e-9
    return out, remarks
