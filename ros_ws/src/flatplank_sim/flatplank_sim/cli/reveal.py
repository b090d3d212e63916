# SPDX-License-Identifier: Apache-2.0
"""Open a challenge's sealed answer and score the diagnosis."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

from flatplank_data.arguments import Parser, add_json
from flatplank_sim.sealed.score import DIAGNOSIS, score, text_of
from flatplank_sim.sealed.seal import unseal


def read_diagnosis(path: Path, folder: Path) -> dict[str, Any]:
    """Read the JSON of a diagnosis; ValueError names what is wrong with the file."""
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
    """Print answer and score; return 0 when the diagnosis is right, else 1."""
    p = Parser(prog="flatplank reveal", description=__doc__)
    p.add_argument("folder", type=Path, help="made by `flatplank simulate DIR --hidden SEED`")
    p.add_argument("--diagnosis", type=Path, help=f"JSON of diagnose; default: DIR/{DIAGNOSIS}")
    add_json(p)
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
