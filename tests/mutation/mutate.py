# SPDX-License-Identifier: Apache-2.0
"""Makes small faults in a copy of a package, one at a time, and shows which no test notices.

`./flatplank test --long tests/mutation` makes a sample of them;
`python tests/mutation/mutate.py --count 60 --seed 2 --only effects --journal FILE` another one.
"""

from __future__ import annotations

import argparse
import itertools
import json
import os
import random
import re
import shutil
import subprocess
import sys
import tempfile
import time
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path

from lines import VARIABLE, Lines
from mutants import Mutant, mutants_of

ROOT = Path(__file__).parents[2]
SLOWER = 4.0
"""times what the tests take without a fault: a fault that takes longer has been noticed"""


@dataclass(frozen=True)
class Area:
    """A part of the code, and the tests that speak of it, the quickest first."""

    name: str
    folder: str
    """below the package"""
    tests: tuple[str, ...]
    without: tuple[str, ...] = ()
    """files that only write for people, or that no test without a bus can run"""
    package: str = "flatplank_analysis"
    only: tuple[str, ...] = ()
    """names of files; empty: all of the folder"""

    @property
    def source(self) -> Path:
        """Folder of the package."""
        return ROOT / "ros_ws/src" / self.package / self.package


def _files(begin: str, names: str) -> tuple[str, ...]:
    return tuple(f"tests/{begin}_{name}.py" for name in names.split())


FITS = _files(
    "analysis_models/test",
    "mf_tir mf_vectors mod_transient idn_core idn_magic idn_fits",
)
FORMULA = _files("tire/test_mf", "remarks sets structure")
PARTS = _files(
    "analysis_models/test_idn",
    "carcass covariance curve fit_file grid linear mf_points mf_problem "
    "mf_stages mf_statement noise quality repeats results runs search zero",
)
AREAS = (
    Area(
        "effects", "effects",
        _files("discovery/test_disc", "effect_parts looked_for contract sizes effects"),
    ),
    Area(
        "discovery", "discovery",
        _files(
            "discovery/test_disc",
            "screen fit_rules verdicts residuals sums floor_sums "
            "pieces where noise descent heldout whitened engine safeguards wrong_forms "
            "starts patterns determined sizes floors loop rivals invariants",
        ),
        ("report", "modelfile.py", "score.py"),
    ),
    Area(
        "inference", "inference",
        _files(
            "discovery/test_disc",
            "posterior evidence safeguards wrong_forms starts rivals detectable promise engine",
        ),
    ),
    Area(
        "models", "models",
        (*_files("analysis_models/test_mod", "carcass inputs law mf record"),
         *FITS, "tests/analysis_data/test_tire_record.py"),
    ),
    Area(
        "tire", "",
        (*FORMULA, *_files("analysis_models/test_mf", "tir vectors variants"),
         *_files("analysis_data/test", "text_parts tydex_parts formats")),
        package="flatplank_tire",
    ),
    Area(
        "identify", "identify",
        (*PARTS, *FITS, "tests/analysis_data/test_steering_zero.py"),
        ("carcass.py",),
    ),
    Area(
        "drive", "drive",
        _files("drive/test_drive",
            "cia402 rules axis safety following stopping rolling gate drag operator",
        ),
        package="flatplank_hw",
    ),
    Area(
        "hub", "hub", _files("hub/test_hub", "appendix_a core gate setup params parasitic"),
        package="flatplank_hw",
    ),
    Area(
        "encoders", "encoders", _files("encoders/test_enc", "counter core"),
        package="flatplank_hw",
    ),
    Area(
        "ethercat", "ethercat",
        _files(
            "ethercat/test_ethercat",
            "bus_parts busfile guard master_parts axis esi esi_files",
        ),
        ("master",), package="flatplank_hw",
    ),
    Area(
        "master", "ethercat/master",
        _files(
            "ethercat/test_ethercat",
            "guard master_parts image health interface client loop requests states frames mailbox",
        ),
        # need a network interface, or a process of their own
        ("__main__.py", "soem.py", "pacing.py"), package="flatplank_hw",
    ),
    Area(
        "free_rolling", "free_rolling",
        (*_files("control/test_control", "free_rolling linear"),
         "tests/campaign/test_camp_start.py"), package="flatplank_control",
    ),
    Area(
        "recorder", "recording",
        _files(
            "recording/test_rec",
            "parts file arrivals bag layout naming record repair session twin",
        ),
        package="flatplank_control",
    ),
    Area(
        "slip", "sequencer", _files("control/test_control", "sequencer follower"),
        package="flatplank_control",
    ),
    Area(
        "sweeps", "slip_sweeps",
        (*_files("slip_sweeps/test_sweeps", "axes reading curves fit_parts parts"),
         "tests/slip_sweeps/test_sweeps.py",
         *_files("slip_sweeps/test_sweeps", "variants files tir_signs verdict fit")),
    ),
    Area(
        "units", "",
        (*_files("analysis_data/test", "text_units unit_relations unit_checks formats cluster"),
         *_files("recording/test_rec", "record"), "tests/bench/test_limits.py"),
        package="flatplank_data",
        only=("units.py", "unit_checks.py", "unit_relations.py", "force_units.py",
              "standing_units.py", "limits.py", "run_record.py", "record_checks.py"),
    ),
    Area(
        "readers", "",
        _files(
            "analysis_data/test",
            "text_units formats text_tables cluster matlab73 parquet_types compressed_bags "
            "bag_times bag_kinds lost_samples text_parts table_layout reader_parts tydex_parts "
            "bag_parts bags",
        ),
        package="flatplank_data",
        only=("csv.py", "mat.py", "parquet.py", "tydex.py", "bag.py", "base.py", "delimited.py",
              "text.py", "numbers.py", "guard.py"),
    ),
    Area(
        "panel", "",
        _files(
            "panel/test_panel",
            "access parts actions trust operator state service investigate plans",
        ),
        ("views", "nodes", "cli", "analysis", "app.py"), package="flatplank_panel",
    ),
)  # fmt: skip


