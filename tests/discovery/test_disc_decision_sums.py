# SPDX-License-Identifier: Apache-2.0
"""Screening and the tests of a decision, against the same numbers in plain linear algebra."""

from __future__ import annotations

from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest
from draws import GROUPS, RUNS, numbers, without
from scipy.stats import f as f_distribution
from shapes import CONDITIONS, LONG, REPEATS, shape

from flatplank_analysis.discovery import decide, screen, size_errors
from flatplank_analysis.discovery.fit import Term
from flatplank_analysis.discovery.gram import Gram, Metric
from flatplank_analysis.discovery.model import FormError
from flatplank_analysis.discovery.noise import ChannelNoise, Whitener
from flatplank_analysis.discovery.state import Candidate, channel_weights

PAIR = shape("pair", LONG.form, bound=0.04)


def candidate(columns: np.ndarray, effect=LONG) -> Candidate:
    return Candidate(effect, {}, columns)


def screened(products: np.ndarray, *owned: list[int]) -> tuple[screen.Screen, list]:
    """A screen of candidates that own some of these projected columns."""
    items = []
    for rows in owned:
        mix = np.zeros(len(products))
        mix[rows] = 1.0
        info = products[np.ix_(rows, rows)]
        items.append(screen.ScreenResult(candidate(np.zeros(0)), mix[rows], 1.0, 1.0, info, mix))
    return SimpleNamespace(projected=products), items


def test_likeness_is_the_cosine_between_columns():
    a = np.array([[1.0, 0.0, 0.0], [0.6, 0.8, 0.0], [0.0, 2.0, 0.0], [0.0, 0.0, 0.0]])
    result, (one, other, third, plane, none) = screened(a @ a.T, [0], [1], [2], [1, 2], [3])
    assert screen.likeness(result, one, other) == pytest.approx(0.6)
    assert screen.likeness(result, other, third) == pytest.approx(0.8)
    assert screen.likeness(result, one, third) == pytest.approx(0.0, abs=1e-7)
    assert screen.likeness(result, one, plane) == pytest.approx(1.0)
    assert screen.likeness(result, none, one) == 0.0
    silent = replace(one, contribution=np.zeros(4))
    assert screen.likeness(result, one, silent) == 0.0


def test_screened_size_gain_and_visibility():
    info, score, raw = np.array([[4.0]]), np.array([6.0]), np.array([[10.0]])
    found = screen._judge(candidate(np.zeros(1)), info, score, raw, np.array([1]), 3)
    assert found.visible == pytest.approx(0.4)
    assert found.sizes == pytest.approx([1.5]) and found.gain == pytest.approx(9.0)
    np.testing.assert_allclose(found.contribution, [0.0, 1.5, 0.0])
    # the range is 0.04, two screening steps of 0.02
    held = screen._judge(candidate(np.zeros(1), PAIR), info, 2.0 * score, raw, np.array([0]), 1)
    assert held.sizes == pytest.approx([2.0])
    assert held.gain == pytest.approx(2.0 * 2.0 * 12.0 - 4.0 * 4.0)
    unseen = screen._judge(candidate(np.zeros(1)), 1e-7 * raw, score, raw, np.array([2]), 3)
    assert not unseen.sizes and unseen.gain == 0.0
    np.testing.assert_allclose(unseen.contribution, [0.0, 0.0, 1.0])


def test_sums_along_a_combination_of_columns():
    base, two, e = numbers(20, RUNS, 2, 30), numbers(21, RUNS, 3, 30), numbers(22, RUNS, 30)
    gram = Gram.of(np.concatenate([base, two], axis=1), e)
    item = screened(np.eye(3), [1, 2])[1][0]
    item = replace(item, contribution=np.array([0.0, 2.0, -3.0]))
    found = screen._along(gram, 2, item)
    own = 2.0 * two[:, 1] - 3.0 * two[:, 2]
    wanted = Gram.of(np.concatenate([base, own[:, None]], axis=1), e)
    np.testing.assert_allclose(found.products, wanted.products)
    np.testing.assert_allclose(found.scores, wanted.scores)


