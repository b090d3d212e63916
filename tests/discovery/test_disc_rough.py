# SPDX-License-Identifier: Apache-2.0
"""Which sets are fitted to the end after a rough fit."""

from __future__ import annotations

from types import SimpleNamespace

import numpy as np
import pytest
from shapes import LONG, OTHER

from flatplank_analysis.discovery.fit import Term
from flatplank_analysis.inference.explore import Explorer
from flatplank_analysis.inference.weigh import Weighed


def weighed(log: float, *effects) -> Weighed:
    """A set whose evidence lies in its fit."""
    terms = tuple(Term(effect, np.array([0.1])) for effect in effects)
    sizes = ((0.1, 0.01),) * len(terms)
    return Weighed(SimpleNamespace(terms=terms), ((-2.0 * log, 0.0),), sizes)


class Scales:
    """Weighs one effect after the other: roughly first, better when it is fitted again."""

    state = SimpleNamespace(runs=None)
    freedom, dispersion = 1e6, 1.0

    def __init__(self, rough: float, fitted: float) -> None:
        self.logs, self.again = {"rough": rough, "fitted": fitted}, 0

    def with_term(self, _fit, term, _most):
        return weighed(self.logs["rough"], term.effect)

    def fitted(self, fit):
        self.again += 1
        return weighed(self.logs["fitted"], fit.terms[0].effect)


@pytest.mark.parametrize(
    ("rough", "again"),
    [(-410.0, 1), (-496.0, 1), (-640.0, 1), (-710.0, 0), (-900.0, 0), (-1010.0, 1)],
)
def test_a_set_that_is_nearer_to_the_best_than_to_nothing_is_fitted_on(rough, again):
    """From nothing (-1000) to the best set (-400). Two Jacobians from its start an asymmetry of
    the friction was 96 behind a loss of load, and 28 before it at the end."""
    scales = Scales(rough, -300.0)
    explorer = Explorer(scales)
    nothing = weighed(-1000.0)
    for known in (nothing, weighed(-400.0, OTHER)):
        explorer.keep(known)
    explorer._weigh(nothing.fit, Term(LONG, np.zeros(1)))
    assert scales.again == again
    best = ["long"] if again else ["other"]
    assert explorer.posterior.best.names == best
