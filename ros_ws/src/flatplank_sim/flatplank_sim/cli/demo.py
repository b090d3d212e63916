# SPDX-License-Identifier: Apache-2.0
"""The main job from end to end on the simulated bench: measure, fit, report, find a hidden
effect.
"""

from __future__ import annotations

import argparse
from pathlib import Path

from flatplank_data.arguments import Parser
from flatplank_sim.demo import discover, evaluate
from flatplank_sim.demo.measure import measure
from flatplank_sim.demo.steps import Teller


def parser() -> argparse.ArgumentParser:
    p = Parser(prog="flatplank demo", description=__doc__)
    p.add_argument("--out", type=Path, default=Path("demo"), help="folder for everything it makes")
    p.add_argument("--seed", type=int, default=1, help="of the simulated bench")
    p.add_argument("--hidden", type=int, default=4, help="seed of the sealed challenge")
    p.add_argument("--jobs", type=int, help="processes; default: all cores")
    return p


def main(argv: list[str]) -> int:
    """Exit code 0: everything was made; the last lines say what was found and where it is."""
    o = parser().parse_args(argv)
    out = o.out.resolve()
    teller = Teller(steps=7)
    campaign = out / "campaign"
    radius = measure(campaign, o.seed, o.jobs, teller)
    page, found = evaluate.fit_and_report(campaign, out / "report", o.jobs, teller)
    challenge = discover.sealed_challenge(out / "challenge", o.hidden, teller)
    teller.close(
        [
            f"effective rolling radius (free-rolling controller, Toyo, 3700 N): {radius:.4f} m",
            *found,
            *challenge,
            f"report:   {page}",
            f"bags:     {campaign}",
        ]
    )
    return 0
