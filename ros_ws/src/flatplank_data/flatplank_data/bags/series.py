# SPDX-License-Identifier: Apache-2.0
"""The mapped members of one topic over time; elements of named arrays by name, not by position.

`position[1]` of a JointState means the joint that is second in the first message. Where the order
of the names changes, the joint is followed. `position[wheel]` names the joint itself.
"""

from __future__ import annotations

import re
from collections.abc import Iterable
from dataclasses import dataclass, field

import numpy as np

from flatplank_data.bags.blocks import Block
from flatplank_data.bags.cdr import Group, Layout, decode_groups
from flatplank_data.bags.definitions import message_type
from flatplank_data.errors import FlatplankError

_ELEMENT = re.compile(r"(?P<array>.+)\[(?P<key>[^\[\]]*)\](?P<rest>[^\[\]]*)")
_MANY = 12
"""number of members that a message names at most"""


@dataclass
class Series:
    """Messages of one topic, in the order in which they were read."""

    topic: str
    paths: tuple[str, ...]
    stamp: str = ""
    """path of the stamp, empty: the log time is used"""
    log_time: list[np.ndarray] = field(default_factory=list)
    stamps: list[np.ndarray | None] = field(default_factory=list)
    parts: list[Group] = field(default_factory=list)

    def add(self, block: Block) -> None:
        """Decode the messages of a block. Raises FlatplankError."""
        for group in decode_groups(message_type(block.channel), block.payloads, self._wanted):
            self.log_time.append(block.log_time[group.rows])
            self.stamps.append(self._stamps(group))
            self.parts.append(group)

    def _wanted(self, layout: Layout) -> Iterable[str]:
        arrays = {m["array"] for p in self.paths if (m := _ELEMENT.fullmatch(p))}
        yield from (p for p in self.paths if p in layout.members)
        for path in layout.members:
            element = _ELEMENT.fullmatch(path)
            if element and element["array"] in arrays and path not in self.paths:
                yield path
        if self.stamp:
            yield from (f"{self.stamp}.sec", f"{self.stamp}.nanosec")

    def _stamps(self, group: Group) -> np.ndarray | None:
        """Stamps [ns]; None where the messages have none."""
        try:
            sec, nsec = (group.columns[f"{self.stamp}.{part}"] for part in ("sec", "nanosec"))
        except KeyError:
            return None
        return sec.astype(np.int64) * 1_000_000_000 + nsec.astype(np.int64)

    @property
    def has_stamps(self) -> bool:
        """True when every message has a stamp."""
        return all(own is not None for own in self.stamps)

    @property
    def size(self) -> int:
        """Number of messages."""
        return sum(times.size for times in self.log_time)

    @property
    def log(self) -> np.ndarray:
        """Log times [ns]."""
        return np.concatenate(self.log_time)

    @property
    def stamp_or_log(self) -> np.ndarray:
        """Stamps, or the log time where a message has none [ns]."""
        both = zip(self.stamps, self.log_time, strict=True)
        return np.concatenate([log if own is None else own for own, log in both])

    def order(self) -> np.ndarray:
        """Index of the messages by log time, then by stamp."""
        return np.lexsort((self.stamp_or_log, self.log))

    def column(self, path: str, strict: bool) -> tuple[np.ndarray, str]:
        """A member as float64 in the order of `log_time`, and a remark.

        NaN where a message lacks the member; strict: FlatplankError there.
        """
        element = _ELEMENT.fullmatch(path)
        labels = self._labels(element) if element else []
        key, remark = None, ""
        if element and any(labels):
            key, remark = self._key(element, labels)
        out = []
        for group, names in zip(self.parts, labels or [[]] * len(self.parts), strict=True):
            place = path
            if key is not None and element:
                at = names.index(key) if key in names else -1
                place = f"{element['array']}[{at}]{element['rest']}"
            found = group.columns.get(place)
            if found is None and strict:
                raise self._missing(path, group, names, key)
            lacking = np.full(group.rows.size, np.nan)
            out.append(lacking if found is None else found.astype(np.float64))
        return np.concatenate(out), remark

    def _labels(self, element: re.Match) -> list[list[str]]:
        """For each group the names of the elements of an array; empty where it has none."""
        prefix = element["array"].rpartition(".")[0]
        found = []
        for group in self.parts:
            beside = [n for p, n in group.names.items() if p.rpartition(".")[0] == prefix]
            names = beside[0] if beside else []
            found.append(names if len(set(names)) == len(names) else [])
        return found

    def _key(self, element: re.Match, labels: list[list[str]]) -> tuple[str | None, str]:
        """Name of the element, and a remark where the order of the names changes."""
        key = element["key"].strip("'\" ")
        if not key.isdigit():
            return key, ""
        starts = [int(times.min()) for times in self.log_time]
        first = labels[int(np.argmin(starts))]
        if int(key) >= len(first):
            return None, ""
        name = first[int(key)]
        if all(names == first for names in labels):
            return None, ""
        what = f"the names in messages of {self.topic} change; {element.group(0)} is read as"
        return name, f"{what} '{name}', as in the first message"

    def _missing(
        self, path: str, group: Group, names: list[str], key: str | None
    ) -> FlatplankError:
        count = sum(part.rows.size for part in self.parts)
        known = [*group.layout.members, *group.layout.texts]
        known = [p for p in known if not p.startswith(f"{self.stamp}.")]
        has = ", ".join(known[:_MANY]) + (" ..." if len(known) > _MANY else "")
        if path in group.layout.texts:
            what = f"'{path}' is text in messages of {self.topic}"
        elif key is not None:
            what = f"no '{key}' among the names of {self.topic} ({', '.join(names)})"
        else:
            what = f"no member '{path}' in messages of {self.topic}"
        lacking = group.rows.size
        if lacking < count:
            what += f" ({lacking} or more of {count})"
        remedy = f"correct the mapping; such a message has {has}"
        return FlatplankError(what, f"mapping, {self.topic}", remedy)
