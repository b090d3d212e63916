# SPDX-License-Identifier: Apache-2.0
"""The sealed answer: not secret, but not to be read by accident."""

from __future__ import annotations

import base64
import json
import zlib
from collections.abc import Mapping
from pathlib import Path
from typing import Any

FILE_NAME = "answer.sealed"
FORMAT = "flatplank-sealed/1"


def seal(folder: Path, answer: Mapping[str, Any]) -> Path:
    """Write the answer into a campaign folder."""
    content = base64.b64encode(zlib.compress(json.dumps(answer).encode())).decode()
    path = folder / FILE_NAME
    path.write_text(json.dumps({"format": FORMAT, "answer": content}) + "\n", encoding="utf-8")
    return path


def unseal(folder: Path) -> dict[str, Any]:
    """Read the answer of a campaign folder."""
    path = folder / FILE_NAME
    if not path.is_file():
        raise ValueError(
            f"{path}: no sealed answer; make a challenge with `flatplank simulate DIR --hidden SEED`"
        )
    try:
        sealed = json.loads(path.read_text(encoding="utf-8"))
        if sealed["format"] != FORMAT:
            raise ValueError(sealed["format"])
        return json.loads(zlib.decompress(base64.b64decode(sealed["answer"])))
    except (ValueError, KeyError, zlib.error) as error:
        raise ValueError(f"{path}: damaged ({error}); make the challenge again") from None
