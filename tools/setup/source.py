# SPDX-License-Identifier: Apache-2.0
"""What is answered from the source, before anything is installed: help, version, doctor, and a
verb that is none.
"""

from __future__ import annotations

import configparser
import os
import sys
from importlib.metadata import EntryPoint

from common import ROOT, VALIDATION, WORKSPACE

WITHOUT_SETUP = ("help", "-h", "--help", "--version", "doctor")
VERBS = "flatplank.verbs."
OWN = ("env",)
"""verbs of the set-up itself"""


def declared() -> tuple[dict[str, EntryPoint], str]:
    """Verbs that the packages of the checkout declare, and their version."""
    found, version = {}, ""
    files = [*sorted(WORKSPACE.glob("src/*/setup.cfg")), *VALIDATION.glob("*/entry_points.txt")]
    for path in files:
        file = configparser.ConfigParser()
        file.read(path, encoding="utf-8")
        version = file.get("metadata", "version", fallback=version)
        groups = {name: dict(file[name]) for name in file.sections()}
        for group, lines in groups.pop("options.entry_points", {}).items():
            groups[group] = dict(line.split(" = ") for line in lines.strip().splitlines())
        for group, entries in groups.items():
            if group.startswith(VERBS):
                found |= {name: EntryPoint(name, at, group) for name, at in entries.items()}
    return dict(sorted(found.items())), version


def needs_no_setup(argv: list[str]) -> bool:
    """Whether a command is answered from the source."""
    verb, *words = argv or ["help"]
    asked = bool(words) and words[0] in ("-h", "--help")
    return verb in WITHOUT_SETUP or asked or verb not in {*declared()[0], *OWN}


def run_from_source(argv: list[str]) -> int:
    """Run the command as the installed one does, with what the source declares."""
    os.environ.setdefault("FLATPLANK_ROOT", str(ROOT))
    sys.dont_write_bytecode = True
    sys.path[:0] = [str(path.parent) for path in WORKSPACE.glob("src/*/setup.cfg")]
    sys.path.append(str(VALIDATION))
    from flatplank_analysis.cli.main import main

    return main(argv, *declared())
