# SPDX-License-Identifier: Apache-2.0
"""A recorder that logs its first line and opens its first bag once it is up; prints as JSON what
was looked up, read or compiled only then."""

from __future__ import annotations

import inspect
import json
import sys

from flatplank_control.nodes import recorder
from flatplank_control.recording import typestore
from flatplank_control.runner.provenance import software_version
from flatplank_hw.nodes import running
from flatplank_msgs.srv import StartRecording

CACHED = (typestore.message_definition, typestore.type_hash, typestore._store, software_version)


def known() -> set[str]:
    """Modules that are imported, and looked through for callers; what was computed once."""
    computed = {f"{f.__name__} {n}" for f in CACHED for n in range(f.cache_info().misses)}
    return {*sys.modules, *inspect.modulesbyfile, *computed}


class FirstBag(recorder.RecorderNode):
    """Records at its first tick, and ends."""

    ended = False
    when_up: set[str]

    def poll(self) -> None:
        recorder.INTRODUCTION = 0.0  # no other node is waited for
        self.get_logger().info("first line")
        request = StartRecording.Request(name="first", record="tire: T", at_once=True)
        try:
            self.on_start(request, StartRecording.Response()).send(None)
        except StopIteration as done:
            assert done.value.accepted, done.value
        print(json.dumps(sorted(known() - self.when_up)), flush=True)
        self.ended = True


def note_up() -> None:
    FirstBag.when_up = known()


if __name__ == "__main__":
    running.report_started = note_up
    raise SystemExit(running.run_nodes([lambda: FirstBag("recorder")], sys.argv, local=True))