@dataclass(frozen=True)
class Result:
    """What became of a fault."""

    area: str
    name: str
    killed: str
    """the first test that failed, `too slow`, or empty"""


class Copy:
    """The packages of some areas where they may be broken; the tests stay where they are."""

    def __init__(self, folder: Path, areas: Sequence[Area]) -> None:
        self.folder = folder
        for name, source in {area.package: area.source for area in areas}.items():
            shutil.copytree(source, folder / name)
        self._env = dict(os.environ)
        before = self._env.get("PYTHONPATH", "")
        self._env["PYTHONPATH"] = f"{folder}:{Path(__file__).parent}:{before}"
        self._env["NUMBA_CACHE_DIR"] = str(folder / "numba")
        self._lines: dict[str, Lines] = {}
        for name in {area.package for area in areas}:
            where = self._run([sys.executable, "-c", f"import {name} as f; print(f.__file__)"])
            assert where.stdout.strip().startswith(str(folder)), where.stdout + where.stderr

    def _run(self, words: Sequence[str], limit_s: float = 600.0) -> subprocess.CompletedProcess:
        return subprocess.run(
            words, cwd=ROOT, env=self._env, capture_output=True, text=True, check=False,
            timeout=limit_s,
        )  # fmt: skip

    def first_failure(
        self, tests: Sequence[str], limit_s: float, plugin: str = "no:cacheprovider"
    ) -> str:
        """Name of the first test that fails."""
        # times mean nothing while lines are recorded, and a browser asks another process
        words = [sys.executable, "-m", "pytest", "-x", "-q", "-p", "no:cacheprovider"]
        words += ["-k", "not cheap", "-m", "not browser"]
        try:
            done = self._run([*words, "-p", plugin, *tests], limit_s)
        except subprocess.TimeoutExpired:
            return "too slow"
        if done.returncode == 0:
            return ""
        named = re.search(r"^(?:FAILED|ERROR) \S*?(\w+\.py\S*)", done.stdout, re.M)
        return named[1] if named else f"exit {done.returncode}"

    def try_out(self, area: Area, mutant: Mutant, limit_s: float, near: bool) -> Result:
        """Break a file, run the tests, mend it; `near`: only tests that run the line."""
        path = self.folder / area.package / mutant.file
        before, stat = path.read_bytes(), path.stat()
        path.write_text(mutant.source, encoding="utf-8")
        try:
            killed = self._noticed(area, mutant, limit_s, near)
        finally:
            path.write_bytes(before)
            os.utime(path, ns=(stat.st_atime_ns, stat.st_mtime_ns))
        return Result(area.name, mutant.name, killed)

    def _noticed(self, area: Area, mutant: Mutant, limit_s: float, near: bool) -> str:
        """First those that run the line, then the others."""
        tests = self._lines[area.name].of(mutant.file, mutant.lines)
        found = self.first_failure(tests, limit_s) if tests else ""
        if found or (near and tests):
            return found
        return self.first_failure(area.tests, limit_s)

    def limit_s(self, area: Area) -> float:
        """For the tests of an area; they pass here, or nothing that fails says anything."""
        began = time.monotonic()
        path = self.folder / f"{area.name}.json"
        self._env[VARIABLE] = f"{self.folder / area.package}:{path}"
        failed = self.first_failure(area.tests, 3600.0, "lines")
        del self._env[VARIABLE]
        assert failed == "", f"{area.name} without any fault: {failed}"
        self._lines[area.name] = Lines.read(path)
        return 30.0 + SLOWER * (time.monotonic() - began)


