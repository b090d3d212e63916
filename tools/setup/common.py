# SPDX-License-Identifier: Apache-2.0
"""What every step of the setup uses: paths, progress, stamps, quiet subprocesses."""

from __future__ import annotations

import fcntl
import hashlib
import os
import re
import subprocess
import sys
import tempfile
import threading
import time
import traceback
from collections.abc import Callable, Iterator
from concurrent.futures import ThreadPoolExecutor
from contextlib import contextmanager
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]
VENV = ROOT / ".venv"
WORKSPACE = ROOT / "ros_ws"
VALIDATION = ROOT / "validation"
"""what is not installed: its verbs are found where Python looks"""
CACHE = ROOT / ".cache"
TIMES = CACHE / "setup-times.json"
"""how long the last making of the environment took [s], for those who tell it"""
JAZZY = Path("/opt/ros/jazzy")
HAS_JAZZY = (JAZZY / "setup.bash").exists()
LOCK = ROOT / "requirements" / ("lock-jazzy.txt" if HAS_JAZZY else "lock.txt")
SYSTEM_PATH = ("/usr/local/bin", "/usr/bin", "/bin")
NO_NETWORK = (
    r"name resolution|NewConnectionError|ProxyError|Network is unreachable|Read timed out"
    r"|Connection refused|from versions: none|Max retries exceeded|dns error|error sending request"
)
PATH_LIKE = ("PATH", "PYTHONPATH", "LD_LIBRARY_PATH", "AMENT_PREFIX_PATH", "CMAKE_PREFIX_PATH")


class SetupError(Exception):
    """One line for the user: what, where, what to do."""


class NoNetworkError(SetupError):
    """The package index cannot be reached."""


def say(text: str) -> None:
    """Progress goes to stderr: stdout belongs to the verb (`--json`)."""
    print(f"flatplank: {text}", file=sys.stderr, flush=True)


def digest(*items: Path | str) -> str:
    """Hash of files (name and content) and strings."""
    total = hashlib.sha256()
    for item in items:
        total.update(str(item).encode() + b"\0")
        if isinstance(item, Path):
            total.update(item.read_bytes())
    return total.hexdigest()[:16]


class Stamp:
    """A file that says what a step was made from."""

    def __init__(self, path: Path, *made_from: Path | str) -> None:
        self.path, self.value = path, digest(*made_from)

    def fresh(self) -> bool:
        """Whether the step was finished, with what it would be made from now."""
        return self.path.exists() and self.path.read_text() == self.value

    def write(self) -> None:
        """The step is finished."""
        self.path.parent.mkdir(parents=True, exist_ok=True)
        self.path.write_text(self.value)


def run(command: list[str], log: Path, env: dict[str, str] | None = None) -> None:
    """Run quietly, output to a log file; a failure shows its last lines."""
    log.parent.mkdir(parents=True, exist_ok=True)
    with log.open("w") as out:
        code = subprocess.run(
            command, stdout=out, stderr=out, stdin=subprocess.DEVNULL, env=env, cwd=WORKSPACE
        ).returncode
    if code:
        raise failure(log)


def side_by_side(*jobs: Callable[[], object]) -> None:
    """Do all jobs to their end; then the first failure, if any, is raised."""
    with ThreadPoolExecutor(len(jobs)) as pool:
        running = [pool.submit(job) for job in jobs]
    for job in running:
        job.result()


def one_line(error: BaseException) -> str:
    """A failure in words for the user."""
    if isinstance(error, OSError) and error.strerror:
        place = f"{error.filename}: " if error.filename else ""
        return f"{place}{error.strerror}; the folder of the project must be writable, with space"
    words = " ".join(str(error).split())
    return words if isinstance(error, SetupError) else f"{type(error).__name__}: {words}"


def trace_of(error: BaseException) -> str:
    """Path of a file with the whole trace."""
    handle, path = tempfile.mkstemp(prefix="flatplank-trace-", suffix=".txt")
    with os.fdopen(handle, "w") as file:
        file.write("".join(traceback.format_exception(error)))
    return path


def failure(log: Path) -> SetupError:
    """The line of a failed step's log that says why."""
    text = log.read_text(errors="replace")
    if re.search(NO_NETWORK, text):
        return NoNetworkError(
            f"the package index cannot be reached: connect the network and start again ({log})"
        )
    lines = [line.strip() for line in text.splitlines() if line.strip()]
    errors = [line for line in lines if re.search(r"error", line, re.IGNORECASE)]
    reason = (errors or lines or ["no output"])[0][:300]
    return SetupError(f"{log.stem} failed: {reason} (all of it: {log})")


@contextmanager
def ticking(title: str, measure: Callable[[], str] | None = None) -> Iterator[None]:
    """Show a step: a line that counts on a terminal, one line at its start and end elsewhere."""
    done, start, live = threading.Event(), time.monotonic(), sys.stderr.isatty()

    def tick() -> None:
        while not done.wait(0.5):
            note = f" {measure()}" if measure else ""
            seconds = f"{time.monotonic() - start:.0f} s "
            print(f"\rflatplank: {title}{note} ... {seconds}", end="", file=sys.stderr)

    if not live:
        say(f"{title} ...")
    thread = threading.Thread(target=tick, daemon=True)
    if live:
        thread.start()
    try:
        yield
    finally:
        done.set()
        if live:
            thread.join()
            print("\r\033[K", end="", file=sys.stderr)
    say(f"{title}: done, {time.monotonic() - start:.0f} s")


@contextmanager
def only_one() -> Iterator[None]:
    """Two starts at once must not build into the same folders."""
    CACHE.mkdir(exist_ok=True)
    with (CACHE / "setup.lock").open("w") as lock:
        try:
            fcntl.flock(lock, fcntl.LOCK_EX | fcntl.LOCK_NB)
        except BlockingIOError:
            say("another start is setting up; waiting for it")
            fcntl.flock(lock, fcntl.LOCK_EX)
        yield
