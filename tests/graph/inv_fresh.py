# SPDX-License-Identifier: Apache-2.0
"""Investigations by the real command of what a seed hides that nobody has looked at."""

from __future__ import annotations

import json
import math
import secrets
import subprocess
import sys
from pathlib import Path

from flatplank_analysis.investigation.evidence import ALPHA
from flatplank_sim.cli import reveal
from flatplank_sim.sealed.generate import make_challenge
from flatplank_sim.sealed.seal import unseal

VERB = (
    "import sys; from flatplank_control.cli.investigate import main; sys.exit(main(sys.argv[1:]))"
)
MINUTES = "150"


def fresh_challenge(folder: Path) -> Path:
    """In which something is hidden: by another seed every time."""
    number = 0
    while True:
        made = make_challenge(folder / str(number), secrets.randbelow(2**31))
        if unseal(made)["effects"]:
            return made
        number += 1


def investigated(folder: Path, challenge: Path, *words: str) -> None:
    """Without a hand on the keyboard it must be right, confirmed and reported."""
    command = [sys.executable, "-c", VERB, str(folder), "--minutes", MINUTES, "--json", *words]
    done = subprocess.run(command, capture_output=True, text=True, stdin=subprocess.DEVNULL)
    seed = f"simulate DIR --hidden {unseal(challenge)['seed']}"
    assert done.returncode == 0, (seed, done.stderr)
    told = json.loads(done.stdout)
    diagnosis = folder / "investigation" / "diagnosis" / "diagnosis.json"
    assert reveal.main([str(challenge), "--diagnosis", str(diagnosis)]) == 0, (seed, told)
    assert told["log_e"] >= -math.log(ALPHA), (seed, told)
    assert told["minutes"] <= float(MINUTES)
    notebook = (folder / "investigation.txt").read_text()
    assert "over the whole loop, at least the e = 20" in notebook
    print(f"{seed}\n{notebook}")
