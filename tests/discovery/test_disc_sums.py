# SPDX-License-Identifier: Apache-2.0
"""The sums that decisions are made from, against the same numbers in plain linear algebra."""

from __future__ import annotations

from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest
from scipy.special import digamma, polygamma
from scipy.stats import f as f_distribution
from scipy.stats import norm
from shapes import CONDITIONS, LONG, REPEATS, measured, shape

from flatplank_analysis.discovery import decide, dispersion, floor, screen
from flatplank_analysis.discovery.fit import Term
from flatplank_analysis.discovery.gram import Gram, Metric, scatter_of, solve
from flatplank_analysis.discovery.model import Form
from flatplank_analysis.discovery.nextrun import weight_of
from flatplank_analysis.discovery.noise import ChannelNoise, Whitener
from flatplank_analysis.discovery.state import Candidate
from flatplank_analysis.discovery.verdict import smallest

RUNS = CONDITIONS * REPEATS
GROUPS = [np.arange(REPEATS * c, REPEATS * (c + 1)) for c in range(CONDITIONS)]
SPARE = CONDITIONS * (REPEATS - 1)


def numbers(seed: int, *size: int) -> np.ndarray:
    return np.random.default_rng(seed).standard_normal(size)


def plain(samples: int) -> Whitener:
    """Noise that is white and of unit size."""
    unit = ChannelNoise(np.eye(8)[0], np.ones(RUNS))
    return Whitener(np.arange(samples), {(0, 0): np.eye(samples)}, np.zeros(RUNS, int), [unit])


def test_sizes_and_their_covariance_by_least_squares():
    columns, goal = numbers(1, 50, 3) * [1.0, 1e3, 1e-3], numbers(2, 50)
    sizes, covariance = solve(columns.T @ columns, columns.T @ goal)
    np.testing.assert_allclose(sizes, np.linalg.lstsq(columns, goal, rcond=None)[0], rtol=1e-6)
    np.testing.assert_allclose(covariance @ columns.T @ columns, np.eye(3), atol=1e-6)
    # a direction that is there twice has no information of its own
    twice = columns[:, [0, 0]]
    np.testing.assert_allclose(solve(twice.T @ twice, twice.T @ goal)[0].sum(),
                               columns[:, 0] @ goal / (columns[:, 0] @ columns[:, 0]))  # fmt: skip


def test_of_a_stiff_direction_as_much_is_taken_out_as_its_size_is_uncertain():
    """e' (1 + s^2 g g')^-1 e, the generalised least squares of a random size s in every run."""
    stiff, scatter = numbers(3, 2, 1, RUNS, 30), np.array([0.4, 2.0])
    values = numbers(4, 2, 1, RUNS, 30)
    found = Metric(plain(30), stiff, scatter).gram(values[0], values)
    for r in range(RUNS):
        g = stiff[:, 0, r].T * scatter
        metric = np.linalg.inv(np.eye(30) + g @ g.T)
        e, x = values[0, 0, r], values[:, 0, r]
        assert found.energy[r] == pytest.approx(e @ metric @ e)
        np.testing.assert_allclose(found.scores[r], x @ metric @ e)
        np.testing.assert_allclose(found.products[r], x @ metric @ x.T, atol=1e-9)
    total = found.total([1, 3])
    np.testing.assert_allclose(total[0], found.products[1] + found.products[3])
    assert total[2] == pytest.approx(found.energy[1] + found.energy[3])
    still = Metric(plain(30), stiff, np.zeros(2)).gram(values[0], values)
    np.testing.assert_allclose(still.energy, np.sum(values[0, 0] ** 2, axis=1))


def test_scatter_of_a_stiff_direction_beyond_noise_and_drift():
    """The variance of its sizes, less the noise, less what runs evenly with the order."""
    runs = measured(0).runs
    column = numbers(5, 1, 1, 1, runs.samples) * np.ones((1, 1, RUNS, 1))
    h = float(np.sum(column[0, 0, 0] ** 2))
    order = np.random.default_rng(2).permutation(RUNS).astype(float)
    runs = replace(runs, order=order)
    sizes = runs.contrast(numbers(6, RUNS, 1))[:, 0]
    within = runs.contrast(order[:, None])[:, 0]
    rest = sizes - within * (within @ sizes) / (within @ within)
    for drift in (0.0, 5.0):
        contrast = (sizes + drift * within)[None, :, None] * column[0]
        (found,) = scatter_of(runs, plain(runs.samples), contrast, column)
        free = SPARE - 1.0
        assert found**2 == pytest.approx((h * rest @ rest - free) / (h * free))
    slight = 1e-6 * sizes[None, :, None] * column[0]
    assert scatter_of(runs, plain(runs.samples), slight, column) == [0.0]
    # runs that hardly show it, and conditions measured once, say nothing
    weak = column.copy()
    weak[0, 0, :REPEATS] = 0.0
    some = (sizes + 7.0 * (runs.condition == 0))[None, :, None] * column[0]
    assert scatter_of(runs, plain(runs.samples), some, weak)[0] < 2.0
    once = runs.subset(np.arange(0, RUNS, REPEATS))
    few = contrast[:, ::REPEATS], column[:, :, ::REPEATS]
    assert scatter_of(once, plain(runs.samples), *few) == [0.0]
    assert scatter_of(once, plain(runs.samples), *few, (0.3,)) == [0.3]
    assert len(scatter_of(runs, plain(runs.samples), contrast, column[:0])) == 0


