# SPDX-License-Identifier: Apache-2.0
"""Runs blind cases in processes and writes every result at once, so that it can be stopped and
resumed."""

from __future__ import annotations

import gzip
import json
import subprocess
from collections.abc import Callable, Iterable, Iterator, Sequence
from dataclasses import asdict
from functools import lru_cache, partial
from pathlib import Path
from typing import Any

import flatplank_analysis
from flatplank_analysis.contact_patch.session import Session
from flatplank_analysis.parallel import open_executor
from flatplank_validation.blind.cases import Case, make
from flatplank_validation.blind.detectable import kit_version
from flatplank_validation.blind.fingerprint import fingerprint

Progress = Callable[[int, int, str], None]
JUDGED = ("discovery", "inference", "effects", "contact_patch")
KEPT = (
    "verdict", "reason", "floor_rmse", "rmse_before", "rmse_after", "held_out_before",
    "held_out_after", "unexplained", "seconds", "posterior",
)  # fmt: skip
OF_EFFECT = ("name", "kind", "size", "unit", "interval", "class", "probability")


@lru_cache
def code_version(folders: tuple[str, ...] = JUDGED) -> str:
    """Fingerprint of the diagnosis code, which keeps results of different code apart."""
    root = Path(flatplank_analysis.__file__).parent
    files = (p for folder in folders for p in sorted((root / folder).rglob("*.py")))
    return fingerprint(p for p in files if "report" not in p.parts)


@lru_cache(maxsize=1)
def commit() -> str:
    """Git commit of the running files, with + when some differ from it."""
    asked = ["git", "-C", str(Path(__file__).parent), "describe", "--always", "--dirty=+"]
    try:
        done = subprocess.run(asked, capture_output=True, text=True, timeout=20)
    except (OSError, subprocess.TimeoutExpired):
        return "unknown"
    return done.stdout.strip() or "unknown"


def diagnose(tables: list) -> dict[str, Any]:
    """Diagnose tables, with no other information."""
    result = Session.of_tables(tables).diagnose().to_dict()
    short = {k: result.get(k) for k in (*KEPT, "detectable")}
    return short | {"effects": [{k: e[k] for k in OF_EFFECT} for e in result["effects"]]}


def solve(case: Case, seed: int) -> dict[str, Any]:
    """Make and diagnose a case; returns one line of the journal."""
    entry = {"key": case.key, "seed": seed, "code": code_version(), "kit": kit_version()}
    entry |= {"commit": commit(), "case": asdict(case)}
    made = make(case, seed)
    if made is None:
        return entry | {"answer": None, "diagnosis": None}
    tables, answer = made
    told = diagnose(tables)
    told["detectable"] = {n: told["detectable"].get(n) for n in case.hidden}
    return entry | {"answer": answer, "diagnosis": told}


def read(path: Path) -> list[dict[str, Any]]:
    """All complete lines of a journal; a truncated line is ignored."""
    out = []
    if path.is_file():
        for line in path.read_text(encoding="utf-8").splitlines():
            try:
                out.append(json.loads(line))
            except json.JSONDecodeError:
                continue
    return out


def of_this_code(
    entries: Iterable[dict[str, Any]], seed: int, any_code: bool = False
) -> dict[str, dict[str, Any]]:
    """Entries of this seed, made by the present code from the present kit, by key.

    any_code: also entries of other code, where the present code has none.
    """
    here = [e for e in entries if (e["seed"], e.get("kit")) == (seed, kit_version())]
    old = {e["key"]: e for e in here} if any_code else {}
    return old | {e["key"]: e for e in here if e["code"] == code_version()}


def publish(path: Path, header: dict[str, Any], entries: Iterable[dict[str, Any]]) -> None:
    """Write a journal for the docs to one compressed file, reproducible byte for byte."""
    lines = [json.dumps(one, sort_keys=True) for one in (header, *entries)]
    with path.open("wb") as raw, gzip.GzipFile("", "wb", 9, raw, 0) as stream:
        stream.write(("\n".join(lines) + "\n").encode())


def published(path: Path) -> tuple[dict[str, Any], list[dict[str, Any]]]:
    """Read header and entries of a journal in the docs."""
    header, *entries = map(json.loads, gzip.decompress(path.read_bytes()).splitlines())
    return header, entries


def diagnosed(path: Path) -> list[dict[str, Any]]:
    """Entries with a diagnosis, of a journal or of a published one."""
    entries = published(path)[1] if path.suffix == ".gz" else read(path)
    return [e for e in entries if e["diagnosis"]]


def case_of(entry: dict[str, Any]) -> Case:
    """The case of an entry."""
    stored: dict[str, Any] = dict(entry["case"])
    return Case(**stored | {"hidden": tuple(stored["hidden"])})


def run(
    cases: list[Case],
    seed: int,
    path: Path,
    jobs: int = 1,
    progress: Progress = lambda _done, _all, _key: None,
) -> list[dict[str, Any]]:
    """Solve the cases that the journal lacks; returns the entries of all cases."""
    path.parent.mkdir(parents=True, exist_ok=True)
    known = of_this_code(read(path), seed)
    missing = [c for c in cases if c.key not in known]
    done = len(cases) - len(missing)
    with path.open("a", encoding="utf-8") as stream:
        for entry in solved(partial(solve, seed=seed), missing, jobs):
            stream.write(json.dumps(entry) + "\n")
            stream.flush()
            known[entry["key"]] = entry
            done += 1
            progress(done, len(cases), entry["key"])
    return [known[c.key] for c in cases]


def solved(
    work: Callable[[Any], dict[str, Any]], cases: Sequence[Any], jobs: int
) -> Iterator[dict[str, Any]]:
    """Yield entries in the order of the cases, from `jobs` processes or from this one."""
    with open_executor(max(jobs, 1)) as executor:
        yield from executor.map(work, cases)