@pytest.fixture
def in_stretches():
    """Sums of a base of two and of one effect, whole and in five stretches, and of a force."""
    base, x, force = numbers(30, RUNS, 2, 50), numbers(31, RUNS, 1, 50), numbers(32, RUNS, 1, 50)
    e = numbers(33, RUNS, 50)
    place = np.arange(50) // 10
    pieces = x * (place == np.arange(5)[:, None])
    columns = np.concatenate([base, x, pieces, force], axis=1)
    return Gram.of(columns, e), columns, e


def chi2(columns: np.ndarray, e: np.ndarray) -> float:
    """What least squares leaves; columns (runs, k, n)."""
    flat = np.moveaxis(columns, 1, 0).reshape(columns.shape[1], -1).T
    return float(np.linalg.lstsq(flat, e.ravel(), rcond=None)[1][0])


def test_five_sizes_along_the_run_against_one(in_stretches):
    _, columns, e = in_stretches
    columns = columns[:, :8]
    found, freedom = decide._stretch_test(Gram.of(columns, e), 2)
    assert freedom == 4
    wanted = chi2(columns[:, :3], e) - chi2(np.delete(columns, 2, axis=1), e)
    assert found == pytest.approx(wanted)
    columns[:, 3:5] = 0.0
    assert decide._stretch_test(Gram.of(columns, e), 2)[1] == 2
    columns[:, 5:7] = 0.0
    assert decide._stretch_test(Gram.of(columns, e), 2)[1] == 1


def test_one_size_in_every_condition(in_stretches):
    score, info = numbers(34, RUNS), np.linspace(1.0, 3.0, RUNS)
    info[:REPEATS] = 1e-6
    state = SimpleNamespace(runs=SimpleNamespace(groups=GROUPS))
    found, freedom = decide._condition_test(state, score, info)
    parts = [score[g].sum() ** 2 / info[g].sum() for g in GROUPS[1:]]
    assert found == pytest.approx(sum(parts)) and freedom == CONDITIONS - 2
    info[:REPEATS] = 1e6
    assert decide._condition_test(state, score, info)[1] == 1


def test_what_the_error_rises_by_without_an_effect(in_stretches):
    """The effect is in the prediction: without it the residual holds its column once more."""
    gram, columns, e = in_stretches
    base, x = columns[:, :2], columns[:, 2]
    wanted = chi2(base, e + x) - chi2(columns[:, :3], e)
    assert decide._drop_beside(gram, 2) == pytest.approx(wanted)


def test_what_a_wrong_form_may_leave(monkeypatch):
    """Its column in fifths of its information and in every condition. The share of chi2 by which
    the size differs is the variance of the relative size. The tested one stands aside."""
    direction = numbers(35, 1, RUNS, 50)
    monkeypatch.setattr(decide, "effect_contribution", lambda fit, i: (i + 1.0) * direction)
    runs = SimpleNamespace(groups=GROUPS, runs=RUNS, samples=50)
    judge = decide.Judge(SimpleNamespace(runs=runs), 0.0, None, uneven=((1, 0.25), (2, 0.04)))
    found = judge._uneven_beside(None, 2)
    assert found.columns.shape == (5 + CONDITIONS, 1, RUNS, 50)
    np.testing.assert_allclose(found.strength, 4.0)
    np.testing.assert_allclose(found.columns[:5].sum(axis=0), 2.0 * direction)
    np.testing.assert_allclose(found.columns[5:].sum(axis=0), 2.0 * direction)
    energy = np.sum(found.columns[:5] ** 2, axis=(1, 2, 3))
    assert energy == pytest.approx(np.full(5, energy.mean()), rel=0.15)
    for rows, column in zip(GROUPS, found.columns[5:], strict=True):
        assert np.flatnonzero(np.any(column[0], axis=1)).tolist() == rows.tolist()
    both = judge._uneven_beside(None, 0)
    assert set(both.strength) == {4.0, 25.0} and len(both.columns) == 2 * len(found.columns)
    assert replace(judge, uneven=((2, 0.04),))._uneven_beside(None, 2) is None


