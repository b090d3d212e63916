# SPDX-License-Identifier: Apache-2.0
"""The run record as a message on `/run`."""

from __future__ import annotations

from flatplank_control.recording.bag_writer import TopicSpec
from flatplank_control.recording.qos import LATCHED
from flatplank_control.recording.typestore import typestore
from flatplank_data.run_record import RunRecord

TOPIC = TopicSpec("/run", "flatplank_msgs/msg/Run", LATCHED)


def run_message(record: RunRecord, stamp_ns: int) -> bytes:
    """Serialised flatplank_msgs/Run; `stamp_ns` is the time of the bench [ns]."""
    store = typestore()
    make = store.types
    stamp = make["builtin_interfaces/msg/Time"](*divmod(stamp_ns, 1_000_000_000))
    message = make[TOPIC.type](
        header=make["std_msgs/msg/Header"](stamp, ""),
        uuid=record.uuid,
        name=record.name,
        status=record.status,
        record=record.to_yaml(),
    )
    return bytes(store.serialize_cdr(message, TOPIC.type))
