# SPDX-License-Identifier: Apache-2.0
"""What changes in the answers of the search when a tuning constant is halved and doubled.

    python validation/benchmarks/sensitivity.py --count 60 --jobs 2
    python validation/benchmarks/constants.py --write docs/constants.md

It diagnoses campaigns of the blind kit and can be stopped and gone on with, also from the
published journal.
"""

from __future__ import annotations

import argparse
import ast
import fnmatch
import importlib.abc
import importlib.util
import json
import os
import pickle
import subprocess
import sys
from collections.abc import Mapping
from concurrent.futures import ThreadPoolExecutor
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Any

from branches import Branch, Names, Package, Serial, run
from constants import (
    FACTORS,
    FACTS,
    JOURNAL,
    PACKAGE,
    PROPOSE,
    PUBLISHED,
    SEED,
    SOURCE,
    Constant,
    Value,
    constants,
    literal_names,
    read,
)

FAILS = "fails"
"""begin of the verdict of a search that raises an error"""


class Varied(importlib.abc.MetaPathFinder, importlib.abc.Loader):
    """Import hook that changes one number of a module at its import."""

    def __init__(self, constant: Constant, value: Value) -> None:
        self.name, self.constant, self.value = f"{PACKAGE}.{constant.module}", constant, value

    def find_spec(self, name, path=None, target=None):
        if name != self.name:
            return None
        file = SOURCE / Path(*self.constant.module.split(".")).with_suffix(".py")
        return importlib.util.spec_from_file_location(name, file, loader=self)

    def create_module(self, spec):
        return None

    def exec_module(self, module) -> None:
        text = Path(module.__spec__.origin).read_text(encoding="utf-8")
        tree = ast.parse(text)
        for i, node in enumerate(tree.body):
            if self.constant.name in literal_names(node):
                new = ast.parse(f"{self.constant.name} = {self.value!r}").body[0]
                tree.body.insert(i + 1, ast.copy_location(new, node))
                break
        module.__file__ = module.__spec__.origin
        exec(compile(ast.fix_missing_locations(tree), module.__file__, "exec"), module.__dict__)


def vary(key: str, factor: float) -> Value:
    """Change a number in this process; returns the old value."""
    (constant,) = (c for c in constants() if c.key == key)
    for name in [n for n in sys.modules if n.split(".")[0] == PACKAGE]:
        del sys.modules[name]
    sys.meta_path.insert(0, Varied(constant, constant.times(factor)))
    return constant.value


@dataclass(frozen=True)
class Setting:
    """A constant with a factor; no constant: the search as it is."""

    constant: Constant | None = None
    factor: float = 1.0

    def __str__(self) -> str:
        return f"{self.constant.key} x {self.factor:g}" if self.constant else "as it is"

    @property
    def entry(self) -> dict[str, Any]:
        """What the journal says of it."""
        key, value = (self.constant.key, self.constant.value) if self.constant else ("", None)
        return {"constant": key, "factor": self.factor, "value": str(value)}

    def names(self, package: Package) -> Names:
        """Where modules have the constant."""
        return package.names_of(f"{PACKAGE}.{self.constant.module}", self.constant.name)


def settings_of(only: str) -> list[Setting]:
    """All settings of constants whose keys match a pattern."""
    wanted = [c for c in constants() if c.key not in FACTS and c.folder != PROPOSE]
    return [
        Setting(c, factor) for c in wanted if fnmatch.fnmatch(c.key, only) for factor in FACTORS
    ]


def tables_of(number: int, folder: Path) -> tuple[Any, Any] | None:
    """Tables and answer of a campaign of the list, made once; None when it is not scored."""
    from flatplank_validation.blind.cases import make
    from flatplank_validation.blind.lists import full

    path = folder / f"{number}.pickle"
    if not path.exists():
        folder.mkdir(parents=True, exist_ok=True)
        new = path.with_name(f"{number}-{os.getpid()}")
        new.write_bytes(pickle.dumps(make(full(SEED)[number], SEED)))
        new.rename(path)
    return pickle.loads(path.read_bytes())


def tables_folder(journal: Path) -> Path:
    """Folder of the campaigns' tables."""
    from flatplank_validation.blind.detectable import kit_version

    return journal.with_name(f"{journal.stem}-{kit_version()}")


