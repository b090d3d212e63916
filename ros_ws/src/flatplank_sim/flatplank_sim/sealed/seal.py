# SPDX-License-Identifier: Apache-2.0
"""Writes and reads the sealed answer of a challenge.

A sealed file, `answer.sealed`, is JSON: `{"format": "flatplank-sealed/1", "answer": TEXT}`, TEXT
being base64 of zlib of this JSON:

    {"seed": 7, "tire": "toyo", "effects": [{"name": "road_play", "size": 0.0009,
     "unit": "m", "class": ["..."]}], "outside": {"coordinate": "plank position",
     "range": [2.0, 2.8], "period": null} or null, "notes": "..."}

`class` holds relatives: effects that the author of the answer considers similar. They are
reported, and do not count as right. Optional: `runs` of an effect (runs to which its size refers),
`present` (true effects of the tire that are not asked for), `force` (name of the force outside the
library, empty: none). No effects and no `outside` means that nothing is hidden. The seal prevents
reading by accident; it is no encryption. The analysis never reads the file.

`plant.yaml` next to it has the same machine for the simulated bench, sealed in the same way.
"""

from __future__ import annotations

import json
from collections.abc import Mapping
from pathlib import Path
from typing import Any

from flatplank_data.errors import FlatplankError
from flatplank_sim.plant.yamlconfig import decode_word, encode_as_word

FORMAT = "flatplank-sealed/1"
NAME = "answer.sealed"
PLANT = "plant.yaml"


def seal(answer: Mapping[str, Any], folder: str | Path) -> Path:
    """Write an answer, encoded so that it is not read by accident."""
    path = Path(folder) / NAME
    path.write_text(json.dumps({"format": FORMAT, "answer": encode_as_word(answer)}) + "\n")
    return path


def seal_plant(overlay: Mapping[str, Any], folder: str | Path) -> Path:
    """Write the overrides of the plant for `--plant`, encoded so that they are not read by
    accident."""
    path = Path(folder) / PLANT
    path.write_text(f"sealed: {encode_as_word(overlay)}\n")
    return path


def unseal(folder: str | Path) -> dict[str, Any]:
    """Read the sealed answer of a campaign folder."""
    path = Path(folder) / NAME
    try:
        raw = json.loads(path.read_text(encoding="utf-8"))
        if raw.get("format") != FORMAT:
            raise FlatplankError(f"is not of format {FORMAT}", str(path), "make it again")
        return decode_word(raw["answer"])
    except FileNotFoundError as error:
        raise FlatplankError(
            "nothing is sealed here", str(path), "`flatplank simulate --hidden SEED` seals"
        ) from error
    except (ValueError, KeyError, AttributeError) as error:
        raise FlatplankError("is damaged", str(path), "make the campaign again") from error
