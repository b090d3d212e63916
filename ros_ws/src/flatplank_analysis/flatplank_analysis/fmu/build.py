# SPDX-License-Identifier: Apache-2.0
"""Writes an FMU: sources, and a binary for this machine where a C compiler is there."""

from __future__ import annotations

import io
import os
import platform
import shutil
import subprocess
import sys
import tempfile
import zipfile
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path

from flatplank_analysis.fmu.files import IDENTIFIER, files_of
from flatplank_data.errors import FlatplankError
from flatplank_data.files import write_atomic
from flatplank_tire.tir import TirFile

COMPILERS = ("cc", "gcc", "clang")
"""tried in this order after the one that the environment variable CC names"""
NO_COMPILER = (
    f"no C compiler ({', '.join(COMPILERS)}); install one (Debian, Ubuntu: sudo apt-get install "
    "gcc) and write the FMU again"
)
OPTIONS = ("-std=c99", "-O2", "-ffp-contract=off", "-fPIC", "-shared", "-fvisibility=hidden")
SYSTEMS = {"linux": ("linux", ".so"), "darwin": ("darwin", ".dylib"), "win32": ("windows", ".dll")}
PROCESSORS = {"x86_64": "x86_64", "amd64": "x86_64", "aarch64": "aarch64", "arm64": "aarch64"}
EPOCH = (1980, 1, 1, 0, 0, 0)
"""date of the files in the archive: equal tires give equal bytes"""


@dataclass(frozen=True)
class Written:
    """What an FMU has."""

    files: Mapping[str, bytes]
    binary: str
    """platform of the binary, as x86_64-linux; empty without one"""
    lack: str = ""
    """why there is no binary, and what to do"""


def write_fmu(tir: TirFile, law: str, path: str | os.PathLike[str]) -> Written:
    """Write the FMU of a tire file.

    Raises FlatplankError for a coefficient that is missing, and for a compiler that fails.
    """
    name = Path(tir.path or path).stem
    texts = files_of(tir, law, name)
    files = {place: text.encode() for place, text in texts.items()}
    platform_name, suffix = this_platform()
    compiler = compiler_here()
    lack = "" if compiler else NO_COMPILER
    lack = lack if platform_name else f"FMI 3.0 has no name for {platform.machine()} here"
    if not lack:
        place = f"binaries/{platform_name}/{IDENTIFIER}{suffix}"
        files[place] = _compiled(compiler, files, suffix)
    write_atomic(path, _archive(files))
    return Written(files, "" if lack else platform_name, lack)


def compiler_here() -> str:
    """Path of a C compiler; empty without one."""
    tried = (os.environ.get("CC", ""), *COMPILERS)
    return next((found for name in tried if name and (found := shutil.which(name))), "")


def this_platform() -> tuple[str, str]:
    """Name of this platform in FMI 3.0 and suffix of its binaries; empty where it has no name."""
    processor = PROCESSORS.get(platform.machine().lower(), "")
    system, suffix = SYSTEMS.get(sys.platform, ("", ""))
    return (f"{processor}-{system}", suffix) if processor and system else ("", "")


def _compiled(compiler: str, files: Mapping[str, bytes], suffix: str) -> bytes:
    with tempfile.TemporaryDirectory() as folder:
        sources = [p for p in files if p.startswith("sources/") and p[-2:] in (".c", ".h")]
        for place in sources:
            Path(folder, Path(place).name).write_bytes(files[place])
        made = f"{IDENTIFIER}{suffix}"
        command = [compiler, *OPTIONS, "fmi3.c", "tire.c", "-o", made, "-lm"]
        told = subprocess.run(command, cwd=folder, capture_output=True, text=True)
        if told.returncode:
            said = (told.stderr.strip().splitlines() or ["no message"])[0]
            raise FlatplankError(
                f"{said}", compiler, "name another compiler in the environment variable CC"
            )
        return Path(folder, made).read_bytes()


def _archive(files: Mapping[str, bytes]) -> bytes:
    buffer = io.BytesIO()
    with zipfile.ZipFile(buffer, "w", zipfile.ZIP_DEFLATED) as archive:
        for place, content in files.items():
            archive.writestr(zipfile.ZipInfo(place, EPOCH), content, zipfile.ZIP_DEFLATED)
    return buffer.getvalue()
