# SPDX-License-Identifier: Apache-2.0
"""What a verb says for programs."""

from __future__ import annotations

import io
import json
from collections.abc import Callable, Sequence
from contextlib import redirect_stdout
from typing import Any


def asked(verb: Callable[[Sequence[str]], int], *arguments: object) -> Any:
    """The JSON that a verb prints; it ends with exit code 0."""
    with redirect_stdout(io.StringIO()) as said:
        assert verb([*map(str, arguments), "--json"]) == 0
    return json.loads(said.getvalue())
