# SPDX-License-Identifier: Apache-2.0
"""The tuning constants of the search, as a table.

    python validation/benchmarks/constants.py --write docs/reference/constants.md

Constants are found by module and name, where the code has them. What `sensitivity.py` found stands
in the table, and its journal beside that. It diagnoses campaigns of the blind kit, so it says
nothing about constants of `propose`.
"""

from __future__ import annotations

import argparse
import ast
import gzip
import importlib
import json
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any, NamedTuple

ROOT = Path(__file__).resolve().parents[2]
PACKAGE = "flatplank_analysis"
SOURCE = ROOT / "ros_ws/src" / PACKAGE / PACKAGE
FOLDERS = ("discovery", "inference", "contact_patch", "effects", "proposal")
FACTORS = (0.5, 2.0)
SEED = 4711
JOURNAL = ROOT / ".cache/constants.jsonl"
PUBLISHED = ROOT / "docs/reference/constants.jsonl.gz"
CHOSEN = "chosen by hand"

SOURCES: dict[str, str] = {
    "inference.posterior.NAMED": "convention: nineteen in twenty",
    "inference.posterior.MEMBER": "convention: one in twenty",
    "inference.priors.EXPECTED": "one fault a machine, `docs/explanation/search.md`",
    "proposal.propose.HELD_OUT": "tuned on blind campaigns",
    "discovery.descent.PROBE": "compare 0.1 of arXiv:1201.5885",
    "discovery.descent.SHARPEST": "compare 0.75 of arXiv:1201.5885",
    "contact_patch.data.STIFFNESS": "carcass of a car tire",
    "contact_patch.data.PINION_TURN": "machine, placeholder",
    "contact_patch.grid.SPEED": "machine: fast speed of the plank",
    "contact_patch.parameters.PROTRACTOR": "a tenth of a degree is 1.7 mrad",
    "contact_patch.laws.LAW_LEVELS": "slips of the thesis's campaigns and of the blind kit",
    "contact_patch.model.LAW_AMONG_SETTINGS": "`bench-discovery --form 3`: 0.9 to 1.0 % rms",
    "contact_patch.model.STRETCH_WITH_SIDE_SLIP": "`bench-discovery --form 4`: 1.1 % of 24 tires",
}
"""constant -> source of its value, where known"""
FACTS = (
    "contact_patch.plans.LOADS", "contact_patch.plans.STARTS", "contact_patch.plans.STEPS",
    "inference.contrast.SMALL",
    "contact_patch.denoising.ORDERS", "contact_patch.data.PINION_TURN", "contact_patch.grid.SPEED",
    "contact_patch.grid.SAMPLE", "contact_patch.kernel.ROWS", "contact_patch.kernel.WIDE",
    "contact_patch.model.CHUNK", "contact_patch.model.MOST_THREADS", "discovery.gram.AT_ONCE",
    "inference.detectable.POWER",
    "proposal.confirm.STEP", "proposal.picture.WIDEST", "proposal.scan.POINTS",
)  # fmt: skip
"""constants that are not varied: properties of the machine, places in an array, or without effect
on a result"""
PROPOSE = "proposal"
"""folder of the constants that only `propose` uses"""
MATHEMATICS = ("contact_patch.compiling",)
"""modules whose numbers are mathematics, not tuning"""
ABOUT = {"discovery.invariants.AT_FLOOR": 1.0}
"""constant -> reference, from which the distance is halved and doubled; 0 by default, and 1 for
shares above one half"""

Value = int | float | tuple[float, ...]
Found = Mapping[str, Mapping[float, Sequence[dict[str, Any]]]]


@dataclass(frozen=True)
class Constant:
    """A number or several numbers at the top of a module."""

    module: str
    name: str
    value: Value
    note: str

    @property
    def key(self) -> str:
        """Module and name, as key."""
        return f"{self.module}.{self.name}"

    @property
    def folder(self) -> str:
        """Part of the package."""
        return self.module.split(".")[0]

    @property
    def source(self) -> str:
        """Source of the value."""
        return SOURCES.get(self.key, CHOSEN)

    def times(self, factor: float) -> Value:
        """The value halved or doubled, relative to its reference."""
        many = self.value if isinstance(self.value, tuple) else (self.value,)
        out = tuple(self._one(v, factor) for v in many)
        return out if isinstance(self.value, tuple) else out[0]

    def _one(self, value: float, factor: float) -> float:
        about = ABOUT.get(self.key, 1.0 if 0.5 < value < 1.0 else 0.0)
        new = about + factor * (value - about)
        return max(round(new), 1) if isinstance(value, int) else new


def constants() -> Iterator[Constant]:
    """All constants, in the order of the files."""
    for folder in FOLDERS:
        for path in sorted((SOURCE / folder).glob("*.py")):
            module = f"{folder}.{path.stem}"
            if module in MATHEMATICS:
                continue
            body = ast.parse(path.read_text(encoding="utf-8")).body
            for node, after in zip(body, [*body[1:], None], strict=False):
                for name in literal_names(node):
                    value = getattr(importlib.import_module(f"{PACKAGE}.{module}"), name)
                    if _is_number(value):
                        yield Constant(module, name, value, _note(after))


def literal_names(node: ast.AST) -> list[str]:
    """Names to which a statement assigns literal numbers."""
    if not isinstance(node, (ast.Assign, ast.AnnAssign)) or node.value is None:
        return []
    if any(isinstance(part, (ast.Call, ast.Constant)) and not _plain(part)
           for part in ast.walk(node.value)):  # fmt: skip
        return []
    targets = node.targets if isinstance(node, ast.Assign) else [node.target]
    names = [n for t in targets for n in ast.walk(t) if isinstance(n, ast.Name)]
    return [n.id for n in names if n.id.strip("_").isupper()]


