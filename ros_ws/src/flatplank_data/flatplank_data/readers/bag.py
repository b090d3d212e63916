# SPDX-License-Identifier: Apache-2.0
"""Reads bags to measurement tables: needed topics only, joined by the stamp of the bus cycle."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np

from flatplank_data.bags.cdr import decode_many, decode_one, layout_of, parse_definition
from flatplank_data.bags.compression import SUFFIX, CompressedFile, plain_blocks
from flatplank_data.bags.storage import McapFile, SqliteFile
from flatplank_data.bags.topics import OWN, RUN_TOPIC, TopicMap, topic_map
from flatplank_data.errors import FlatplankError, YamlError
from flatplank_data.measured import measured_facts
from flatplank_data.readers import cache
from flatplank_data.readers.base import Loaded, Request, describer, reader
from flatplank_data.run_record import FILE_NAME
from flatplank_data.store import Store
from flatplank_data.table import STANDARD_COLUMNS
from flatplank_data.yaml_text import load_yaml

METADATA_FILE = "metadata.yaml"
MEASURED = "measured"
"""key of the facts that were derived from the samples"""
SAME_RATE = 0.1
"""two topics have one rate when their periods differ by less, relative [-]"""
SAME_CLOCK = 0.05
"""below this share of equal stamps a topic follows another clock [-]"""
_STAMP = ("header.stamp.sec", "header.stamp.nanosec")
_PLAIN = {".mcap": McapFile, ".db3": SqliteFile}
_STORAGE: dict[str, Callable[[Path], Any]] = {
    **_PLAIN, SUFFIX: partial(CompressedFile, storage=_PLAIN),
}  # fmt: skip
"""suffix -> reader of such a file"""


@reader(*_STORAGE)
def read_bag(request: Request) -> Loaded:
    """Read a bag folder or a single file; a Parquet cache beside it keeps the table."""
    key = cache.cache_key(request)
    kept = cache.load_cached(request, key)
    if kept is not None:
        return kept
    loaded = import_bag(request.store.local(request.name), topic_map(request.mapping))
    cache.save_to_cache(request, key, loaded)
    if request.columns is None:
        return loaded
    columns = {k: v for k, v in loaded.columns.items() if request.wants(k)}
    return Loaded(columns, loaded.facts, loaded.remarks)


@describer(*_STORAGE)
def describe_bag(store: Store, name: str) -> dict[str, Any]:
    """Facts of the run record beside the bag, else of the last `/run` message (final status)."""
    record = f"{name}/{FILE_NAME}" if store.is_dir(name) else _record_of_bag(name)
    if store.exists(record):
        with store.open(record) as stream:
            return _record({"record": stream.read().decode("utf-8")})
    facts: dict[str, Any] = {}
    for file in _files(store.local(name)):
        for block in plain_blocks(file.blocks({RUN_TOPIC})):
            kind = parse_definition(block.channel.type, block.channel.definition)
            facts |= _record(decode_one(kind, block.payloads[-1].tobytes()))
    return facts


def _record_of_bag(name: str) -> str:
    """The run record of a bag whose own folder was opened."""
    folder, _, _ = name.rpartition("/")
    return f"{folder}/{FILE_NAME}" if folder else FILE_NAME


def import_bag(path: Path, topics: TopicMap) -> Loaded:
    """Read a bag from disk: columns in SI, the run record, remarks."""
    files = _files(path)
    series: dict[str, list] = {topic: [] for topic in topics.sources}
    facts: dict[str, Any] = {}
    remarks = []
    for file in files:
        wanted = {*topics.sources, RUN_TOPIC}
        for block in plain_blocks(file.blocks(wanted)):
            kind = parse_definition(block.channel.type, block.channel.definition)
            if block.channel.topic == RUN_TOPIC:
                facts |= _record(decode_one(kind, block.payloads[-1].tobytes()))
                continue
            sources = topics.sources[block.channel.topic]
            use_log = topics.time == "log_time"
            paths = [s.path for s in sources] + ([] if use_log else list(_STAMP))
            rows, values = decode_many(kind, block.payloads, paths)
            stamp = block.log_time[rows] if use_log else _stamps(values, block.log_time[rows])
            series[block.channel.topic].append((stamp, values))
        if file.cut_short:
            remarks.append("the bag has no end (recorder killed?): read as far as it goes")
    columns = _join(path, topics, series)
    if topics is OWN:
        facts[MEASURED] = measured_facts(columns)
    return Loaded(columns, facts, remarks)


def arrays_of(path: Path, topic: str, names: Sequence[str]) -> dict[str, np.ndarray]:
    """Sequences of one topic, joined over its messages; empty where there is no such topic."""
    stamps: list[np.ndarray] = []
    parts: dict[str, list[np.ndarray]] = {name: [] for name in names}
    for file in _files(path):
        for block in plain_blocks(file.blocks({topic})):
            kind = parse_definition(block.channel.type, block.channel.definition)
            members = layout_of(kind, block.payloads[0].tobytes()).members
            paths = {name: [p for p in members if p.startswith(f"{name}[")] for name in names}
            rows, values = decode_many(kind, block.payloads, [p for n in names for p in paths[n]])
            stamps.append(block.log_time[rows])
            for name, own in paths.items():
                parts[name] += list(np.column_stack([values[p] for p in own]))
    order = np.argsort(np.concatenate(stamps), kind="stable") if stamps else []
    return {n: np.concatenate([p[i] for i in order] or [[]]) for n, p in parts.items()}


def _files(path: Path) -> list:
    """The storage files of a bag in order; an unpacked copy is preferred to a compressed file."""
    paths = [path]
    if path.is_dir():
        _refuse_compression(path)
        paths = sorted(p for p in path.iterdir() if p.suffix in _STORAGE)
        paths = [p for p in paths if p.suffix != SUFFIX or p.with_suffix("") not in paths]
    if not paths:
        raise FlatplankError("no .mcap or .db3 file", path.name, "copy the whole bag folder")
    return [_STORAGE[p.suffix](p) for p in paths]


def _refuse_compression(folder: Path) -> None:
    """Refuse a bag whose metadata name an unknown compression."""
    try:
        content = load_yaml((folder / METADATA_FILE).read_bytes(), METADATA_FILE)
        information = content["rosbag2_bagfile_information"]
    except (OSError, YamlError, TypeError, KeyError):
        return  # the content of the files decides
    kind = information.get("compression_format") or SUFFIX[1:]
    if kind != SUFFIX[1:]:
        mode = str(information.get("compression_mode", "")).lower()
        plain = "output_bags: [{uri: plain, storage_id: mcap, all_topics: true}]"
        raise FlatplankError(
            f"compressed by {mode} with '{kind}', only {SUFFIX[1:]} is read",
            folder.name,
            f"unpack it: echo '{plain}' > plain.yaml; ros2 bag convert -i {folder.name} "
            "-o plain.yaml",
        )


def _record(message: dict[str, Any]) -> dict[str, Any]:
    """Facts of a `/run` message: the YAML record, its UUID and status."""
    record = load_yaml(str(message.get("record") or ""), f"run record on {RUN_TOPIC}") or {}
    facts = dict(record) if isinstance(record, dict) else {}
    facts.pop("file", None)
    for key in ("uuid", "status"):
        if message.get(key):
            facts[key] = message[key]
    return facts


def _stamps(values: dict[str, np.ndarray], log_time: np.ndarray) -> np.ndarray:
    """Stamps [ns]; the log time where a message has no header."""
    sec, nsec = (values[path] for path in _STAMP)
    if sec.dtype.kind == "f":
        return log_time
    return sec.astype(np.int64) * 1_000_000_000 + nsec.astype(np.int64)


def _join(path: Path, topics: TopicMap, series: dict[str, list]) -> dict[str, np.ndarray]:
    if not series[topics.base]:
        raise FlatplankError(
            f"no message on {topics.base}",
            path.name,
            "check that the topic was recorded, or give a mapping file",
        )
    base, _ = _sorted(series[topics.base], [])
    columns = {"time": (base - base[0]) * 1e-9}
    whole = np.ones(base.size, dtype=bool)
    for topic, parts in series.items():
        if not parts:
            continue
        sources = topics.sources[topic]
        stamp, values = _sorted(parts, [s.path for s in sources])
        if any(source.column in STANDARD_COLUMNS for source in sources):
            whole &= _received(base, stamp)
        for source in sources:
            column = values[source.path]
            if np.isnan(column).all():
                continue
            if source.factor != 1.0 or source.offset != 0.0:
                column = column * source.factor + source.offset
            columns[source.column] = _on_base(base, stamp, column)
    columns = {name: values[whole] for name, values in columns.items()}
    return _since_trigger(columns, path.name)


def _sorted(parts: list, paths: list[str]) -> tuple[np.ndarray, dict[str, np.ndarray]]:
    """Sorted stamps without duplicates, and their float64 columns."""
    stamp = np.concatenate([s for s, _ in parts])
    order = None
    if np.any(np.diff(stamp) <= 0):
        stamp, order = np.unique(stamp, return_index=True)
    values = {}
    for path in paths:
        column = np.concatenate([np.asarray(v[path], dtype=np.float64) for _, v in parts])
        values[path] = column if order is None else column[order]
    return stamp, values


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


def _since_trigger(columns: dict[str, np.ndarray], where: str) -> dict[str, np.ndarray]:
    """Samples from the motion trigger on: before it the plank position has another zero.

    Cycles at the start and end that a topic does not cover are left out.
    """
    first = 0
    trigger = columns.get("motion_trigger")
    if trigger is not None and trigger.any():
        first = int(np.argmax(trigger > 0.5))
    measured = [v for n, v in columns.items() if n in STANDARD_COLUMNS]
    whole = np.flatnonzero(np.all(np.isfinite(measured), axis=0))
    last = int(whole[-1]) + 1 if whole.size else len(columns["time"])
    first = max(first, int(whole[0])) if whole.size else first
    if last <= first:
        what = "no cycle after the motion trigger has all channels"
        raise FlatplankError(what, where, "the run ended too early: measure it again")
    out = {name: values[first:last] for name, values in columns.items()}
    out["time"] = out["time"] - out["time"][0]
    return out
