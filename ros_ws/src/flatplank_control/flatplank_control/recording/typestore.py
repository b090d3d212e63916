# SPDX-License-Identifier: Apache-2.0
"""Message types by name: the standard ones of Jazzy and our own, without ROS."""

from __future__ import annotations

import os
import re
from collections.abc import Iterator
from functools import lru_cache
from pathlib import Path

from rosbags.typesys import Stores, get_types_from_msg, get_typestore
from rosbags.typesys.store import Typestore

from flatplank_data.errors import RecordingError

OWN_PACKAGE = "flatplank_msgs"
_SEPARATOR = "=" * 80
_FIELD_TYPE = re.compile(r"^\s*([A-Za-z][\w/]*)(?:<=\d+)?(?:\[[^\]]*\])?\s+\w", re.MULTILINE)


def message_folder(package: str = OWN_PACKAGE) -> Path:
    """Folder of the package's .msg files: the installed one, else the one of the source tree."""
    for folder in _candidates(package):
        if any(folder.glob("*.msg")):
            return folder
    raise RecordingError(
        f"{package}: no .msg files in AMENT_PREFIX_PATH or the source tree; build or source ros_ws"
    )


def _candidates(package: str) -> Iterator[Path]:
    for prefix in filter(None, os.environ.get("AMENT_PREFIX_PATH", "").split(os.pathsep)):
        yield Path(prefix) / "share" / package / "msg"
    for parent in Path(__file__).resolve().parents:
        yield parent / package / "msg"
        yield parent / "src" / package / "msg"
        yield parent / "share" / package / "msg"


def typestore() -> Typestore:
    """Types of ROS 2 Jazzy and of `flatplank_msgs`; one store, shared."""
    return _store(message_folder())


@lru_cache(maxsize=4)
def _store(folder: Path) -> Typestore:
    store = get_typestore(Stores.ROS2_JAZZY)
    types: dict = {}
    for path in sorted(folder.glob("*.msg")):
        name = f"{folder.parent.name}/msg/{path.stem}"
        types.update(get_types_from_msg(path.read_text(encoding="utf-8"), name))
    store.register(types)
    return store


@lru_cache(maxsize=64)
def message_definition(msgtype: str) -> str:
    """Definition as rosbag2 stores it (`ros2msg`): the type, then its dependencies.

    Definitions of `flatplank_msgs` keep their comments, which state the units.
    """
    parts: list[str] = []
    seen = {_short(msgtype)}
    queue = [_short(msgtype)]
    while queue:
        short = queue.pop(0)
        text = _own_text(short)
        parts.append(text if not parts else f"{_SEPARATOR}\nMSG: {short}\n{text}")
        for dependency in _dependencies(text, short):
            if dependency not in seen:
                seen.add(dependency)
                queue.append(dependency)
    return "\n".join(parts)


def _short(msgtype: str) -> str:
    package, *_, name = msgtype.split("/")
    return f"{package}/{name}"


def _own_text(short: str) -> str:
    package, name = short.split("/")
    if package == OWN_PACKAGE:
        path = message_folder() / f"{name}.msg"
        if path.is_file():
            return path.read_text(encoding="utf-8")
    store = typestore()
    msgtype = f"{package}/msg/{name}"
    if msgtype not in store.fielddefs:
        raise RecordingError(f"{msgtype}: unknown message type; check the topic's type")
    return store.generate_msgdef(msgtype, ros_version=2)[0].split(_SEPARATOR)[0]


def _dependencies(text: str, short: str) -> list[str]:
    """Types of other messages in a definition, in order of appearance."""
    package = short.split("/")[0]
    store = typestore()
    found = []
    for name in _FIELD_TYPE.findall(text):
        full = _short(name) if "/" in name else f"{package}/{name}"
        if full.replace("/", "/msg/") in store.fielddefs:
            found.append(full)
    return found


@lru_cache(maxsize=64)
def type_hash(msgtype: str) -> str:
    """RIHS01 hash of the type description (REP 2016)."""
    store = typestore()
    if msgtype not in store.fielddefs:
        raise RecordingError(f"{msgtype}: unknown message type; check the topic's type")
    return store.hash_rihs01(msgtype)