def test_scores_of_an_amplitude_with_the_base_taken_out():
    base, x, e = numbers(7, RUNS, 2, 40), numbers(8, RUNS, 1, 40), numbers(9, RUNS, 40)
    gram = Gram.of(np.concatenate([base, x], axis=1), e)
    score, info = dispersion.scores_of(gram, 2)
    flat = np.moveaxis(base, 1, 0).reshape(2, -1).T
    away = [v - flat @ np.linalg.lstsq(flat, v, rcond=None)[0] for v in (x.ravel(), e.ravel())]
    own, left = (v.reshape(RUNS, 40) for v in away)
    size = np.sum(own * left) / np.sum(own**2)
    np.testing.assert_allclose(info, np.sum(own**2, axis=1))
    np.testing.assert_allclose(score, np.sum(own * (left - size * own), axis=1), atol=1e-9)


def test_dispersion_among_repeats():
    """Of groups that know as much: the variance of the scores; of others by what each knows."""
    groups = [np.array([0, 1, 2]), np.array([3, 4]), np.array([5])]
    score, info = numbers(10, 6), np.full(6, 2.0)
    kappa, freedom = dispersion.among_repeats(groups, score, info)
    spread = sum(np.sum((score[g] - score[g].mean()) ** 2) for g in groups)
    assert (kappa, freedom) == (pytest.approx(spread / (2.0 * 3.0)), pytest.approx(3.0))
    uneven = np.array([1.0, 2.0, 3.0, 8.0, 2.0, 1.0])
    assert dispersion.among_repeats(groups, 5.0 * uneven, uneven)[0] == pytest.approx(0.0)
    bottom = np.array([6.0 * 2.0 / 3.0, 10.0 / 2.0])
    wanted = bottom.sum() ** 2 / (bottom[0] ** 2 / 2.0 + bottom[1] ** 2)
    assert dispersion.among_repeats(groups, score, uneven)[1] == pytest.approx(wanted)
    assert dispersion.among_repeats(groups[2:], score, info) == (1.0, 1.0)


def test_dispersion_among_conditions():
    score, info = numbers(11, RUNS), np.full(RUNS, 2.0)
    kappa, freedom = dispersion.among_conditions(GROUPS, score, info)
    of_each = np.array([score[g].sum() for g in GROUPS])
    assert freedom == pytest.approx(CONDITIONS - 1.0)
    assert kappa == pytest.approx(np.sum(of_each**2) / (2.0 * REPEATS * (CONDITIONS - 1.0)))
    two = np.where(np.arange(RUNS) < 2 * REPEATS, 1.0, 0.0)
    assert dispersion.among_conditions(GROUPS, score, two)[1] == pytest.approx(1.0)
    one = np.where(np.arange(RUNS) < REPEATS, 1.0, 0.0)
    assert dispersion.among_conditions(GROUPS, score, one)[1] == 0.5
    assert dispersion.among_conditions(GROUPS[:1], score, info) == (1.0, 1.0)
    assert dispersion.among_conditions(GROUPS, score, 0.0 * info) == (1.0, 1.0)


def test_moments_of_the_logs_of_dispersions():
    for x in (0.3, 2.0, 40.0):
        assert dispersion._trigamma_inverse(float(polygamma(1, x))) == pytest.approx(x)
    # no more spread than their own freedom makes: as sure as a campaign can be
    own, most = 6.0, dispersion.MOST_FREEDOM
    found = dispersion.typical([2.5] * 8, [own] * 8)
    level = np.log(2.5) - digamma(own / 2) + np.log(own / 2)
    assert found.freedom == most
    wanted = np.exp(level + digamma(most / 2) - np.log(most / 2))
    assert found.dispersion == pytest.approx(wanted)
    # and with a spread of trigamma(3) beyond it, six
    logs = np.sqrt((polygamma(1, 3.0) + polygamma(1, own / 2)) * 0.875) * np.array([1, -1] * 4)
    found = dispersion.typical(9.0 * np.exp(logs), [own] * 8)
    assert found.freedom == pytest.approx(6.0)
    assert found.dispersion == pytest.approx(9.0)
    assert dispersion.typical([0.01] * 8, [own] * 8).dispersion == 1.0
    # those without scores are not asked
    assert dispersion.typical([3.0] * 4 + [0.0] * 9, [own] * 13) == dispersion.TypicalDispersion()
    assert (
        dispersion.typical([3.0] * 4 + [5.0] * 9, [own] * 4 + [0.5] * 9)
        == dispersion.TypicalDispersion()
    )


