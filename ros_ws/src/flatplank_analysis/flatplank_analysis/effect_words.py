# SPDX-License-Identifier: Apache-2.0
"""Words of effects and of their parameters, as their declarations say them."""

from __future__ import annotations

from collections.abc import Iterable

from flatplank_analysis.discovery.effect import Effect
from flatplank_analysis.effects.grammar.parameter_words import WORDS
from flatplank_analysis.effects.registry import library
from flatplank_analysis.slip_sweeps.effects import effects as effects_of_sweeps
from flatplank_analysis.word import Word


def sweep_effects() -> dict[str, Word]:
    """Effects that only sweeps show, by identifier."""
    return {e.identifier: e.word() for e in effects_of_sweeps()}


def parameters() -> dict[str, Word]:
    """Parameters of all effects, those of sweeps and of proposals included, by
    `effect.parameter`."""
    return {
        **{f"proposed.{name}": word for name, word in WORDS.items()},
        **_parameters_of(effects_of_sweeps()),
        **_parameters_of(library().values()),
    }


def _parameters_of(effects: Iterable[type[Effect]]) -> dict[str, Word]:
    return {f"{e.identifier}.{p.name}": p.word for e in effects for p in e.parameters()}
