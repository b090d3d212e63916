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
"""

from __future__ import annotations

import base64
import json
import zlib
from collections.abc import Mapping
from pathlib import Path
from typing import Any

from flatplank_analysis.errors import FlatplankError

FORMAT = "flatplank-sealed/1"
NAME = "answer.sealed"


def seal(answer: Mapping[str, Any], folder: str | Path) -> Path:
    """Write an answer so that it is not read by accident."""
    packed = base64.b64encode(zlib.compress(json.dumps(answer, sort_keys=True).encode()))
    path = Path(folder) / NAME
    path.write_text(json.dumps({"format": FORMAT, "answer": packed.decode()}) + "\n")
    return path


def unseal(folder: str | Path) -> dict[str, Any]:
    """Open the sealed answer of a campaign folder."""
    path = Path(folder) / NAME
    try:
        raw = json.loads(path.read_text(encoding="utf-8"))
        if raw.get("format") != FORMAT:
            raise FlatplankError(f"is not of format {FORMAT}", str(path), "make it again")
        return dict(json.loads(zlib.decompress(base64.b64decode(raw["answer"]))))
    except FileNotFoundError as error:
        raise FlatplankError(
            "nothing is sealed here", str(path), "`flatplank simulate --hidden SEED` seals"
        ) from error
    except (ValueError, KeyError, AttributeError, zlib.error) as error:
        raise FlatplankError("is damaged", str(path), "make the campaign again") from error