def test_contrasts_lose_what_differs_between_repeats_and_is_known():
    runs = measured(0).runs
    form, noise = numbers(12, runs.samples), numbers(13, RUNS, runs.samples)
    sizes = np.tile([1.0, 0.5, -2.0], CONDITIONS)
    block = sizes[None, :, None] * form
    shared = np.ones((1, RUNS, 1)) * form
    assert len(floor.contrast_blocks(runs, [block, shared, 0.0 * block])) == 1
    slight = shared + 0.4 * block / np.std(sizes)
    assert not floor.contrast_blocks(runs, [slight])
    found = floor.clean_contrasts(runs, noise + 3.0 * block[0] + 5.0 * shared[0], [block, shared])
    flat = runs.contrast(block).ravel()
    pure = runs.contrast(noise).ravel()
    pure = pure - flat * (flat @ pure) / (flat @ flat)
    np.testing.assert_allclose(found.ravel(), pure, atol=1e-5)
    other = numbers(14, 1, RUNS, runs.samples)
    both = floor.clean_contrasts(runs, noise + 3.0 * block[0] + other[0], [other, block])
    assert np.std(both) == pytest.approx(np.std(runs.contrast(noise)), rel=0.01)
    # contrasts without anything left are no reason to look on
    assert not floor.clean_contrasts(runs, 0.0 * noise, [block]).any()
    # noise is not explained by what happens to look a little like it
    kept = floor.clean_contrasts(runs, noise, [block, other])
    np.testing.assert_allclose(kept, runs.contrast(noise))
    assert np.abs(floor.clean_contrasts(runs, shared[0], [block])).max() < 1e-12


def test_independent_numbers_of_contrasts():
    """One form in all runs has one number per run; white noise has many."""
    runs = measured(0).runs
    sizes = runs.contrast(numbers(15, RUNS, 1))
    one = sizes * numbers(16, runs.samples)
    assert floor.effective_freedom(runs, one) == pytest.approx(SPARE / (1.0 - 1.0 / SPARE))
    two = np.zeros((RUNS, runs.samples))
    first = runs.contrast(np.tile([1.0, -1.0, 0.0], CONDITIONS)[:, None])[:, 0]
    second = np.tile([1.0, 1.0, -2.0], CONDITIONS) / 3.0**0.5
    two[:, 3], two[:, 40] = first, second
    assert floor.effective_freedom(runs, two) == pytest.approx(SPARE / (0.5 - 1.0 / SPARE))
    white = np.zeros((RUNS, runs.samples))
    assert floor.effective_freedom(runs, white) == pytest.approx(SPARE / (1.0 - 1.0 / SPARE))
    spread = runs.contrast(numbers(17, RUNS, runs.samples))
    assert 10.0 * SPARE < floor.effective_freedom(runs, spread) <= 200.0 * SPARE


def test_few_conditions_with_most_of_the_scatter_are_few_numbers():
    """One form in all runs, of no size but in some conditions: about two numbers in each."""
    runs = measured(0).runs
    one = runs.contrast(numbers(15, RUNS, 1)) * numbers(16, runs.samples)
    freedom = [
        floor.effective_freedom(runs, np.where(runs.condition < count, 1.0, 1e-3)[:, None] * one)
        for count in (1, 2, CONDITIONS)
    ]
    assert 2.0 < freedom[0] < freedom[1] < freedom[2]
    assert freedom[0] < 0.3 * freedom[2] and freedom[1] < 0.55 * freedom[2]


