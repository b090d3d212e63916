# SPDX-License-Identifier: Apache-2.0
"""Reads bags to measurement tables: needed topics only, joined by the stamp of the bus cycle."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from functools import partial
from operator import itemgetter
from pathlib import Path
from typing import Any

import numpy as np

from flatplank_data.bags.blocks import Block
from flatplank_data.bags.cdr import Layout, decode_groups, decode_one
from flatplank_data.bags.clocks import LOG_TIME
from flatplank_data.bags.compression import SUFFIX, CompressedFile, plain_blocks
from flatplank_data.bags.definitions import as_cdr, message_type
from flatplank_data.bags.join import joined
from flatplank_data.bags.mcap import COPY, McapFile
from flatplank_data.bags.ros1 import Ros1File
from flatplank_data.bags.series import Series
from flatplank_data.bags.sqlite import SqliteFile
from flatplank_data.bags.topics import (
    DRIVE_TOPIC,
    OWN,
    RUN_TOPIC,
    WAVEFORM_TOPIC,
    TopicMap,
    topic_map,
)
from flatplank_data.errors import FlatplankError, YamlError
from flatplank_data.guard import DamagedError
from flatplank_data.measured import measured_facts
from flatplank_data.readers import cache
from flatplank_data.readers.base import Loaded, Request, describer, reader
from flatplank_data.run_record import FILE_NAME
from flatplank_data.store import Store
from flatplank_data.yaml_text import load_yaml

METADATA_FILE = "metadata.yaml"
MEASURED = "measured"
"""key of the facts that were derived from the samples"""
_PLAIN: dict[str, Callable[..., Any]] = {".mcap": McapFile, ".db3": SqliteFile, ".bag": Ros1File}
_STORAGE: dict[str, Callable[[Path], Any]] = {
    **_PLAIN, SUFFIX: partial(CompressedFile, storage=_PLAIN),
}  # fmt: skip
"""suffix -> reader of such a file"""
Said = tuple[int, dict[str, Any]]
"""time [ns] and members of a message"""


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
    files = _files(store.local(name))
    return _last_record(
        said for file in files for block in _blocks(file, {RUN_TOPIC}) for said in _said(block)
    )


def _record_of_bag(name: str) -> str:
    """The run record of a bag whose own folder was opened."""
    folder, _, _ = name.rpartition("/")
    return f"{folder}/{FILE_NAME}" if folder else FILE_NAME


def import_bag(path: Path, topics: TopicMap) -> Loaded:
    """Read a bag from disk: columns in SI, the run record, remarks."""
    stamp = "" if topics.time == LOG_TIME else topics.time
    series = {
        topic: Series(topic, tuple(s.path for s in sources), stamp)
        for topic, sources in topics.sources.items()
    }
    texts: dict[int, str] = {}
    said: dict[str, list[Said]] = {RUN_TOPIC: [], WAVEFORM_TOPIC: []}
    remarks: list[str] = []
    for file in _files(path):
        for block in _blocks(file, {*series, *said}):
            topic = block.channel.topic
            if topic in series:
                series[topic].add(block)
                texts |= _stop_texts(block) if topic == DRIVE_TOPIC else {}
            else:
                said[topic] += _said(block)
        remarks += file.remarks
    columns, more = joined(path.name, topics, series, remarks)
    facts = _last_record(said[RUN_TOPIC])
    if topics is OWN:
        facts[MEASURED] = measured_facts(columns, texts, _waveforms(said[WAVEFORM_TOPIC]))
    return Loaded(columns, facts, [*remarks, *_not_recorded(path, series), *more])


def _blocks(file: Any, wanted: set[str]) -> Iterator[Block]:
    """Messages of the wanted topics in CDR; whatever is damaged is a FlatplankError."""
    try:
        for block in plain_blocks(file, wanted):
            yield from as_cdr(block)
    except (DamagedError, OSError, MemoryError) as error:
        what = f"damaged ({error})"
        raise FlatplankError(what, file.path.name, COPY) from error


def _said(block: Block) -> Iterator[Said]:
    """Every message of a block by its time; messages of other lengths are in other blocks."""
    kind = message_type(block.channel)
    for at, payload in zip(block.log_time.tolist(), block.payloads, strict=True):
        yield at, decode_one(kind, payload.tobytes())


def _in_order(said: Iterable[Said]) -> list[dict[str, Any]]:
    return [message for _, message in sorted(said, key=itemgetter(0))]


def _not_recorded(path: Path, series: Mapping[str, Series]) -> Iterator[str]:
    """Topics of which metadata.yaml counts more messages than the bag has."""
    if not path.is_dir():
        return
    for entry in _information(path).get("topics_with_message_count") or ():
        try:
            topic, count = entry["topic_metadata"]["name"], int(entry["message_count"])
        except (TypeError, KeyError, ValueError):
            continue
        found = series[topic].size if topic in series else count
        if found < count:
            yield f"{found} of the {count} messages on {topic} that {METADATA_FILE} counts"


def arrays_of(path: Path, topic: str, names: Sequence[str]) -> dict[str, np.ndarray]:
    """Sequences of one topic, joined over its messages; empty where there is no such topic."""

    def wanted(layout: Layout) -> list[str]:
        return [p for p in layout.members if p.partition("[")[0] in names]

    stamps: list[np.ndarray] = []
    parts: dict[str, list[np.ndarray]] = {name: [] for name in names}
    for file in _files(path):
        for block in _blocks(file, {topic}):
            for group in decode_groups(message_type(block.channel), block.payloads, wanted):
                stamps.append(block.log_time[group.rows])
                for name in names:
                    own = [v for p, v in group.columns.items() if p.startswith(f"{name}[")]
                    empty = np.empty((group.rows.size, 0))
                    parts[name] += list(np.column_stack(own) if own else empty)
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
        raise FlatplankError("no .mcap, .db3 or .bag file", path.name, "copy the whole bag folder")
    return [_STORAGE[p.suffix](p) for p in paths]


def _information(folder: Path) -> Mapping[str, Any]:
    """The content of metadata.yaml; empty when it cannot be read."""
    try:
        content = load_yaml((folder / METADATA_FILE).read_bytes(), METADATA_FILE)
        information = content["rosbag2_bagfile_information"]
    except (OSError, YamlError, TypeError, KeyError):
        return {}  # the content of the files decides
    return information if isinstance(information, Mapping) else {}


def _refuse_compression(folder: Path) -> None:
    """Refuse a bag whose metadata name an unknown compression."""
    information = _information(folder)
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


def _stop_texts(block: Block) -> dict[int, str]:
    """Stop reason -> its text, of the messages of a drive."""
    kind = message_type(block.channel)
    first: dict[int, int] = {}
    for group in decode_groups(kind, block.payloads, lambda _: ["stop_reason"]):
        codes = group.columns.get("stop_reason", np.zeros(0))
        held = np.flatnonzero(codes)[::-1]  # of equal ones the first counts
        first |= dict(zip(codes[held].tolist(), group.rows[held].tolist(), strict=True))
    found = {code: decode_one(kind, block.payloads[row].tobytes()) for code, row in first.items()}
    return {code: str(message.get("stop_text", "")) for code, message in found.items()}


def _waveforms(said: Iterable[Said]) -> list[dict[str, Any]]:
    """The waveforms that were set, in the order of time."""
    texts = [str(message.get("data", "")) for message in _in_order(said)]
    found = [load_yaml(text, f"waveform on {WAVEFORM_TOPIC}") for text in texts]
    return [waveform for waveform in found if isinstance(waveform, dict)]


def _last_record(said: Iterable[Said]) -> dict[str, Any]:
    """Facts of the `/run` messages; the last one counts."""
    facts: dict[str, Any] = {}
    for message in _in_order(said):
        facts |= _record(message)
    return facts


def _record(message: dict[str, Any]) -> dict[str, Any]:
    """Facts of a `/run` message: the YAML record, its UUID and status."""
    record = load_yaml(str(message.get("record") or ""), f"run record on {RUN_TOPIC}") or {}
    facts = dict(record) if isinstance(record, dict) else {}
    facts.pop("file", None)
    for key in ("uuid", "status"):
        if message.get(key):
            facts[key] = message[key]
    return facts