def _plain(node: ast.AST) -> bool:
    return isinstance(node, ast.Constant) and type(node.value) in (int, float)


def _is_number(value: Any) -> bool:
    one = type(value) in (int, float)
    return one or (isinstance(value, tuple) and all(type(v) in (int, float) for v in value))


def _note(node: ast.AST | None) -> str:
    text = isinstance(node, ast.Expr) and isinstance(node.value, ast.Constant) and node.value.value
    return " ".join(text.split()) if isinstance(text, str) else ""


def page(found: Found) -> str:
    """The table as Markdown; `found`: results of a study by constant and factor (1: unchanged)."""
    lines = [
        "# Tuning constants of the search",
        "",
        "Written by `python validation/benchmarks/constants.py "
        "--write docs/reference/constants.md`; a test holds it to the code.",
        "",
        *([_studied(found), ""] if set(found) - {""} else []),
        "| constant | value | what it is | source | halved | doubled |",
        "|---|---|---|---|---|---|",
    ]
    for c in constants():
        cells = [f"`{c.key}`", f"{c.value}", c.note or "-", c.source]
        cells += [_changed(found, c, factor) for factor in FACTORS]
        lines.append("| " + " | ".join(cell.replace("|", "\\|") for cell in cells) + " |")
    lines += [
        "",
        "*Halved*, *doubled*: campaigns of the study with another verdict or other names, and how "
        "many more or fewer are right; -: not varied yet.",
        "",
    ]
    return "\n".join(lines)


def _studied(found: Found) -> str:
    pairs = [(c, factor) for c in constants() for factor in FACTORS]
    seen = [s for s in (_comparison(found, c, factor) for c, factor in pairs) if s.campaigns]
    entries = [e for of in found.values() for es in of.values() for e in es]
    together = max(e.get("together", 1) for e in entries)
    versions = sorted({e["code"] for e in entries})
    return (
        f"{len(seen)} settings were varied on up to {max(s.campaigns for s in seen)} campaigns of "
        f"the blind kit, seed {SEED} (`validation/benchmarks/sensitivity.py`); "
        f"{sum(not s.other for s in seen)} of them change no answer. Each campaign was diagnosed "
        f"by one version of the search (of {', '.join(versions)}). Up to {together} settings "
        "are applied together (sequential bifurcation): where the answer stays, it counts for "
        "each of them; where not, they are divided, down to single ones. The journal is "
        f"[beside this page]({PUBLISHED.name}). A number of another value than then counts as not "
        "varied."
    )


class Comparison(NamedTuple):
    """Answers with a setting beside those without."""

    campaigns: int
    other: int
    """with another verdict or other names"""
    right: int
    """more that are right"""

    def __str__(self) -> str:
        return f"{self.other} of {self.campaigns}, {self.right:+d}" if self.campaigns else "-"


def _changed(found: Found, constant: Constant, factor: float) -> str:
    if constant.key in FACTS:
        return "no tuning"
    if constant.folder == PROPOSE:
        return "not in `diagnose`"
    return str(_comparison(found, constant, factor))


def _comparison(found: Found, constant: Constant, factor: float) -> Comparison:
    plain = {_campaign(e): e for e in found.get("", {}).get(1.0, [])}
    varied = [
        e
        for e in found.get(constant.key, {}).get(factor, [])
        if _campaign(e) in plain and e["value"] == str(constant.value)
    ]
    return Comparison(
        len(varied),
        sum(answer_of(e) != answer_of(plain[_campaign(e)]) for e in varied),
        sum(e["right"] - plain[_campaign(e)]["right"] for e in varied),
    )


def _campaign(entry: Mapping[str, Any]) -> tuple[str, str]:
    """Identity of a campaign, with the search that diagnosed it."""
    return entry["key"], entry["code"]


def answer_of(entry: Mapping[str, Any]) -> tuple[Any, ...]:
    """What must not depend on a constant: verdict and names."""
    return entry["verdict"], sorted(entry["names"])


def read(journal: Path) -> list[dict[str, Any]]:
    """All lines of a journal; none when the file does not exist."""
    if not journal.exists():
        return []
    packed = journal.suffix == ".gz"
    text = gzip.decompress(journal.read_bytes()) if packed else journal.read_bytes()
    return [json.loads(line) for line in text.splitlines()]


def publish(entries: Sequence[Mapping[str, Any]], journal: Path) -> None:
    """Write a journal to one compressed file, reproducible byte for byte."""
    lines = sorted({json.dumps(entry, sort_keys=True) for entry in entries})
    with journal.open("wb") as raw, gzip.GzipFile("", "wb", 9, raw, 0) as stream:
        stream.write(("\n".join(lines) + "\n").encode())


def sorted_out(entries: Sequence[dict[str, Any]]) -> Found:
    """Results by constant and factor, with every campaign once."""
    once = {json.dumps(e, sort_keys=True): e for e in entries}
    out: dict[str, dict[float, list[dict[str, Any]]]] = {}
    for entry in once.values():
        out.setdefault(entry["constant"], {}).setdefault(entry["factor"], []).append(entry)
    return out


def main(arguments: list[str] | None = None) -> int:
    p = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    p.add_argument("--write", type=Path, metavar="FILE", help="write the table to a file")
    p.add_argument("--journal", type=Path, default=JOURNAL, help="of a study")
    o = p.parse_args(arguments)
    entries = [*read(PUBLISHED), *read(o.journal)]
    text = page(sorted_out(entries))
    if o.write:
        o.write.write_text(text, encoding="utf-8")
        if entries:
            publish(entries, PUBLISHED)
    else:
        print(text)
    return 0


if __name__ == "__main__":
    raise SystemExit(main())
