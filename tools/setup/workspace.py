# SPDX-License-Identifier: Apache-2.0
"""The ROS workspace: variables of the underlay, stamps per package, colcon."""

from __future__ import annotations

import os
import shlex
import shutil
import subprocess
import threading
from pathlib import Path

from common import (
    CACHE,
    HAS_JAZZY,
    JAZZY,
    LOCK,
    ROOT,
    SYSTEM_PATH,
    VENV,
    WORKSPACE,
    SetupError,
    Stamp,
    run,
    say,
)
from system import missing_for_build
from virtual import site_packages

MESSAGES = "flatplank_msgs"
READ_BY_BUILD = ("*.xml", "*.txt", "setup.*", "msg/*.msg", "srv/*.srv", "action/*.action")
LINKED = ("launch/**/*", "config/**/*")
COLCON_NOTES = {
    "build": (".built_by", "colcon\n"),
    "install": (".colcon_install_layout", "isolated\n"),
}
"""folder -> file and text of the note that colcon writes there: who builds, and that every package
has a folder of its own"""
CMAKE_ARGUMENTS = ("-DBUILD_TESTING=OFF", "--no-warn-unused-cli")
if not HAS_JAZZY:
    CMAKE_ARGUMENTS += ("-DFLATPLANK_PYTHON_ONLY=ON",)  # no C++ program can use the wheels
QUICKLY = {
    "PYTHONWARNINGS": "ignore",
    # colcon's own would build one file at a time while the computer is busy
    "MAKEFLAGS": f"-j{len(os.sched_getaffinity(0))}",
}


def ros_setup() -> dict[str, str]:
    """Variables of the underlay: what colcon and the nodes need before our own packages."""
    path = ":".join([f"{VENV}/bin", *SYSTEM_PATH])
    if HAS_JAZZY:
        return sourced(JAZZY / "setup.bash", {"VIRTUAL_ENV": str(VENV), "PATH": path})
    libraries = [VENV / "lib", *sorted(site_packages().glob("ros_*.libs"))]
    return {
        "PATH": path,
        "VIRTUAL_ENV": str(VENV),
        "AMENT_PREFIX_PATH": str(VENV),
        "CMAKE_PREFIX_PATH": str(VENV),
        "LD_LIBRARY_PATH": ":".join(map(str, libraries)),
        "ROS_DISTRO": "jazzy",
        "ROS_VERSION": "2",
        "ROS_PYTHON_VERSION": "3",
        # else the wheels' start-up hook starts Python again to set LD_LIBRARY_PATH
        "_ROS_WHEELS_BOOTSTRAP_COMPLETE": "1",
    }


def sourced(script: Path, env: dict[str, str]) -> dict[str, str]:
    """What `env` becomes after sourcing a script in a bash that has nothing else."""
    command = ["bash", "--norc", "-c", f". {shlex.quote(str(script))} >&2 && env -0"]
    got = subprocess.run(command, env=env, capture_output=True, cwd=ROOT)
    if got.returncode:
        reason = got.stderr.decode(errors="replace").strip()[-300:]
        raise SetupError(f"{script} cannot be sourced: {reason}")
    pairs = (item.split("=", 1) for item in got.stdout.decode().split("\0") if "=" in item)
    return {key: value for key, value in pairs if key not in ("PWD", "SHLVL", "_", "OLDPWD")}


def toolchain() -> str:
    """The part of the lock that a build depends on; other packages do not matter to it."""
    names = ("ros-", "numpy=", "colcon-", "setuptools=", "empy=")
    lines = (line.removesuffix(" \\") for line in LOCK.read_text().splitlines())
    return "\n".join(line for line in lines if line.startswith(names))


def package_stamps() -> dict[str, Stamp]:
    """One stamp per package, over what a build reads (edits of Python code are live without)."""
    stamps = {}
    for package in sorted(WORKSPACE.glob("src/*/package.xml")):
        folder, name = package.parent, package.parent.name
        read = [file for pattern in READ_BY_BUILD for file in sorted(folder.glob(pattern))]
        linked = [str(file) for pattern in LINKED for file in sorted(folder.glob(pattern))]
        stamp = WORKSPACE / "install" / name / "flatplank.stamp"
        stamps[name] = Stamp(stamp, *read, *linked, toolchain())
    return stamps


def without_compiler(stale: list[str]) -> list[str]:
    """The stale packages that can be built here."""
    lacking = missing_for_build() if MESSAGES in stale else []
    if not lacking:
        return stale
    say(f"no {', '.join(lacking)}: {MESSAGES} is not built, so no ROS graph; the rest works")
    return [name for name in stale if name != MESSAGES]


def build(packages: list[str]) -> None:
    """Build packages of the workspace; the messages by themselves, since they take longest."""
    if not packages:
        return
    label = "messages" if packages == [MESSAGES] else "packages"
    unfinished = WORKSPACE / "build" / f"flatplank-{label}.unfinished"
    forget_interrupted(unfinished)
    unfinished.parent.mkdir(exist_ok=True)
    unfinished.write_text("\n".join(packages))
    for folder, (name, text) in COLCON_NOTES.items():
        note_before_colcon(WORKSPACE / folder / name, text)
    python = str(VENV / "bin" / "python")
    command = [python, "-m", "colcon", "--log-base", str(CACHE / f"colcon-{label}"), "build"]
    command += ["--symlink-install", "--packages-select", *packages]
    # else these would wait for the files of the messages
    command += [] if MESSAGES in packages else ["--packages-ignore", MESSAGES]
    command += ["--cmake-args", f"-DPython3_EXECUTABLE={python}", *CMAKE_ARGUMENTS]
    env = os.environ | ros_setup() | QUICKLY
    try:
        run(command, CACHE / f"colcon-{label}.log", env)
    except SetupError:
        unfinished.unlink()  # an error of the sources leaves whole files behind
        raise
    unfinished.unlink()
    for name in packages:
        package_stamps()[name].write()


def note_before_colcon(note: Path, text: str) -> None:
    """Write a note of colcon on a folder before colcon does, in one step. Of two builds side by
    side one opens such a note and then writes it; the other one would read it empty and refuse
    the folder."""
    if note.exists() and note.read_text():
        return
    note.parent.mkdir(exist_ok=True)
    written = note.with_name(f"{note.name}-{threading.get_ident()}")
    written.write_text(text)
    written.replace(note)


def forget_interrupted(unfinished: Path) -> None:
    """A killed build leaves cut-off files that make takes for finished: build these again."""
    if unfinished.exists():
        for name in unfinished.read_text().split():
            for folder in (WORKSPACE / "build" / name, WORKSPACE / "install" / name):
                shutil.rmtree(folder, ignore_errors=True)
