# SPDX-License-Identifier: Apache-2.0
"""The virtual environment .venv, from the lock."""

from __future__ import annotations

import os
import re
import shutil
import subprocess
import sys
import sysconfig
from pathlib import Path

from common import CACHE, HAS_JAZZY, LOCK, ROOT, VENV, WORKSPACE, SetupError, Stamp, run, ticking
from system import install_system_packages

PIP_OPTIONS = ["--no-deps", "--no-compile", "--progress-bar", "off", "--disable-pip-version-check"]


def site_packages() -> Path:
    """Where .venv keeps its packages."""
    found = sorted((VENV / "lib").glob("python3.*/site-packages"))
    if not found:
        raise SetupError(f"{VENV} has no site-packages: remove it and start again")
    return found[0]


def venv_stamp() -> Stamp:
    return Stamp(VENV / "flatplank.stamp", LOCK, str(ROOT), str(HAS_JAZZY), python_version())


def python_version() -> str:
    """The Python that .venv is made for, as the lock's markers name it."""
    return f"{sys.version_info.major}.{sys.version_info.minor}"


def wanted_packages() -> int:
    here = python_version()
    lines = [line for line in LOCK.read_text().splitlines() if line and not line.startswith("#")]
    return sum(";" not in line or f'"{here}"' in line for line in lines)


def make_venv() -> None:
    """Create .venv and fill it from the lock; picks up where an interrupted start left it."""
    pip = [str(VENV / "bin" / "python"), "-I", "-m", "pip"]
    env = os.environ | {"_ROS_WHEELS_BOOTSTRAP_COMPLETE": "1"}
    begun = Stamp(VENV / "flatplank.begun", str(ROOT), str(HAS_JAZZY), python_version())
    asked = [*pip, "--version"]
    if not begun.fresh() or subprocess.run(asked, env=env, capture_output=True).returncode:
        create_venv()
        begun.write()
    forget_half_installed()
    site, total = site_packages(), wanted_packages()
    count = f"step 2 of 3, {total} Python packages"
    with ticking(count, lambda: f"({len(list(site.glob('*.dist-info')))} there)"):
        run([*pip, "install", *PIP_OPTIONS, "-r", str(LOCK)], CACHE / "pip.log", env)
    if not HAS_JAZZY:
        repair_wheel_paths(site)


def create_venv() -> None:
    """An empty .venv; what was built with an earlier one carries its paths, so it goes too."""
    for old in (VENV, WORKSPACE / "build", WORKSPACE / "install", WORKSPACE / "log"):
        shutil.rmtree(old, ignore_errors=True)
    base = os.path.realpath(sys.executable)
    command = [base, "-I", "-m", "venv", str(VENV)]
    command += ["--system-site-packages"] if HAS_JAZZY else []
    if subprocess.run([base, "-I", "-c", "import ensurepip"], capture_output=True).returncode:
        version = f"python{python_version()}-venv"
        if not install_system_packages([version]):
            raise SetupError(
                f"{base} makes no virtual environments: install {version}, start again"
            )
    with ticking("step 1 of 3, virtual environment .venv"):
        run(command, CACHE / "venv.log")


def forget_half_installed() -> None:
    """A package that an interruption left without its RECORD looks installed to pip: it is not."""
    for info in site_packages().glob("*.dist-info"):
        if not (info / "RECORD").exists():
            shutil.rmtree(info)


def repair_wheel_paths(site: Path) -> None:
    """The wheels' exported cmake files carry the paths of the machine that built them."""
    include = sysconfig.get_path("include")
    built_at = r"/opt/python/[^/]+/(lib/)?"
    for file in (VENV / "share").rglob("*.cmake"):
        text = file.read_text()
        mended = re.sub(built_at + r"python[\d.]+/site-packages", str(site), text)
        mended = re.sub(built_at + r"include/python[\d.]+", include, mended)
        if mended != text:
            file.write_text(mended)
