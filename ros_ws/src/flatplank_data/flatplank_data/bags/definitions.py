# SPDX-License-Identifier: Apache-2.0
"""Message types of channels; `rosbags` gives what is not `.msg` text of ROS 2.

That is: definitions in IDL, standard types of bags without definitions, and messages of ROS 1,
which `rosbags` rewrites as CDR.
"""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from functools import lru_cache
from typing import Any

from rosbags.typesys import Stores, get_types_from_idl, get_types_from_msg, get_typestore

from flatplank_data.bags.blocks import Block, Channel, blocks_of
from flatplank_data.bags.cdr import MessageType, parse_definition
from flatplank_data.errors import FlatplankError

PLAIN, ROS1, IDL = "cdr", "ros1", "ros2idl"
_SECTION = "=" * 80 + "\n"
_SAME = ("std_msgs/msg/Header", "builtin_interfaces/msg/Time", "builtin_interfaces/msg/Duration")
"""types whose text in ROS 1 differs, while `rosbags` knows how to rewrite them"""


def message_type(channel: Channel) -> MessageType:
    """The type of a channel's messages. Raises FlatplankError."""
    if channel.coding == PLAIN and channel.definition and channel.language != IDL:
        return parse_definition(channel.type, channel.definition)
    return parse_definition(channel.type, _translated(channel))


def as_cdr(block: Block) -> Iterator[Block]:
    """The messages in CDR. Raises FlatplankError for another serialisation."""
    channel = block.channel
    if channel.coding == PLAIN:
        yield block
        return
    if channel.coding != ROS1:
        what = f"messages of {channel.topic} are '{channel.coding}', not CDR"
        raise FlatplankError(what, "bag", "convert the bag with `ros2 bag convert`")
    with _one_line(channel):
        store, name = _store(channel)
        found = [bytes(store.ros1_to_cdr(data.tobytes(), name)) for data in block.payloads]
    yield from blocks_of(channel, block.log_time, found)


@contextmanager
def _one_line(channel: Channel) -> Iterator[None]:
    try:
        yield
    except Exception as error:  # its parsers raise many types of errors on a damaged text
        what = f"{channel.type or 'a type without a name'} of {channel.topic} cannot be read"
        told = f"{type(error).__name__}: {error}".split("\n", 1)[0][:200]
        raise FlatplankError(
            f"{what} ({told})", "bag", "record it with message definitions"
        ) from error


@lru_cache(maxsize=64)
def _store(channel: Channel) -> tuple[Any, str]:
    """A `rosbags` store of types that has the type of the channel, and its name there."""
    package, _, short = channel.type.rpartition("/")
    name = f"{package.removesuffix('/msg')}/msg/{short}"
    known = get_typestore(Stores.ROS2_JAZZY)
    if not channel.definition:
        return known, name
    types: dict[str, Any] = {}
    if channel.language == IDL:
        for part in channel.definition.split(_SECTION):
            types |= get_types_from_idl(part.split("\n", 1)[1] if part[:5] == "IDL: " else part)
    else:
        types |= get_types_from_msg(channel.definition, name)
    store = get_typestore(Stores.EMPTY)
    store.register({**types, **{same: known.fielddefs[same] for same in _SAME}})
    return store, name


@lru_cache(maxsize=64)
def _translated(channel: Channel) -> str:
    """The definition as `.msg` text."""
    with _one_line(channel):
        store, name = _store(channel)
        return str(store.generate_msgdef(name, ros_version=2)[0])
