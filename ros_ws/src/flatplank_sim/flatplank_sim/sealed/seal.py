# SPDX-License-Identifier: Apache-2.0
"""Sealed challenges: the answer beside a campaign.

A sealed file, `answer.sealed`, is JSON: `{"format": "flatplank-sealed/1", "answer": TEXT}`, TEXT
being base64 of zlib of this JSON:

    {"seed": 7, "tire": "bristles", "effects": [{"name": "road_play", "size": 0.0009,
     "unit": "m", "class": ["..."]}], "outside": {"coordinate": "plank position",
     "range": [2.0, 2.8], "period": null} or null, "notes": "..."}

`class` holds relatives: effects that the person who wrote the answer thinks to be alike. They are
told, and are not right. No effects and no outside means that nothing is hidden. The seal keeps
eyes off, it does not keep secrets: nothing in the analysis reads the file.

Beside it lies `plant.yaml`, the same machine for the simulated bench, sealed alike.
"""

from __future__ import annotations

import json
from collections.abc import Mapping
from pathlib import Path
from typing import Any

from flatplank_data.errors import FlatplankError
from flatplank_sim.plant.yamlconfig import pack, unpack

FORMAT = "flatplank-sealed/1"
NAME = "answer.sealed"
PLANT = "plant.yaml"


def seal(answer: Mapping[str, Any], folder: str | Path) -> Path:
    """Write an answer so that it is not read by accident."""
    path = Path(folder) / NAME
    path.write_text(json.dumps({"format": FORMAT, "answer": pack(answer)}) + "\n")
    return path


def seal_plant(overlay: Mapping[str, Any], folder: str | Path) -> Path:
    """Write what is laid over the plant's own, so that `--plant` reads it and nobody else."""
    path = Path(folder) / PLANT
    path.write_text(f"sealed: {pack(overlay)}\n")
    return path


def unseal(folder: str | Path) -> dict[str, Any]:
    """Open the sealed answer of a campaign folder."""
    path = Path(folder) / NAME
    try:
        raw = json.loads(path.read_text(encoding="utf-8"))
        if raw.get("format") != FORMAT:
            raise FlatplankError(f"is not of format {FORMAT}", str(path), "make it again")
        return unpack(raw["answer"])
    except FileNotFoundError as error:
        raise FlatplankError(
            "nothing is sealed here", str(path), "`flatplank simulate --hidden SEED` seals"
        ) from error
    except (ValueError, KeyError, AttributeError) as error:
        raise FlatplankError("is damaged", str(path), "make the campaign again") from error