def test_the_signals_of_an_effect_are_those_that_others_cannot_imitate():
    """It shows in both channels; another column has its part in the first one."""
    direction = numbers(36, 2, RUNS, 15)
    first = direction * np.array([1.0, 0.0])[:, None, None]
    noise = [ChannelNoise(np.eye(8)[0], np.ones(RUNS))] * 2
    factors = {(0, 0): np.eye(15), (1, 0): np.eye(15)}
    whitener = Whitener(np.arange(15), factors, np.zeros(RUNS, int), noise)
    metric = Metric(whitener, direction[None][:0], np.zeros(0))
    columns = np.stack([numbers(37, 2, RUNS, 15), first, direction])
    gram = metric.gram(direction, columns)
    energy = np.sum(direction**2, axis=(1, 2))

    def shares(*others: int) -> np.ndarray:
        left = size_errors.not_imitated(gram, others, 2, columns[[*others]], direction)
        energies = metric.energies(left)
        return energies / energies.sum()

    assert shares(0) == pytest.approx(energy / energy.sum(), rel=0.1)
    assert shares(1) == pytest.approx((0.0, 1.0))
    both = shares(0, 1)
    assert both == pytest.approx((0.0, 1.0), abs=0.02) and both[0] > 0.0


def test_what_an_error_of_the_law_does_to_a_score(in_stretches):
    """One factor on the signal per condition, or for all of one law, by default half a hundredth,
    on what the base leaves of it."""
    gram, columns, _ = in_stretches
    flat = np.moveaxis(columns[:, :2], 1, 0).reshape(2, -1).T
    x, force = columns[:, 2], columns[:, 8]
    own = without(flat, x.ravel()).reshape(x.shape)
    along = np.sum(own * force, axis=1)
    by_force = size_errors.along(gram, 2)[:, 8:9]
    both, free = [np.concatenate(GROUPS)], np.full(1, np.inf)
    for more, law, groups in (
        ({}, 0.005, GROUPS),
        ({"form": FormError(law=0.03)}, 0.03, GROUPS),
        ({"same_law": both}, 0.005, both),
    ):
        wanted = law**2 * sum(along[g].sum() ** 2 for g in groups)
        assert size_errors.variance_of_law(of_law(**more), by_force, free) == pytest.approx(wanted)
        limit = np.array([0.3 * wanted**0.5])
        found = size_errors.variance_of_law(of_law(**more), by_force, limit)
        assert found == pytest.approx(0.09 * wanted)


def of_law(*largest: float, **more):
    """A state with the largest signals, whose model has more attributes."""
    runs = SimpleNamespace(groups=GROUPS, largest=largest)
    return SimpleNamespace(model=SimpleNamespace(runs=runs, **more), runs=runs)


def test_an_error_of_the_law_leaves_no_more_than_the_form_band():
    """A crosstalk of 6 % that left 67 N was taken for an error of the law of 1 %, which leaves no
    more than 7 N. In each channel: 2 % of 100 and 3 % of 1000 over what is shown of the effect,
    of which the scatter hides half."""
    shown = np.array([4.0, 60.0])[:, None, None] * np.ones((2, RUNS, 5))
    energies = np.array([300.0, 100.0])
    form = FormError(mean=0.02, side=0.03)
    state = of_law(100.0, 1000.0, form=form)
    wanted = [300.0 * 2.0 / 4.0, 100.0 * 30.0 / 60.0]
    assert size_errors.limits_of_form(state, shown, energies, 400.0) == pytest.approx(wanted)
    half = size_errors.limits_of_form(state, shown, energies, 100.0)
    assert half == pytest.approx([0.5 * one for one in wanted])
    # in a channel without the effect, and without a known form, nothing is limited
    shown[1] = 0.0
    found = size_errors.limits_of_form(state, shown, np.array([300.0, 0.0]), 300.0)
    assert found == pytest.approx([wanted[0], np.inf])
    blank = of_law(100.0, 1000.0, form=FormError())
    assert np.isinf(size_errors.limits_of_form(blank, shown, energies, 400.0)).all()


def test_an_error_of_the_law_is_each_channel_s_own():
    """One factor on both forces would not turn them: no scatter of the grip would, and the law of
    another tire does."""
    turned = np.array([[3.0, -3.0]] * RUNS)
    wanted = 0.005**2 * sum(2.0 * (3.0 * len(g)) ** 2 for g in GROUPS)
    found = size_errors.variance_of_law(of_law(), turned, np.full(2, np.inf))
    assert found == pytest.approx(wanted)
    signals = numbers(36, 2, RUNS, 5)
    single = size_errors.single_channels(signals)
    np.testing.assert_array_equal(single.sum(axis=0), signals)
    assert not single[0, 1].any() and not single[1, 0].any()