def test_the_floor_and_what_is_beyond_it():
    runs = measured(0).runs.subset(np.arange(1, RUNS))
    counts = np.array([2.0] + [3.0] * (CONDITIONS - 1))
    spare = float(np.sum(counts - 1.0))
    contrast = 2.0 * runs.contrast(numbers(18, RUNS - 1, runs.samples))
    mean = np.linspace(1.0, 4.0, CONDITIONS)
    residual = contrast + mean[runs.condition][:, None]
    cleaned = 0.8 * contrast
    pure = np.sum(cleaned**2) / (spare * runs.samples)
    found = floor.floor_of(runs, residual, cleaned, per_run=50.0)
    assert found.floor == pytest.approx(np.sqrt(pure))
    assert found.raw == pytest.approx(found.floor / 0.8)
    assert found.varying == pytest.approx(0.75 * found.floor)
    beyond = mean**2 - pure / counts
    np.testing.assert_allclose(found.per_condition, np.sqrt(np.maximum(beyond, 0.0)))
    assert found.unexplained == pytest.approx(np.sqrt(counts @ beyond / counts.sum()))
    np.testing.assert_allclose(found.rmse_condition[0], np.sqrt(np.mean(residual[:2] ** 2)))
    assert found.freedom == pytest.approx(
        min(spare * 50.0, floor.effective_freedom(runs, cleaned))
    )
    ratio = np.mean(mean**2 * counts) / pure
    wanted = f_distribution.sf(ratio, found.freedom * CONDITIONS / spare, found.freedom)
    assert found.p_value == pytest.approx(wanted)
    few = floor.floor_of(runs, 0.3 * residual, cleaned, per_run=0.5)
    assert few.freedom == spare * 0.5 and 0.0 < few.p_value < 1.0
    ratio *= 0.09
    assert few.p_value == pytest.approx(
        f_distribution.sf(ratio, few.freedom * CONDITIONS / spare, few.freedom)
    )
    # steps of the inputs repeat themselves; and a floor that is known is no smaller
    stepped = floor.floor_of(replace(runs, input_noise=(0.5,)), residual, cleaned)
    assert stepped.unexplained**2 == pytest.approx(found.unexplained**2 - 0.25)
    assert floor.floor_of(runs, residual, cleaned, least=9.0).floor == pytest.approx(9.0)


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


def test_smallest_size_that_is_found():
    """Both errors: half the family-wise level on either side, and one in five missed."""
    info = np.array([[4.0]])
    seen = screen.ScreenResult(candidate(np.zeros(0)), np.ones(1), 1.0, 0.5, info, np.ones(1))
    step = SimpleNamespace(screen=SimpleNamespace(ranked=[seen]))
    ((name, (size, unit)),) = smallest(step, {"long": 10}).items()
    need = norm.isf(0.05 / 10 / 2) + norm.isf(0.2)
    assert (name, unit) == ("long", "1") and size == pytest.approx(0.02 * need / 2.0)
    hidden = SimpleNamespace(screen=SimpleNamespace(ranked=[replace(seen, visible=1e-4)]))
    assert not smallest(hidden, {})


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


def test_one_size_in_every_condition(in_stretches):
    score, info = numbers(34, RUNS), np.linspace(1.0, 3.0, RUNS)
    info[:REPEATS] = 1e-6
    state = SimpleNamespace(runs=SimpleNamespace(groups=GROUPS))
    found, freedom = decide._condition_test(state, score, info)
    parts = [score[g].sum() ** 2 / info[g].sum() for g in GROUPS[1:]]
    assert found == pytest.approx(sum(parts)) and freedom == CONDITIONS - 2


def test_what_an_error_of_the_law_does_to_a_score(in_stretches):
    """One factor on the force per condition, half a hundredth, on what the base leaves of it."""
    gram, columns, _ = in_stretches
    flat = np.moveaxis(columns[:, :2], 1, 0).reshape(2, -1).T
    x, force = columns[:, 2], columns[:, 8]
    own = x - (flat @ np.linalg.lstsq(flat, x.ravel(), rcond=None)[0]).reshape(x.shape)
    along = np.sum(own * force, axis=1)
    wanted = 0.005**2 * sum(along[g].sum() ** 2 for g in GROUPS)
    state = SimpleNamespace(runs=SimpleNamespace(groups=GROUPS))
    assert decide._of_the_law(state, gram, 2) == pytest.approx(wanted)


def test_share_of_an_effect_that_others_do_not_make(in_stretches):
    gram, columns, _ = in_stretches
    flat = np.moveaxis(columns, 1, 0).reshape(columns.shape[1], -1).T
    own = flat[:, 2]
    rest = own - flat[:, [0, 4]] @ np.linalg.lstsq(flat[:, [0, 4]], own, rcond=None)[0]
    found = decide._visible(gram, [0, 4], 2)
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
    model = SimpleNamespace(form=Form(mean=0.001, side=0.002), runs=SimpleNamespace())
    model.runs.largest = np.array([2000.0, 3700.0])
    state = SimpleNamespace(model=model, floors=[SimpleNamespace(floor=f) for f in (4.0, 0.0)])
    np.testing.assert_allclose(weight_of(state).ravel(), [1 / np.hypot(4.0, 2.0), 1 / 7.4])
