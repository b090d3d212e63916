# SPDX-License-Identifier: Apache-2.0
"""The virtual environment .venv, from the sections of the lock."""

from __future__ import annotations

import ast
import os
import re
import shutil
import subprocess
import sys
import sysconfig
from collections.abc import Iterable
from pathlib import Path

from common import (
    CACHE,
    HAS_JAZZY,
    LOCK,
    ROOT,
    VENV,
    WORKSPACE,
    NoNetworkError,
    SetupError,
    Stamp,
    run,
    say,
)
from system import install_system_packages

PIP_OPTIONS = ["--no-deps", "--no-compile", "--progress-bar", "off", "--disable-pip-version-check"]
PIP_ENV = os.environ | {"_ROS_WHEELS_BOOTSTRAP_COMPLETE": "1"}
FIRST = ("workspace", "main")
"""sections that every verb needs: what builds the workspace, and what it runs on"""

MORE = {"panel": ("panel",), "test": ("panel", "test"), "bench-speed": ("panel", "test")}
"""verb -> sections that it needs on top"""

PIP_TO_UV = {
    "index-url": "UV_DEFAULT_INDEX",
    "extra-index-url": "UV_INDEX",
    "find-links": "UV_FIND_LINKS",
    "cert": "SSL_CERT_FILE",
    "timeout": "UV_HTTP_TIMEOUT",
    "default-timeout": "UV_HTTP_TIMEOUT",
    "trusted-host": "UV_INSECURE_HOST",
}
"""what a user has set for pip holds for uv, too"""


def site_packages() -> Path:
    """Where .venv keeps its packages."""
    found = sorted((VENV / "lib").glob("python3.*/site-packages"))
    if not found:
        raise SetupError(f"{VENV} has no site-packages: remove it and start again")
    return found[0]


def python_version() -> str:
    """The Python that .venv is made for, as the lock's markers name it."""
    return f"{sys.version_info.major}.{sys.version_info.minor}"


def locked(section: str) -> dict[str, list[str]]:
    """`name==version` of a section for this Python, with the hashes of its files."""
    here, found, inside = python_version(), {}, False
    for line in LOCK.read_text().replace("\\\n", "").splitlines():
        pinned, *hashes = line.split(" --hash=")
        wanted, _, marker = (part.strip() for part in pinned.partition(";"))
        if line.startswith("#"):
            inside = line.startswith(f"# {section}:")
        elif inside and (not marker or f'"{here}"' in marker):
            found[wanted] = [text.strip() for text in hashes]
    return found


def installed_of(wanted: Iterable[str]) -> int:
    """How many of these `name==version` are in .venv."""

    def plain(text: str) -> str:
        return re.sub(r"[-_.]+", "-", text).lower()

    there = {plain(path.stem) for path in site_packages().glob("*.dist-info")}
    return sum(plain(text.replace("==", "-")) in there for text in wanted)


def requirements(packages: dict[str, list[str]], name: str) -> list[str]:
    """Options of pip and uv: these packages, and no file whose hash is not in the lock."""
    file = CACHE / f"{name}.txt"
    lines = [f"{p} {' '.join(f'--hash={h}' for h in hashes)}" for p, hashes in packages.items()]
    file.write_text("\n".join(lines) + "\n")
    return ["--require-hashes", "-r", str(file)]


def venv_stamp() -> Stamp:
    """Of the environment itself: another folder or another Python want another."""
    return Stamp(VENV / "flatplank.begun", str(ROOT), str(HAS_JAZZY), python_version())


def section_stamp(section: str) -> Stamp:
    return Stamp(VENV / f"flatplank-{section}.stamp", *locked(section))


def make_venv() -> None:
    """An empty .venv with uv, which then brings the packages; nothing when it is there."""
    stamp, pip = venv_stamp(), [str(VENV / "bin" / "python"), "-I", "-m", "pip"]
    asked = subprocess.run([*pip, "--version"], env=PIP_ENV, capture_output=True) \
        if stamp.fresh() else None  # fmt: skip
    if asked is None or asked.returncode:
        create_venv()
        stamp.write()
    forget_half_installed()


def create_venv() -> None:
    """An empty .venv; what was built with an earlier one carries its paths, so it goes too."""
    for old in (VENV, WORKSPACE / "build", WORKSPACE / "install", WORKSPACE / "log"):
        if old.is_symlink():
            old.unlink()  # what it leads to is somebody else's
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
    run(command, CACHE / "venv.log")


def install(section: str) -> None:
    """The packages of a section that are not there, by uv; by pip where uv cannot."""
    wanted = requirements(locked(section), section)
    python = str(VENV / "bin" / "python")
    pip = [python, "-I", "-m", "pip", "install", *PIP_OPTIONS]
    try:
        if not (VENV / "bin" / "uv").exists():
            uv = {p: h for p, h in locked("workspace").items() if p.startswith("uv==")}
            run([*pip, *requirements(uv, "uv")], CACHE / "pip-uv.log", PIP_ENV)
        command = [str(VENV / "bin" / "uv"), "pip", "install", "--python", python, "--no-deps"]
        # of the first sections warm.py compiles what is used, which is less
        command += [] if section in FIRST else ["--compile-bytecode"]
        run([*command, "--quiet", *wanted], CACHE / f"uv-{section}.log", uv_env())
    except NoNetworkError:
        raise
    except SetupError as error:
        say(f"{error}; trying with pip")
        run([*pip, *wanted], CACHE / f"pip-{section}.log", PIP_ENV)
    if section == "workspace" and not HAS_JAZZY:
        repair_wheel_paths(site_packages())
    section_stamp(section).write()


def uv_env() -> dict[str, str]:
    """Variables that tell uv what pip's configuration tells pip."""
    command = [str(VENV / "bin" / "python"), "-I", "-m", "pip", "config", "list"]
    said = subprocess.run(command, env=PIP_ENV, capture_output=True, text=True).stdout
    # as pip does: of all indexes the one that has the version
    env = PIP_ENV | {"UV_INDEX_STRATEGY": "unsafe-best-match", "UV_NO_CONFIG": "1"}
    for line in said.splitlines():
        key, _, value = line.partition("=")
        name = PIP_TO_UV.get(key.rpartition(".")[2])
        if name and value:
            env.setdefault(name, " ".join(str(ast.literal_eval(value)).split()))
    return env


def forget_half_installed() -> None:
    """A package that an interruption left without its RECORD looks installed: it is not."""
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
            file.unlink()  # uv links it to its cache, where it must stay as it is
            file.write_text(mended)