def test_signals_that_rise_later_are_lower_by_their_slope_over_the_place():
    place = np.tile(np.linspace(0.0, 1.0, 11), (2, 1))
    slopes = np.array([300.0, -50.0])[:, None]
    runs = SimpleNamespace(coordinates={"place": SimpleNamespace(values=place, local=True)})
    state = SimpleNamespace(runs=runs, model=SimpleNamespace(form=FormError(shift=1e-3)))
    found = size_errors.shifted_later(state, (slopes * place)[None])
    np.testing.assert_allclose(found, -1e-3 * np.broadcast_to(slopes, (1, 2, 11)))


def test_share_of_an_effect_that_others_do_not_make(in_stretches):
    gram, columns, _ = in_stretches
    flat = np.moveaxis(columns, 1, 0).reshape(columns.shape[1], -1).T
    own = flat[:, 2]
    rest = without(flat[:, [0, 4]], own)
    found = size_errors.visible_share(gram, [0, 4], 2)
    assert found == pytest.approx((rest @ rest) / (own @ own)) and found < 0.95


def test_p_value_of_a_drop():
    assert decide._p_value(12.0, 2, 1.5, 9.0) == pytest.approx(f_distribution.sf(4.0, 2, 9.0))
    # a dispersion below one is luck
    assert decide._p_value(12.0, 2, 0.1, 9.0) == pytest.approx(f_distribution.sf(6.0, 2, 9.0))
    assert decide._p_value(12.0, 2, 1.5, 0.1) == pytest.approx(f_distribution.sf(4.0, 2, 1.0))
    assert decide._p_value(0.0, 2, 1.5, 9.0) == decide._p_value(-3.0, 2, 1.5, 9.0) == 1.0


def test_stretches_hold_the_same_information_and_are_all_of_it():
    """Half by information, half by length, so that a quiet beginning is cut off as well."""
    runs = SimpleNamespace(samples=100)
    direction = np.zeros((1, 2, 100))
    direction[:, :, 50:] = 3.0
    pieces = decide._stretches(SimpleNamespace(runs=runs), direction)
    np.testing.assert_allclose(pieces.sum(axis=0), direction)
    assert len(pieces) == 5
    # node n of the second half stands at (n - 50)/50 of the information and n/99 of the length
    n = np.arange(50, 100)
    place = np.minimum((0.5 * ((n - 49) / 50 + n / 99) * 5).astype(int), 4)
    for i, piece in enumerate(pieces):
        np.testing.assert_allclose(piece[0, 0, 50:] != 0.0, place == i)


@pytest.mark.parametrize(
    ("low", "null", "high", "value", "edge"),
    [
        (-1.0, 0.0, 1.0, 1.0, True), (-1.0, 0.0, 1.0, -1.0, True), (-1.0, 0.0, 1.0, 0.9, False),
        (0.0, 0.0, 1.0, 1.0, True), (0.0, 0.0, 1.0, 0.0, False), (-1.0, 0.0, 0.0, 0.0, False),
        (-np.inf, 0.0, np.inf, 9.0, False), (-1.0, 0.0, np.inf, -1.0, False),
    ],
)  # fmt: skip
def test_a_size_at_an_end_that_is_not_its_null(low, null, high, value, edge):
    effect = shape("edge", LONG.form)
    p = replace(effect.parameters()[0], lower=low, null=null, upper=high)
    effect.main_parameter = classmethod(lambda cls: p)
    assert decide.at_edge(Term(effect, np.array([value]))) is edge


def test_a_channel_that_never_moves_asks_for_no_run():
    """Fz of a table that was written by hand: no scatter, and nothing to divide by."""
    model = SimpleNamespace(form=FormError(mean=0.001, side=0.002), runs=SimpleNamespace())
    model.runs.largest = np.array([2000.0, 3700.0])
    weights = channel_weights(model, [4.0, 0.0])
    np.testing.assert_allclose(weights.ravel(), [1 / np.hypot(4.0, 2.0), 1 / 7.4])
