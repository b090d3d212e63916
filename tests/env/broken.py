# SPDX-License-Identifier: Apache-2.0
"""Runs verbs in broken environments, each in a fork of a process that has loaded all but ROS.

`broken.py FOLDER`: reads [[verb, arguments, environment], ...] as JSON from stdin and prints
[[exit code, stderr], ...]; an exit code of None: it had to be ended.
"""

from __future__ import annotations

import json
import os
import resource
import signal
import sys
import time
from collections.abc import Callable
from pathlib import Path

from flatplank_analysis.cli.main import main
from flatplank_analysis.cli.verbs import installed

TIMEOUT_S = 500.0
"""a verb that waits for nodes in vain gives up after a minute; a loaded machine takes longer"""


def no_ros(_folder: Path) -> None:
    """rclpy and the messages are not there."""
    sys.modules["rclpy"] = None  # type: ignore[assignment]
    sys.modules["flatplank_msgs"] = None  # type: ignore[assignment]


def read_only(_folder: Path) -> None:
    """The working folder takes nothing, not even from root."""
    os.chdir("/proc")


def full_disk(_folder: Path) -> None:
    """No file takes a byte, and stdout leads to a full device."""
    resource.setrlimit(resource.RLIMIT_FSIZE, (0, 0))
    os.dup2(os.open("/dev/full", os.O_WRONLY), 1)


BREAK: dict[str, Callable[[Path], None]] = {
    "no ros": no_ros,
    "read only": read_only,
    "full disk": full_disk,
}


def run(verb: str, arguments: list[str], broken: str, folder: Path) -> tuple[int | None, str]:
    """Exit code and stderr of one verb."""
    pipe, end = os.pipe()
    child = os.fork()
    if child == 0:
        os.setsid()
        os.dup2(end, 2)
        os.dup2(os.open(os.devnull, os.O_RDWR), 1)
        os.chdir(folder)
        BREAK[broken](folder)
        try:
            code = main([verb, *arguments])
        except SystemExit as ended:
            code = ended.code if isinstance(ended.code, int) else 1
        try:
            sys.stdout.flush()
        except OSError:
            print("stdout could not be flushed", file=sys.stderr)
        os._exit(code)
    os.close(end)
    code = wait(child)
    with os.fdopen(pipe, "rb") as stream:
        os.set_blocking(stream.fileno(), False)
        text = (stream.read() or b"").decode()
    return code, text


def wait(child: int) -> int | None:
    """Exit code of a child, None when it had to be ended with all its own."""
    end = time.monotonic() + TIMEOUT_S
    while time.monotonic() < end:
        done, status = os.waitpid(child, os.WNOHANG)
        if done:
            return os.waitstatus_to_exitcode(status)
        time.sleep(0.02)
    os.killpg(child, signal.SIGKILL)
    os.waitpid(child, 0)
    return None


if __name__ == "__main__":
    for entry in installed().values():
        entry.load()
    assert "rclpy" not in sys.modules, "it could not be broken any more"
    where = Path(sys.argv[1])
    print(json.dumps([run(*case, where) for case in json.load(sys.stdin)]))
