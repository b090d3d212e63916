# SPDX-License-Identifier: Apache-2.0
"""The steps from a bench that rests to one that measures, each judged by what the bench says."""

from __future__ import annotations

from collections.abc import Mapping
from typing import NamedTuple


class Step(NamedTuple):
    """One step: what is so when it is done, and what to do until then."""

    title: str
    to_do: str
    done: bool


def steps(in_charge: bool, words: Mapping[str, str], zero_taken: bool) -> dict[str, Step]:
    """Steps in their order; `words`: texts of `BenchState.state_texts`."""
    running = "cycle" in words
    return {
        "charge": Step(
            "This page is in charge", "Take charge: one page at a time gives commands.", in_charge
        ),
        "bench": Step(
            "The bench runs", "Choose its kind and what is below, then start it.", running
        ),
        "health": Step(
            "The bus answers", "See the tab Bus: it names the drive and the trouble.",
            words.get("health") == "ok",
        ),
        "estop": Step(
            "The emergency stop is released",
            "Look that nobody is at the wheel and the plank, then release the button.",
            words.get("estop") == "released",
        ),
        "zero": Step(
            "The bridges have their zero",
            "Lift the wheel and let the plank rest; the mean of some samples becomes the zero.",
            running and zero_taken,
        ),
        "enable": Step(
            "The drive is enabled", "The wheel may turn from now on: hands off.",
            words.get("state") == "operation enabled",
        ),
    }  # fmt: skip


def next_of(all_steps: Mapping[str, Step]) -> str:
    """Name of the first step that is not done; empty when the bench is ready."""
    return next((name for name, step in all_steps.items() if not step.done), "")
