# SPDX-License-Identifier: Apache-2.0
"""Diagnoses of many campaigns in parallel, each written beside its campaign."""

from __future__ import annotations

import argparse
from collections.abc import Mapping, Sequence
from functools import partial
from pathlib import Path
from typing import Any

from flatplank_analysis.catalogues.rows import DIAGNOSIS
from flatplank_analysis.cli import common
from flatplank_analysis.contact_patch.session import Session
from flatplank_analysis.parallel import open_executor
from flatplank_data.errors import FlatplankError
from flatplank_data.files import write_atomic

OF_ONE = ("model", "report", "out", "start", "tir", "swept")
"""options that belong to a single campaign"""


def run(o: argparse.Namespace) -> int:
    """Diagnose all folders; 2 when none could be diagnosed."""
    for name in OF_ONE:
        if getattr(o, name, None):
            remedy = "leave it out, or name one folder"
            raise FlatplankError("belongs to one campaign", f"--{name}", remedy)
    folders = [o.folder, *o.more]
    effects, mapping = common.effect_files(o), common.read_mapping(o.mapping)
    told: list[dict[str, Any]] = []
    with open_executor(o.jobs, o.scheduler) as executor:
        for found in executor.map(partial(diagnosed, effects=effects, mapping=mapping), folders):
            told.append(found)
            if not o.json:
                print(f"{found['folder']}: {_words(found)}", flush=True)
            common.show_progress(len(told), len(folders), found["folder"])
    if o.json:
        common.print_json({"campaigns": told})
    return common.NOTHING_USABLE if all("error" in found for found in told) else 0


def diagnosed(
    folder: str, effects: Sequence[str] = (), mapping: Mapping[str, Any] | None = None
) -> dict[str, Any]:
    """Diagnose a campaign and write `diagnosis.json` into its folder; returns folder, verdict and
    names of the effects, or folder and error."""
    try:
        result = Session.open(folder, effects, mapping).diagnose().to_dict()
        write_atomic(Path(folder) / DIAGNOSIS, common.json_text(result) + "\n", durable=False)
    except (OSError, ValueError) as error:
        return {"folder": folder, "error": " ".join(str(error).split())}
    names = [effect["name"] for effect in result["effects"]]
    return {"folder": folder, "verdict": result["verdict"], "effects": names}


def _words(found: Mapping[str, Any]) -> str:
    if "error" in found:
        return str(found["error"])
    return " ".join([found["verdict"], ", ".join(found["effects"])]).strip()