def work(number: int, settings: Mapping[Setting, Names], journal: Path) -> None:
    """Diagnose one campaign with all settings that the journal lacks, in this process.

    A constant that is read at an import must be alone.
    """
    alone = any(n.at_import for n in settings.values())
    if alone:
        (setting,) = settings
        vary(setting.constant.key, setting.factor)
    from flatplank_analysis.contact_patch import model
    from flatplank_validation.blind.journal import code_version, diagnose
    from flatplank_validation.blind.lists import full

    case, made = full(SEED)[number], tables_of(number, tables_folder(journal))
    of = {"code": code_version(), "key": case.key}
    earlier = [*read(PUBLISHED), *read(journal)]
    known = [{k: e[k] for k in (*Setting().entry, *of)} for e in earlier]
    left = [s for s in settings if s.entry | of not in known]
    if made is None or not left:
        return
    tables, answer = made
    model._POOL = Serial()

    def tell(setting: Setting, told: dict[str, Any]) -> None:
        line = setting.entry | of | _result(told, answer, asdict(case))
        with journal.open("a", encoding="utf-8") as stream:
            stream.write(json.dumps(line) + "\n")

    def diagnosed() -> dict[str, Any]:
        try:
            return diagnose(tables)
        except Exception as error:  # another number may break the search
            return {"verdict": f"{FAILS}: {error}", "effects": []}

    if alone:
        tell(setting, diagnosed())
        return
    forks = [Branch(i, s.constant.times(s.factor), settings[s]) for i, s in enumerate(left)]
    told, unused = run(diagnosed, forks, lambda i, told: tell(left[i], told))
    for setting in [Setting(), *(left[i] for i in unused)]:
        tell(setting, told)


def _result(told: dict[str, Any], answer: Any, case: dict[str, Any]) -> dict[str, Any]:
    from flatplank_validation.blind.points import points_of

    entry = {"diagnosis": told, "answer": answer, "case": case}
    return {
        "verdict": told["verdict"],
        "names": [e["name"] for e in told["effects"]],
        "sizes": [e["size"] for e in told["effects"]],
        "right": not told["verdict"].startswith(FAILS) and bool(points_of(entry)["right"]),
    }


def study(only: str, count: int, journal: Path, jobs: int) -> None:
    """Diagnose campaigns with every constant halved and doubled, a process for each campaign and
    one for each constant that is read at an import."""
    settings, package = settings_of(only), Package(SOURCE)
    alone = [s for s in settings if s.names(package).at_import]
    tasks = [
        (number, words, of)
        for number in range(count)
        for words, of in [
            ([], f"{len(settings) - len(alone)} settings"),
            *((["--only", s.constant.key, "--factor", str(s.factor)], str(s)) for s in alone),
        ]
    ]
    journal.parent.mkdir(parents=True, exist_ok=True)

    def one(task: int) -> None:
        number, words, of = tasks[task]
        all_words = ["--only", only, *words, "--one", str(number), "--journal", str(journal)]
        # compiled code contains the numbers of its module
        cache = tables_folder(journal) / "-".join(["compiled", *words[1::2]])
        own = {"NUMBA_CACHE_DIR": str(cache)} if words else {}
        subprocess.run([sys.executable, __file__, *all_words], env=os.environ | own, check=True)
        print(f"campaign {number + 1}/{count}: {of}", file=sys.stderr, flush=True)

    with ThreadPoolExecutor(jobs) as pool:
        for _ in pool.map(one, range(len(tasks))):
            pass


def main(arguments: list[str] | None = None) -> int:
    p = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    p.add_argument("--only", default="*", metavar="PATTERN", help="of module.name")
    p.add_argument("--count", type=int, default=60, help="campaigns")
    p.add_argument("--jobs", type=int, default=1, help="processes")
    p.add_argument("--journal", type=Path, default=JOURNAL)
    p.add_argument("--one", type=int, help=argparse.SUPPRESS)
    p.add_argument("--factor", type=float, help=argparse.SUPPRESS)
    o = p.parse_args(arguments)
    if o.one is None:
        study(o.only, o.count, o.journal, o.jobs)
        return 0
    package = Package(SOURCE)
    names = {s: s.names(package) for s in settings_of(o.only) if o.factor in (None, s.factor)}
    early = o.factor is not None
    work(o.one, {s: n for s, n in names.items() if n.at_import == early}, o.journal)
    return 0


if __name__ == "__main__":
    raise SystemExit(main())
