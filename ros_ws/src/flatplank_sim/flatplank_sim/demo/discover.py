# SPDX-License-Identifier: Apache-2.0
"""The demo's sealed challenge: measure, fail, diagnose, add, watch the error fall, reveal."""

from __future__ import annotations

import json
from pathlib import Path

from flatplank_analysis.contact_patch.session import Session
from flatplank_analysis.discovery.modelfile import ModelFile, save_model
from flatplank_analysis.discovery.report.page import write_report
from flatplank_data.files import write_atomic
from flatplank_data.wording import quantity
from flatplank_sim.demo.steps import Teller
from flatplank_sim.sealed.generate import make_challenge
from flatplank_sim.sealed.score import score
from flatplank_sim.sealed.seal import unseal
from flatplank_sim.sealed.words import DIAGNOSIS, text_of


def sealed_challenge(folder: Path, seed: int, teller: Teller) -> list[str]:
    """Goes once around the loop; what was found, in words."""
    teller.step("a sealed challenge: a campaign with something hidden")
    make_challenge(folder, seed, teller.count)
    teller.step("diagnose: where the model fails, and which effect is missing")
    session = Session.open(folder, [])
    result = session.diagnose(None, lambda text, share: teller.now(f"{share:4.0%} {text}"))
    data = result.to_dict()
    write_atomic(folder / DIAGNOSIS, json.dumps(data, indent=1) + "\n")
    lines = [
        f"challenge: verdict {data['verdict']}, error {data['rmse_before']:.1f} N, "
        f"floor {data['floor_rmse']:.1f} N"
    ]
    teller.step("add what was found, watch the error fall, open the answer")
    model = ModelFile(campaign=str(folder))
    for effect in data["effects"]:
        model, _, n = session.add(model, effect["name"])
        save_model(model, folder / "model.yaml")
        lines.append(
            f"  + {effect['name']} {quantity(n['size'], n['unit'])}: error "
            f"{n['rmse_before']:.1f} -> {n['rmse']:.1f} N (held out {n['held_out']:.1f} N)"
        )
        teller.now(lines[-1].strip())
    page = write_report(result, folder / "report", session.campaign.path, model.history)
    answer = unseal(folder)
    lines += [f"  {line}" for line in text_of(answer, score(data, answer))]
    return [*lines, f"diagnosis: {page}"]
