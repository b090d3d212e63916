# SPDX-License-Identifier: Apache-2.0
"""Collects facts that users, files and other programs rely on: names, formats, samples and
verdicts."""

from __future__ import annotations

import argparse
import contextlib
import hashlib
import io
import json
import re
import shutil
import tempfile
from collections.abc import Callable, Iterable, Mapping
from pathlib import Path
from typing import Any

import numpy as np

import flatplank_analysis as fp
from flatplank_analysis.cli.verbs import installed
from flatplank_analysis.discovery.parameters import parameters_of
from flatplank_analysis.effects.registry import library
from flatplank_control.bench.setup import BenchSetup
from flatplank_control.recording.topics import RECORDED
from flatplank_control.recording.typestore import message_folder
from flatplank_control.runner.measurement import Measurement
from flatplank_control.runner.plans import plan_of
from flatplank_data.campaign import Campaign, Run
from flatplank_data.run_record import RunRecord
from flatplank_sim.twin.log import BagLog
from flatplank_sim.twin.twin import Twin
from flatplank_sim.twin.twin_bench import TwinBench
from flatplank_validation.blind import journal
from flatplank_validation.blind.detectable import cache
from flatplank_validation.blind.lists import full

ROOT = Path(__file__).resolve().parents[3]
OLD_FILES = ROOT / "tests" / "formats"
SEED = 20262
"""seed of the campaigns with known answers"""
OPTION = re.compile(r"--[a-z][\w-]*")
FORMAT = re.compile(r"\"(flatplank-[a-z-]+/\d+)\"")
COMMENT = re.compile(r"#.*")
ITS_OWN = ("uuid", "software_version", "format", "name")
"""keys that differ between any two runs or versions, and the name, which is that of the file"""
NOTHING: tuple[Any, ...] = ("", [], {}, None)

Facts = dict[str, Any]


def verbs_and_options(_: argparse.Namespace) -> Facts:
    """verb -> its options; `test` passes them to pytest."""
    own = {name: entry for name, entry in installed().items() if name != "test"}
    return {name: _options(entry.load()) for name, entry in own.items()}


def _options(main: Callable[[list[str]], Any]) -> list[str]:
    said = io.StringIO()
    with contextlib.redirect_stdout(said), contextlib.suppress(SystemExit):
        main(["--help"])
    return sorted(set(OPTION.findall(said.getvalue())))


def messages(_: argparse.Namespace) -> Facts:
    """Message, service or action -> its fields without comments."""
    folder = message_folder().parent
    files = (f for kind in ("msg", "srv", "action") for f in folder.glob(f"{kind}/*.{kind}"))
    return {f.name: COMMENT.sub("", f.read_text(encoding="utf-8")).split() for f in sorted(files)}


def topics(_: argparse.Namespace) -> Facts:
    """Recorded topic -> its type."""
    return {spec.name: spec.type for spec in RECORDED}


def effects(_: argparse.Namespace) -> Facts:
    """Identifier in `model.yaml` -> its parameters."""
    known = library().items()
    return {name: sorted(p.name for p in parameters_of(effect)) for name, effect in known}


def formats(_: argparse.Namespace) -> Facts:
    """Format name and version at the start of each kind of file."""
    files = (ROOT / "ros_ws" / "src").glob("flatplank_*/flatplank_*/**/*.py")
    found = (name for f in files for name in FORMAT.findall(f.read_text(encoding="utf-8")))
    return dict.fromkeys(sorted(set(found)), "known")


def old_files(_: argparse.Namespace) -> Facts:
    """Run of a campaign by an older version -> its record and samples."""
    out: Facts = {}
    for folder in OLD_FILES.glob("*/campaign"):
        with tempfile.TemporaryDirectory() as copy:  # readers write caches beside the files
            shutil.copytree(folder, copy, dirs_exist_ok=True)
            runs = samples(Campaign.load(copy).runs)
            out |= {f"{folder.parent.name} {file}": how for file, how in runs}
    return out


def samples(runs: Iterable[Run]) -> Iterable[tuple[str, Facts]]:
    """File -> record, and a digest of each column."""
    for run in runs:
        table = run.table()
        digests = {name: _digest(table[name]) for name in sorted(table.columns)}
        yield run.info.file, {"record": _plain(run.info), "columns": digests}


def _plain(record: RunRecord) -> Facts:
    """Keys of the record that have a value."""
    own = {k: v for k, v in record.to_dict().items() if k not in ITS_OWN and v not in NOTHING}
    return json.loads(json.dumps(own, default=str))


def _digest(values: np.ndarray) -> str:
    return hashlib.sha256(np.ascontiguousarray(values).tobytes()).hexdigest()[:16]


def twin(_: argparse.Namespace) -> Facts:
    """A short slip step and free rolling on the twin; a test checks that graph and twin agree bit
    for bit."""
    out: Facts = {}
    for kind in ("slip", "free_rolling"):
        measurement = Measurement(
            measurement=kind, kappa=-0.05, step_position=0.2, end_position=0.6
        )
        with tempfile.TemporaryDirectory() as folder:
            bench = TwinBench(Twin(BenchSetup(pace="hold", seed=5)), BagLog(Path(folder)))
            bench.perform(plan_of(measurement))
            out |= samples(Campaign.load(folder).runs)
    return out


def diagnosis(o: argparse.Namespace) -> Facts:
    """Campaign with a known answer -> verdict, and the size of each effect."""
    cases = full(SEED)[: o.campaigns]
    path = cache() / f"seed{SEED}.jsonl"
    entries = journal.run(cases, SEED, path, o.jobs)
    out = {e["key"]: _verdict(e["diagnosis"]) for e in entries if e["diagnosis"]}
    found = {folder.name: fp.diagnose(fp.load(folder)).to_dict() for folder in o.folder}
    return out | {name: _verdict(result) for name, result in found.items()}


def _verdict(found: Mapping[str, Any]) -> Facts:
    sizes = {e["name"]: e["size"] for e in found["effects"]}
    return {"verdict": found["verdict"], "effects": sizes}


PARTS: dict[str, Callable[[argparse.Namespace], Facts]] = {
    "verbs": verbs_and_options,
    "messages": messages,
    "topics": topics,
    "effects": effects,
    "formats": formats,
    "files": old_files,
    "twin": twin,
    "diagnosis": diagnosis,
}
