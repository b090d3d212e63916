# SPDX-License-Identifier: Apache-2.0
"""Posterior over the sets of effects that were weighed."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from scipy.special import logsumexp
from scipy.stats import norm

from flatplank_analysis.discovery.fit import Term
from flatplank_analysis.discovery.steps import Rival
from flatplank_analysis.inference.weigh import Weighed

NAMED = 0.95
"""probability from which on an effect, or a class, is named"""
MEMBER = 0.05
"""probability of a member of a class, relative to the likeliest one"""

LARGEST_LOG = 700.0
"""logarithm of the largest odds that are told apart: a number of a computer holds no larger one"""

Key = tuple[str, ...]


def log_evidence(excess: float, volume: float, freedom: float, dispersion: float) -> float:
    """Logarithm of the evidence of a set, relative to the set with the least sum of squares.

    The level of the noise is known with `freedom` degrees of freedom, so that its tails are those
    of Student: a set that fits badly is improbable, and not by the square of what it leaves.

    Args:
        excess: sum of squares beyond the least one, in units of the noise.
        volume: logarithm of posterior over prior volume.
        freedom: degrees of freedom of the noise level.
        dispersion: typical scatter of sizes among repeats, relative to the noise model.
    """
    scaled = excess / max(dispersion, 1.0)
    return volume - 0.5 * freedom * math.log1p(scaled / freedom)


def consequence(term: Term) -> float:
    """Size of an effect, in sizes of least consequence: of several sizes the largest counts."""
    main, named = term.effect.main_parameter(), term.named()
    others = [p for p in term.effect.linear() if p.matters and p.name != main.name]
    each = [abs(named[p.name] - p.null) / p.matters for p in others]
    return max([abs(term.size) / main.matters, *each]) if main.matters else math.inf


@dataclass(frozen=True)
class Posterior:
    """Probabilities of sets of effects, of single effects, and of nothing."""

    sets: Mapping[Key, Weighed]
    freedom: float
    dispersion: float

    @cached_property
    def least(self) -> np.ndarray:
        """(sizes,) least sum of squares for each size of the model errors."""
        return np.min([[chi2 for chi2, _ in w.parts] for w in self.sets.values()], axis=0)

    @cached_property
    def parts(self) -> dict[Key, np.ndarray]:
        """Logarithm of the evidence by set (sizes,) for each size of the model errors.

        Sets are compared at one size by `log_evidence`. The sizes among themselves are not: a
        larger one changes the volume of all data, beside which a tail of Student is small.
        """
        between = -0.5 * self.least / max(self.dispersion, 1.0)
        return {
            key: np.array([
                at + log_evidence(chi2 - low, volume, self.freedom, self.dispersion)
                for at, low, (chi2, volume) in zip(between, self.least, w.parts, strict=True)
            ])
            for key, w in self.sets.items()
        }  # fmt: skip

    @cached_property
    def logs(self) -> dict[Key, float]:
        """Logarithm of the evidence by set, relative to the best set."""
        raw = {key: float(logsumexp(parts)) for key, parts in self.parts.items()}
        best = max(raw.values())
        return {key: value - best for key, value in raw.items()}

    @cached_property
    def likeliest(self) -> int:
        """Number of the size of the model errors at which the best set is likeliest."""
        return int(np.argmax(self.parts[self.best.key]))

    def fit_and_price(self, weighed: Weighed) -> tuple[float, float]:
        """Smallest sum of squares, and volume, of a set at the likeliest size."""
        return weighed.parts[self.likeliest]

    @cached_property
    def probability(self) -> dict[Key, float]:
        """Probability of each set, the likeliest first."""
        odds = {key: math.exp(value) for key, value in self.logs.items()}
        total = sum(odds.values())
        return {k: odds[k] / total for k in sorted(odds, key=odds.__getitem__, reverse=True)}

    @property
    def best(self) -> Weighed:
        """The likeliest set."""
        return self.sets[next(iter(self.probability))]

    def in_set(self, names: Iterable[str], count: int = 1) -> float:
        """Probability that at least `count` of these effects, several of one name counted each,
        are present at a size of consequence, and are no unknown faults."""
        wanted = set(names)
        return sum(
            p * _at_least(count, self._members(self.sets[k], wanted))
            for k, p in self.probability.items()
        )

    @cached_property
    def marginal(self) -> dict[str, float]:
        """Probability of each effect at a size of consequence, the likeliest first."""
        names = {name for key in self.sets for name in key}
        each = {name: self.in_set([name]) for name in names}
        return dict(sorted(each.items(), key=lambda item: -item[1]))

    @cached_property
    def nothing(self) -> float:
        """Probability that no effect of consequence is present; a law of another form is none."""
        return self._none_of(lambda term: not term.effect.generic)

    @cached_property
    def law_only(self) -> float:
        """Probability that a law of another form is all that is present with consequence."""
        return self.nothing - self._none_of(lambda term: True)

    def _none_of(self, counts: Callable[[Term], bool]) -> float:
        """Probability that none of the effects that count is present with consequence."""
        total = 0.0
        for key, p in self.probability.items():
            weighed = self.sets[key]
            places = [i for i, term in enumerate(weighed.fit.terms) if counts(term)]
            total += p * (1.0 - _at_least(1, (self.matters(weighed, i) for i in places)))
        return total

    def without(self, weighed: Weighed, index: int) -> Weighed | None:
        """The set that lacks one effect of a set; None where it was not weighed."""
        return self.sets.get(_without(weighed.key, weighed.names[index]))

    def towards_null(self, weighed: Weighed, index: int) -> float:
        """Standard deviation of an effect, relative to its size, on the side of its null, by what
        its absence leaves: a gap changes little by a little more of it, much by its absence."""
        drop = weighed.unknown[index][0][0] - weighed.parts[weighed.rank][0]
        if drop > 0.0:
            return math.sqrt(max(self.dispersion, 1.0) / drop)
        size, spread = weighed.sizes[index]
        return spread / max(abs(size), 1e-30)

    def known(self, weighed: Weighed, index: int) -> float:
        """Probability that an effect of a set is the one of the library, and neither scatter about
        zero nor an unknown fault, see `Weighed.unknown`."""
        parts = (weighed.parts[weighed.rank], *weighed.unknown[index])
        least = min(chi2 for chi2, _ in parts)
        logs = [
            log_evidence(chi2 - least, volume, self.freedom, self.dispersion)
            for chi2, volume in parts
        ]
        return math.exp(logs[0] - float(logsumexp(logs)))

    def matters(self, weighed: Weighed, index: int) -> float:
        """Probability that an effect is of consequence, in a set."""
        size, spread = consequence(weighed.fit.terms[index]), self.towards_null(weighed, index)
        if size == 0.0:
            return 0.0
        low, high = norm.cdf([(-1.0 / size - 1.0) / spread, (1.0 / size - 1.0) / spread])
        return float(1.0 - high + low)

    def _members(self, weighed: Weighed, wanted: set[str]) -> list[float]:
        """Of each effect of a set with one of these names, the probability that it is the one of
        the library, of a size of consequence."""
        places = [i for i, name in enumerate(weighed.names) if name in wanted]
        return [self.matters(weighed, i) * self.known(weighed, i) for i in places]

    def alternatives(self, weighed: Weighed, index: int) -> list[tuple[Weighed, int, float]]:
        """What may stand for effect `index` of a set: each effect that in its place is better than
        none. The likeliest set with it and without the first, the place of the effect there, and
        the odds of all such sets against those with the first; the likeliest first.

        Beside the other effect another law may be needed, or none: the odds are those of all sets.
        """
        own = weighed.names[index]
        rest, count = _without(weighed.key, own), weighed.key.count(own)
        having = [key for key in self.sets if key.count(own) >= count]
        others = sorted(self.sets.keys() - having, key=self.logs.__getitem__, reverse=True)
        out = []
        more = (n for key in others for n in key if key.count(n) > weighed.key.count(n))
        for name in dict.fromkeys(more):
            instead = self.logs.get(tuple(sorted((*rest, name))), -math.inf)
            if instead <= self.logs.get(rest, -LARGEST_LOG):
                continue
            keys = [key for key in others if key.count(name) > weighed.key.count(name)]
            other = self.sets[keys[0]]
            place = len(other.names) - 1 - other.names[::-1].index(name)
            out.append((other, place, self._odds(keys, having)))
        return sorted(out, key=lambda item: -item[2])

    def _odds(self, keys: Iterable[Key], others: Iterable[Key]) -> float:
        """Odds of some sets against others."""
        one, two = (logsumexp([self.logs[k] for k in some]) for some in (keys, others))
        return math.exp(min(float(one - two), LARGEST_LOG))

    def rivals(self, weighed: Weighed, index: int) -> tuple[Rival, ...]:
        """The same as rivals of the effect, of those whose size may be of consequence."""
        return tuple(
            Rival(other.stated(place), odds, odds < MEMBER)
            for other, place, odds in self.alternatives(weighed, index)
            if self.matters(other, place) > MEMBER
        )

    def excess(self, weighed: Weighed, other: Weighed) -> float:
        """Sum of squares that a set leaves more than another one, at the likeliest size."""
        return self.fit_and_price(weighed)[0] - self.fit_and_price(other)[0]


def _without(key: Key, name: str) -> Key:
    left = list(key)
    left.remove(name)
    return tuple(left)


def _at_least(count: int, probabilities: Iterable[float]) -> float:
    """Probability that at least `count` of some independent events happen."""
    each = np.ones(1)
    for p in probabilities:
        each = np.convolve(each, [1.0 - p, p])
    return float(each[count:].sum())