def all_of(area: Area) -> list[Mutant]:
    """Every fault of an area."""
    top = area.source
    out = []
    for path in sorted((top / area.folder).rglob("*.py")):
        if area.only and path.name not in area.only:
            continue
        if not set(path.relative_to(top).parts) & set(area.without):
            out += mutants_of(path, str(path.relative_to(top)))
    return out


def sample(areas: Sequence[Area], count: int, seed: int) -> Iterator[tuple[Area, Mutant]]:
    """The same number from every area; file by file, so that no long file drowns the others."""
    draw = random.Random(seed)
    queues = []
    for area in areas:
        files: dict[str, list[Mutant]] = {}
        for mutant in all_of(area):
            files.setdefault(mutant.file, []).append(mutant)
        order = list(files.values())
        draw.shuffle(order)
        for mutants in order:
            draw.shuffle(mutants)
        most = max(len(m) for m in order)
        queues.append([(area, m[i]) for i in range(most) for m in order if i < len(m)])
    turns = itertools.chain.from_iterable(itertools.zip_longest(*queues))
    yield from itertools.islice((pair for pair in turns if pair is not None), count)


def known(journal: Path | None) -> dict[str, Result]:
    """Results of an earlier run."""
    if journal is None or not journal.exists():
        return {}
    lines = (json.loads(line) for line in journal.read_text().splitlines())
    return {line["name"]: Result(**line) for line in lines}


def run(
    areas: Sequence[Area], count: int, seed: int, budget_s: float, journal: Path | None = None,
    near: bool = False,
) -> list[Result]:  # fmt: skip
    """Results of a sample, as far as the time goes; each is printed and kept."""
    end, before, out = time.monotonic() + budget_s, known(journal), []
    with tempfile.TemporaryDirectory(prefix="fp-mutants-") as name:
        copied = Copy(Path(name), areas)
        limits = {area.name: copied.limit_s(area) for area in areas}
        for area, mutant in sample(areas, count, seed):
            if time.monotonic() > end:
                print(f"time is up after {len(out)} of {count}", flush=True)
                break
            result = before.get(mutant.name) or copied.try_out(
                area, mutant, limits[area.name], near
            )
            out.append(result)
            print(f"{result.area}: {result.name}: {result.killed or 'SURVIVED'}", flush=True)
            if journal is not None and mutant.name not in before:
                with journal.open("a") as file:
                    file.write(json.dumps(vars(result)) + "\n")
    return out


def share(results: Sequence[Result]) -> float:
    """Of the faults, those that were noticed."""
    return sum(bool(r.killed) for r in results) / max(len(results), 1)


def summary(results: Sequence[Result]) -> str:
    """A line per area, and the survivors."""
    lines = []
    for name in dict.fromkeys(r.area for r in results):
        own = [r for r in results if r.area == name]
        killed = sum(bool(r.killed) for r in own)
        lines.append(f"{name}: {killed} of {len(own)} killed, {100 * share(own):.0f} %")
    lines.append(f"all: {100 * share(results):.0f} % of {len(results)}")
    lines += [f"survived: {r.name}" for r in results if not r.killed]
    return "\n".join(lines)


def main(arguments: list[str] | None = None) -> int:
    """Exit code 1 when fewer than nine of ten are noticed."""
    p = argparse.ArgumentParser(description=__doc__)
    p.add_argument("--count", type=int, default=60)
    p.add_argument("--seed", type=int, default=1)
    p.add_argument("--hours", type=float, default=2.0)
    p.add_argument("--only", choices=[a.name for a in AREAS], action="append")
    p.add_argument("--journal", type=Path, help="results are kept here, and not made again")
    p.add_argument("--near", action="store_true", help="ask only tests that run the line")
    o = p.parse_args(arguments)
    areas = [a for a in AREAS if not o.only or a.name in o.only]
    results = run(areas, o.count, o.seed, 3600.0 * o.hours, o.journal, o.near)
    print(summary(results))
    return 0 if share(results) >= 0.9 else 1


if __name__ == "__main__":
    raise SystemExit(main())
