# SPDX-License-Identifier: Apache-2.0
"""The search for what a model of one's own lacks."""

from __future__ import annotations

import sys
from collections.abc import Callable, Sequence
from typing import Any

from flatplank_analysis.api.diagnosis import Diagnosed
from flatplank_analysis.cli import loop
from flatplank_analysis.discovery.effect import Effect
from flatplank_analysis.discovery.model import Model
from flatplank_analysis.discovery.search import Options, run_search
from flatplank_analysis.discovery.verdict import diagnose
from flatplank_data.errors import FlatplankError


def explain(model: Model, effects: Sequence[type[Effect]]) -> Diagnosed:
    """Which of these effects a model of one's own lacks, with the floor and the verdict.

    model: a `Motion` with its records, or anything that predicts (docs/discovery.md).
    """
    result = diagnose(run_search(model, list(effects), Options(progress=loop.progress)))
    loop.progress_done()
    return Diagnosed(result, type(model).__name__, ())


def script(main: Callable[..., Any], *arguments: Any) -> None:
    """Run a function as a program: what is wrong with its data is one line, and exit code 1."""
    try:
        main(*arguments)
    except FlatplankError as error:
        sys.exit(str(error))
    except KeyError as error:
        sys.exit(f"the data have no {error}")
