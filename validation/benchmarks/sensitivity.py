# SPDX-License-Identifier: Apache-2.0
"""What changes in the answers of the search when a tuning constant is halved and doubled.

    python validation/benchmarks/sensitivity.py --count 66 --jobs 2
    python validation/benchmarks/sensitivity.py --first 23 --only 'discovery.*' 'effects.*'
    python validation/benchmarks/constants.py --write docs/reference/constants.md

It diagnoses campaigns of the blind kit and can be stopped and gone on with, also from the
published journal.
"""

from __future__ import annotations

import argparse
import ast
import fnmatch
import hashlib
import importlib.abc
import importlib.util
import json
import os
import pickle
import subprocess
import sys
from collections.abc import Callable, Mapping, Sequence
from concurrent.futures import ThreadPoolExecutor
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Any

from bifurcation import bifurcate, groups_of
from branches import Names, Package, Serial, run
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
    answer_of,
    constants,
    literal_names,
    read,
)
from remembered import Remembered

SEARCH = "discovery"
"""folder of the constants that no prediction of the model depends on"""
TOGETHER = 16
"""settings that are applied together first"""


class Varied(importlib.abc.MetaPathFinder, importlib.abc.Loader):
    """Import hook that changes numbers of modules at their import; `values`: new value by key."""

    def __init__(self, values: Mapping[str, Value]) -> None:
        self.values: dict[str, dict[str, Value]] = {}
        for key, value in values.items():
            module, _, name = key.rpartition(".")
            self.values.setdefault(f"{PACKAGE}.{module}", {})[name] = value

    def find_spec(self, name, path=None, target=None):
        if name not in self.values:
            return None
        file = SOURCE.parent / Path(*name.split(".")).with_suffix(".py")
        return importlib.util.spec_from_file_location(name, file, loader=self)

    def create_module(self, spec):
        return None

    def exec_module(self, module) -> None:
        new, body = self.values[module.__name__], []
        tree = ast.parse(Path(module.__spec__.origin).read_text(encoding="utf-8"))
        for node in tree.body:
            body.append(node)
            for name in set(new) & set(literal_names(node)):
                other = ast.parse(f"{name} = {new[name]!r}").body[0]
                body.append(ast.copy_location(other, node))
        tree.body = body
        module.__file__ = module.__spec__.origin
        exec(compile(ast.fix_missing_locations(tree), module.__file__, "exec"), module.__dict__)


def vary(values: Mapping[str, Value]) -> None:
    """Change numbers in this process, by key."""
    for name in [n for n in sys.modules if n.split(".")[0] == PACKAGE]:
        del sys.modules[name]
    sys.meta_path.insert(0, Varied(values))


@dataclass(frozen=True)
class Setting:
    """A constant with a factor."""

    constant: Constant
    factor: float

    @property
    def value(self) -> Value:
        """The other value."""
        return self.constant.times(self.factor)

    @property
    def entry(self) -> dict[str, Any]:
        """What the journal says of it."""
        constant = self.constant
        return {"constant": constant.key, "factor": self.factor, "value": str(constant.value)}

    def names(self, package: Package) -> Names:
        """Where modules have the constant."""
        return package.names_of(f"{PACKAGE}.{self.constant.module}", self.constant.name)


AS_IT_IS = {"constant": "", "factor": 1.0, "value": "None"}
"""what the journal says of the search without a change"""
Group = Sequence[Setting]


def settings_of(only: Sequence[str]) -> list[Setting]:
    """All settings of constants whose keys match one of some patterns."""
    varied = [c for c in constants() if c.key not in FACTS and c.folder != PROPOSE]
    wanted = [c for c in varied if any(fnmatch.fnmatch(c.key, pattern) for pattern in only)]
    return [Setting(c, f) for c in wanted for f in FACTORS]


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


def result_of(number: int, journal: Path) -> dict[str, Any]:
    """Diagnose a campaign in this process: verdict, names, sizes, and whether that is right."""
    from flatplank_validation.blind.journal import diagnose
    from flatplank_validation.blind.lists import full
    from flatplank_validation.blind.points import points_of

    made = tables_of(number, tables_folder(journal))
    assert made is not None  # only scored campaigns are diagnosed
    try:
        told = diagnose(made[0])
    except Exception as error:  # another number may break the search
        return {"verdict": f"fails: {error}", "names": [], "sizes": [], "right": False}
    entry = {"diagnosis": told, "answer": made[1], "case": asdict(full(SEED)[number])}
    return {
        "verdict": told["verdict"],
        "names": [e["name"] for e in told["effects"]],
        "sizes": [e["size"] for e in told["effects"]],
        "right": bool(points_of(entry)["right"]),
    }


