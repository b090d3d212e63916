# SPDX-License-Identifier: Apache-2.0
"""Open the sealed answer of a challenge and score the diagnosis against it."""

from __future__ import annotations

import json
from collections.abc import Mapping
from pathlib import Path
from typing import Any

from flatplank_analysis.cli.arguments import Parser
from flatplank_analysis.wording import plain, quantity
from flatplank_sim.sealed.score import score
from flatplank_sim.sealed.seal import unseal

DIAGNOSIS = "diagnosis.json"


def text_of(answer: Mapping[str, Any], points: Mapping[str, Any]) -> list[str]:
    """The answer and the score in words."""
    hidden = [f"{e['name']}, {quantity(e['size'], e['unit'], 4)}" for e in answer["effects"]]
    hidden += [_outside(answer["outside"])] if answer.get("outside") else []
    lines = [f"hidden: {'; '.join(hidden) or 'nothing'}"]
    lines += [_effect(e) for e in points["effects"]]
    if points["outside_found"] is not None:
        lines.append(f"its place was {'' if points['outside_found'] else 'not '}found")
    if points["false"]:
        lines.append(f"named without cause: {', '.join(points['false'])}")
    return [*lines, "the diagnosis is right" if points["right"] else "the diagnosis is not right"]


def _effect(e: Mapping[str, Any]) -> str:
    """What became of one hidden effect."""
    if not e["named"]:
        kin = f"; {e['kin']} was named, which is like it but not it" if e["kin"] else ""
        return f"not found: {e['name']}{kin}"
    how = e["as"] if e["as"] == e["name"] else f"one of the group of {e['as']}"
    if not e["comparable"]:
        return f"found as {how}, whose size is another quantity"
    inside = "covers" if e["covered"] else "misses"
    off = "" if e["error"] is None else f" ({100 * e['error']:+.0f} %)"
    return f"found as {how}: {plain(e['size'], 4)}{off}, its interval {inside} the truth"


def _outside(what: Mapping[str, Any]) -> str:
    low, high = what["range"]
    period = f", period {what['period']:.3g}" if what.get("period") else ""
    return f"outside the library: over {what['coordinate']} {low:.3g} .. {high:.3g}{period}"


def read_diagnosis(path: Path, folder: Path) -> dict[str, Any]:
    """The JSON of a diagnosis; ValueError says what is wrong with the file."""
    remedy = f"make one with `flatplank diagnose {folder} --out {path}`"
    if not path.is_file():
        raise ValueError(f"{path}: no diagnosis; {remedy}")
    try:
        data = json.loads(path.read_text(encoding="utf-8"))
    except ValueError as error:
        raise ValueError(f"{path}: not JSON ({error}); {remedy}") from None
    keys = {"name", "size", "interval"}
    whole = isinstance(data, dict) and "verdict" in data and isinstance(data.get("effects"), list)
    if not whole or not all(isinstance(e, dict) and keys <= set(e) for e in data["effects"]):
        raise ValueError(f"{path}: is not what diagnose writes; {remedy}")
    return data


def main(argv: list[str]) -> int:
    """Exit code 0: right; 1: not right."""
    p = Parser(prog="flatplank reveal", description=__doc__)
    p.add_argument("folder", type=Path, help="made by `flatplank simulate DIR --hidden SEED`")
    p.add_argument("--diagnosis", type=Path, help=f"JSON of diagnose; default: DIR/{DIAGNOSIS}")
    p.add_argument("--json", action="store_true", help="print JSON for programs")
    o = p.parse_args(argv)
    path = o.diagnosis or o.folder / DIAGNOSIS
    diagnosis = read_diagnosis(path, o.folder)
    answer = unseal(o.folder)
    points = score(diagnosis, answer)
    if o.json:
        print(json.dumps({"answer": answer, "score": points}, indent=1))
    else:
        print("\n".join(text_of(answer, points)))
    return 0 if points["right"] else 1
