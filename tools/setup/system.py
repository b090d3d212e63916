# SPDX-License-Identifier: Apache-2.0
"""Programs that come with the system: what is missing, and apt when we may."""

from __future__ import annotations

import os
import shutil
import sys
import sysconfig
from pathlib import Path

from common import CACHE, ROOT, SetupError, run, say, ticking

PYTHON = f"python{sys.version_info.major}.{sys.version_info.minor}"
BUILD_PROGRAMS = {"cc": "gcc", "c++": "g++", "make": "make", "cmake": "cmake"}
OTHER_PROGRAMS = {"ip": "iproute2"}

BROWSER_TESTS = ROOT / "tests" / "panel"


def there(program: str) -> bool:
    """On PATH, or in /sbin, where some keep `ip`."""
    return bool(shutil.which(program, path=os.environ.get("PATH", "") + ":/usr/sbin:/sbin"))


def missing_for_build() -> list[str]:
    """Packages without which the messages cannot be compiled."""
    lacking = [package for program, package in BUILD_PROGRAMS.items() if not there(program)]
    header = Path(sysconfig.get_path("include"), "Python.h")
    return lacking if header.exists() else [*lacking, f"{PYTHON}-dev"]


def missing_packages() -> list[str]:
    """System packages that the project uses and that are not there."""
    lacking = [package for program, package in OTHER_PROGRAMS.items() if not there(program)]
    return missing_for_build() + lacking


def make_ready_for(verb: str) -> None:
    """What one verb needs on top: a browser for the tests that click."""
    if verb == "test" and BROWSER_TESTS.exists() and not there("chromium"):
        install_system_packages(["chromium"])


def install_system_packages(packages: list[str]) -> bool:
    """With apt when we are root, else say the one command. True when they are there now."""
    command = ["apt-get", "install", "--yes", "--no-install-recommends", *packages]
    if os.geteuid() != 0 or not shutil.which("apt-get"):
        remedy = f"sudo apt-get install {' '.join(packages)}"
        say(f"not there: {', '.join(packages)}. To install: {remedy}")
        return False
    env = os.environ | {"DEBIAN_FRONTEND": "noninteractive"}
    with ticking(f"system packages {' '.join(packages)}"):
        try:
            run(["apt-get", "update"], CACHE / "apt-update.log", env)
            run(command, CACHE / "apt.log", env)
        except SetupError as error:
            say(f"{error}; going on without {', '.join(packages)}")
            return False
    return True