def result_apart(number: int, journal: Path, group: Group) -> dict[str, Any]:
    """The same in a process of its own, with constants changed that are read at an import."""
    values = {s.constant.key: s.value for s in group}
    # compiled code contains the numbers of its module
    name = hashlib.sha256(json.dumps(values).encode()).hexdigest()[:12]
    own = {"NUMBA_CACHE_DIR": str(tables_folder(journal) / f"compiled-{name}")}
    words = ["--one", str(number), "--values", json.dumps(values), "--journal", str(journal)]
    done = subprocess.run(
        [sys.executable, __file__, *words], env=os.environ | own, check=True,
        stdout=subprocess.PIPE,
    )  # fmt: skip
    return json.loads(done.stdout)


def work(number: int, only: Sequence[str], journal: Path) -> None:
    """Diagnose one campaign with all settings that the journal lacks."""
    from flatplank_analysis.contact_patch import model
    from flatplank_validation.blind.journal import code_version
    from flatplank_validation.blind.lists import full

    of = {"code": code_version(), "key": full(SEED)[number].key}
    earlier = [*read(PUBLISHED), *read(journal)]
    known = [{k: e[k] for k in (*AS_IT_IS, *of)} for e in earlier]
    left = [s for s in settings_of(only) if s.entry | of not in known]
    if not left or tables_of(number, tables_folder(journal)) is None:
        return
    model._POOL = Serial()
    memory = Remembered(model.TireModel.predict)
    package = Package(SOURCE)
    names = {s: s.names(package) for s in left}

    def tell(entry: dict[str, Any], found: dict[str, Any]) -> None:
        with journal.open("a", encoding="utf-8") as stream:
            stream.write(json.dumps(entry | of | found) + "\n")

    with memory.used_by(model.TireModel):
        plain = result_of(number, journal)
    memory.full = True  # many searches would fill the computer's
    tell(AS_IT_IS, plain)

    def forked(groups: Sequence[Group]) -> list[dict[str, Any]]:
        branches = [[(names[s], s.value) for s in g] for g in groups]
        _, found = run(lambda: result_of(number, journal), branches)
        return [plain if f is None else f for f in found]

    def remembered(groups: Sequence[Group]) -> list[dict[str, Any]]:
        with memory.used_by(model.TireModel):
            return forked(groups)

    def apart(groups: Sequence[Group]) -> list[dict[str, Any]]:
        return [result_apart(number, journal, g) for g in groups]

    def way_of(setting: Setting) -> Callable[[Sequence[Group]], list[dict[str, Any]]]:
        if names[setting].at_import:
            return apart
        return remembered if setting.constant.folder == SEARCH else forked

    for way in (remembered, forked, apart):
        some = [s for s in left if way_of(s) is way]
        parts = ([s for s in some if s.factor == factor] for factor in FACTORS)
        groups = [g for part in parts for g in groups_of(part, TOGETHER)]
        answers = bifurcate(groups, way, lambda f: answer_of(f) != answer_of(plain))
        for setting, found, count in answers:
            tell(setting.entry | {"together": count}, found)
        memory.known.clear()


def study(only: Sequence[str], numbers: Sequence[int], journal: Path, jobs: int) -> None:
    """Diagnose campaigns with every constant halved and doubled, a process for each campaign."""
    journal.parent.mkdir(parents=True, exist_ok=True)

    def one(number: int) -> None:
        words = ["--only", *only, "--one", str(number), "--journal", str(journal)]
        subprocess.run([sys.executable, __file__, *words], check=True)
        print(f"campaign {number + 1}/{numbers[-1] + 1}", file=sys.stderr, flush=True)

    with ThreadPoolExecutor(jobs) as pool:
        for _ in pool.map(one, numbers):
            pass


def main(arguments: list[str] | None = None) -> int:
    p = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    p.add_argument("--only", nargs="+", default=["*"], metavar="PATTERN", help="of module.name")
    p.add_argument("--first", type=int, default=1, help="campaign of the list to begin with")
    p.add_argument("--count", type=int, default=66, help="of the list; about 1 in 10 has no score")
    p.add_argument("--jobs", type=int, default=1, help="processes")
    p.add_argument("--journal", type=Path, default=JOURNAL)
    p.add_argument("--one", type=int, help=argparse.SUPPRESS)
    p.add_argument("--values", type=json.loads, help=argparse.SUPPRESS)
    o = p.parse_args(arguments)
    if o.one is None:
        study(o.only, range(o.first - 1, o.count), o.journal, o.jobs)
    elif o.values is None:
        work(o.one, o.only, o.journal)
    else:
        vary({key: tuple(v) if isinstance(v, list) else v for key, v in o.values.items()})
        print(json.dumps(result_of(o.one, o.journal)))
    return 0


if __name__ == "__main__":
    raise SystemExit(main())
