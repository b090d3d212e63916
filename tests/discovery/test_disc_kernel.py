# SPDX-License-Identifier: Apache-2.0
"""The compiled step of the search's base: its own elementary functions, and elements computed
side by side."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from numba import njit
from scipy.ndimage import uniform_filter1d

from flatplank_analysis import kernels
from flatplank_analysis.contact_patch import compiling, kernel

RUNS, NODES = 11, 400


@njit
def _powers(x, exponents):
    out = np.empty(len(x))
    for i in range(len(x)):
        out[i] = compiling.power(x[i], exponents[i])
    return out


@njit
def _exponentials(x):
    out = np.empty(len(x))
    for i in range(len(x)):
        out[i] = compiling.exponential(x[i])
    return out


def test_the_set_up_can_call_every_inner_loop():
    kernels.compile_all()


def test_power_is_that_of_the_library():
    random = np.random.default_rng(3)
    x = np.concatenate([10.0 ** random.uniform(-280.0, 12.0, 4000), np.linspace(0.49, 2.01, 4000)])
    exponents = random.uniform(-1.0, 1.0, len(x))
    np.testing.assert_allclose(_powers(x, exponents), x**exponents, rtol=2e-13)
    assert _powers(np.array([1.0]), np.array([7.0]))[0] == 1.0


def test_what_is_too_small_is_nothing():
    assert _powers(np.array([1e-290]), np.array([9.0]))[0] < 1e-300


def test_exponential_is_that_of_the_library():
    x = np.linspace(-650.0, 650.0, 9001)
    np.testing.assert_allclose(_exponentials(x), np.exp(x), rtol=2e-13)


def _smooth(values: np.ndarray) -> np.ndarray:
    """The mean over 1.4 cm."""
    return uniform_filter1d(values, 9, axis=1, mode="nearest")


def _elements(seed: int, **more: float):
    """Eleven elements with numbers of their own, driven by slips of both signs."""
    random = np.random.default_rng(seed)
    params = np.zeros((2, RUNS, kernel.WIDTH))
    usual = {
        "stiff": 9e4, "peak": 1.05, "shape": 3.0, "carcass": 2.3e5, "half": 0.07, "tread": 1.0,
        "patch_order": 0.5, "play_soft": 10.0, "creep_time": 10.0, "load_share": 1.0, "denom": 0.5,
    } | more  # fmt: skip
    for name, value in usual.items():
        params[..., kernel.NAMES.index(name)] = value * random.uniform(0.7, 1.3, (2, RUNS))
    ds = random.uniform(0.5, 1.5, (RUNS, NODES)) * 1.5e-3
    ds[:, 0] = 0.0
    dw = np.linspace(-0.2, 0.2, RUNS)[:, None] * ds
    dw = np.stack([dw, 0.3 * dw[::-1]])
    # no road changes load and grip by a fifth from one node to the next, 1.5 mm further
    load = 3700.0 * _smooth(random.uniform(0.8, 1.2, (RUNS, NODES)))
    friction = _smooth(random.uniform(0.9, 1.1, (RUNS, NODES)))
    return ds, dw, ds / 0.03, load, friction, params, np.full(RUNS, 3700.0)


def _forces(given, rows, across):
    force = np.full((2, RUNS, NODES), np.nan)
    kernel.sweep(kernel.blocks_of(rows), True, True, *given, 0.03, force, across)
    return force[:, rows]


EVERYTHING = {
    "play": 1e-3, "play_rest": 0.3, "creep": 0.3, "slide": 0.2, "law_1": 0.1, "law_3": -0.1,
    "asym_peak": 0.1, "asym_stiff": -0.1, "soften": 0.2, "loss_brake": 0.05, "give": 1e-7,
    "turn": 0.5, "fall": 0.1, "round": 0.5, "turn_share": 0.3, "turn_rate": 0.2, "follow": 1e-3,
}  # fmt: skip


@pytest.mark.parametrize(
    "more, across", [({}, None), (EVERYTHING, None), (EVERYTHING | {"other_slip": 1.0}, 1)]
)
def test_an_element_does_not_depend_on_those_beside_it(more, across):
    given = _elements(5, **more)
    together = _forces(given, np.arange(RUNS), across)
    assert np.isfinite(together).all() and np.ptp(together) > 1000.0
    for row in range(RUNS):
        alone = _forces(given, np.array([row]), across)
        np.testing.assert_allclose(alone[:, 0], together[:, row], rtol=1e-9, atol=1e-6)


def test_without_slip_across_the_shared_law_is_that_of_one_direction():
    given = _elements(7, other_slip=1.0, turn_share=0.3)
    given[1][1] = 0.0
    rows = np.arange(RUNS)
    alone = _forces(given, rows, None)
    np.testing.assert_allclose(_forces(given, rows, 1)[0], alone[0], rtol=1e-9, atol=1e-6)


def test_node_by_node_is_the_sweep():
    given = _elements(9, **(EVERYTHING | {"other_slip": 1.0}))
    rows = np.arange(RUNS)
    ds, dw, dt, load, friction, params, nominal = given
    blocks = kernel.blocks_of(rows)
    states, last = kernel.rest(blocks, params, nominal), np.zeros((2, RUNS, 1))
    found = np.empty((2, RUNS, NODES))
    for n in range(NODES):
        now = [np.ascontiguousarray(a[..., n : n + 1]) for a in (ds, dw, dt, load, friction)]
        kernel.one_node(states, blocks, *now, 0.03, last, 1)
        found[:, :, n] = last[:, :, 0]
    np.testing.assert_allclose(found, _forces(given, rows, 1), rtol=1e-12)


def test_the_cache_follows_every_file_of_the_kernels(monkeypatch):
    here = compiling.folder()
    folder = Path(compiling.__file__).parent
    word = "contact_patch.compiling import"
    users = [p.name for p in folder.glob("*.py") if word in p.read_text("utf-8")]
    assert set(compiling.FILES) == {*users, "compiling.py"}
    assert Path(kernel.sweep.stats.cache_path).parent == Path(here)
    read = Path.read_bytes
    for name in compiling.FILES:
        monkeypatch.setattr(Path, "read_bytes", lambda p, n=name: read(p) + b"#" * (p.name == n))
        assert compiling.folder() != here
