# SPDX-License-Identifier: Apache-2.0
"""Axis systems from the signs of a few samples: all combinations, and what determines a sign."""

from __future__ import annotations

import numpy as np
import pytest

from flatplank_analysis.slip_sweeps.axes import in_iso
from flatplank_data.errors import FlatplankError

N = 400
ISO = "ISO W (ISO 8855: z up, y to the left)"
SAE = "SAE J670 (z down, y to the right)"
ADAPTED = "adapted SAE (z down, y to the right, load and slip angle turned)"
SIDE = {1: ", Fy rises with the slip angle", -1: ", Fy falls with the slip angle", 0: ""}
LEAN = {1: ", Fy rises with camber", -1: ", Fy falls with camber", 0: ""}


def words(load: int, side: int, lean: int) -> str:
    return f"Fz {'> 0' if load > 0 else '< 0'}{SIDE[side]}{LEAN[lean]}"


def bench(load=1, side=-1, lean=-1, **changed):
    """Slip angle and camber by turns, drawn load; with these signs of the side force. None: not
    in the file."""
    draw = np.random.default_rng(3)
    alpha = draw.uniform(-0.1, 0.1, N)
    gamma = np.resize([-0.05, 0.0, 0.05], N)
    fz = draw.uniform(900.0, 2000.0, N)
    columns = {
        "alpha": alpha, "gamma": gamma, "fz": load * fz,
        "fy": fz * (9.0 * side * alpha + 1.2 * lean * gamma), "mx": 1.0 + alpha, "my": 2.0 + alpha,
        "mz": 3.0 + alpha, "further": 4.0 + alpha,
    } | changed  # fmt: skip
    return {k: v for k, v in columns.items() if v is not None}


TURNED = {ISO: set(), SAE: {"alpha", "fy", "fz", "my", "mz"}, ADAPTED: {"fy", "my", "mz"}}
SIGNS = {
    (1, -1, -1): (ISO, ""), (1, 1, 1): (ADAPTED, ""), (-1, -1, 1): (SAE, ""),
    (1, 1, -1): (ISO, "alpha"), (1, -1, 1): (ISO, "gamma"), (-1, 1, 1): (SAE, "alpha"),
    (-1, -1, -1): (SAE, "gamma"),
}  # fmt: skip
ANGLE = {"alpha": "slip angle", "gamma": "camber"}


@pytest.mark.parametrize("signs", SIGNS, ids=str)
def test_three_signs_tell_the_system_and_every_channel_is_converted(signs):
    title, angle = SIGNS[signs]
    given = bench(*signs)
    found, said = in_iso(given, None, (), "a.csv")
    more = f"; the {ANGLE[angle]} is counted the other way" if angle else ""
    assert said == f"axes: {title}, by {words(*signs)}{more}"
    turned = TURNED[title] ^ ({angle} - {""})
    for name, values in given.items():
        assert (found[name] == (-values if name in turned else values)).all(), name
    _, again = in_iso(found, None, (), "a.csv")
    assert again == f"axes: {ISO}, by {words(1, -1, -1)}"


REFUSED = {
    ((-1, 1, -1), None): (
        f"a.csv: no axis system has these signs: {words(-1, 1, -1)}; turn the sign of the slip "
        "angle or of Fy: --turn alpha, or --turn fy"),
    ((1, -1, -1), "sae"): (
        f"a.csv: the signs are not those of {SAE}: {words(1, -1, -1)}; leave --axes out, or say "
        "--axes iso"),
    ((-1, -1, 1), "iso"): (
        f"a.csv: the signs are not those of {ISO}: {words(-1, -1, 1)}; leave --axes out, or say "
        "--axes sae"),
    ((1, -1, -1), "adapted"): (
        f"a.csv: the signs are not those of {ADAPTED}: {words(1, -1, -1)}; leave --axes out, or "
        "say --axes iso, or --turn the channel that is counted the other way"),
    ((-1, 1, -1), "sae"): (
        f"a.csv: the signs are not those of {SAE}: {words(-1, 1, -1)}; turn the sign of the slip "
        "angle or of Fy: --turn alpha, or --turn fy, or --turn the channel that is counted the "
        "other way"),
    ((-1, 1, -1), "iso"): (
        f"a.csv: the signs are not those of {ISO}: {words(-1, 1, -1)}; turn the sign of the slip "
        "angle or of Fy: --turn alpha, or --turn fy"),
}  # fmt: skip


@pytest.mark.parametrize("case", REFUSED, ids=str)
def test_other_signs_are_refused_with_what_to_do(case):
    signs, wanted = case
    with pytest.raises(FlatplankError) as caught:
        in_iso(bench(*signs), wanted, (), "a.csv")
    assert str(caught.value) == REFUSED[case]


ASKED = {
    ((1, -1, -1), "iso", ()): (f"{ISO}, as asked for", set()),
    ((1, 1, -1), "adapted", ()): (
        f"{ADAPTED}, as asked for; the camber is counted the other way, by {words(1, 1, -1)}",
        {"fy", "my", "mz", "gamma"}),
    ((1, 1, -1), None, ("alpha",)): (
        f"{ISO}, by {words(1, -1, -1)}; turned as asked for: alpha", {"alpha"}),
    ((1, -1, -1), None, ("alpha",)): (
        f"{ADAPTED}, by {words(1, 1, -1)}; turned as asked for: alpha; the camber is counted the "
        "other way", {"fy", "my", "mz", "gamma", "alpha"}),
    ((-1, 1, -1), "sae", ("alpha", "gamma")): (
        f"{SAE}, as asked for; turned as asked for: alpha, gamma",
        {"fy", "fz", "my", "mz", "gamma"}),
}  # fmt: skip


@pytest.mark.parametrize("case", ASKED, ids=str)
def test_what_was_asked_for_is_said_and_done(case):
    signs, wanted, turn = case
    text, turned = ASKED[case]
    given = bench(*signs)
    found, said = in_iso(given, wanted, turn, "a.csv")
    assert said == f"axes: {text}"
    for name, values in given.items():
        assert (found[name] == (-values if name in turned else values)).all(), name


@pytest.mark.parametrize(
    ("changed", "wanted", "text"),
    [
        ({"gamma": None}, None, f"{ISO}, by {words(1, -1, 0)}"),
        ({"alpha": None, "fy": bench()["fy"] + 0.0}, None, f"{ISO}, by {words(1, 0, -1)}"),
        ({"fy": None}, None,
         f"{ISO}, by {words(1, 0, 0)}; nothing tells it from adapted (--axes NAME)"),
        ({"fy": None}, "iso", f"{ISO}, as asked for"),
        ({"fy": None}, "adapted", f"{ADAPTED}, as asked for"),
    ],
)  # fmt: skip
def test_a_channel_that_was_not_measured_tells_no_sign(changed, wanted, text):
    columns = bench(**changed)
    if "alpha" not in columns:
        columns["fy"] = -1.2 * columns["fz"] * columns["gamma"]
    assert in_iso(columns, wanted, (), "a.csv")[1] == f"axes: {text}"


def side_of(alpha, fy):
    """The sign of the side force over the slip angle that is said."""
    columns = {"alpha": alpha, "fy": fy, "fz": np.full(len(alpha), 1000.0)}
    said = in_iso(columns, None, (), "a.csv")[1]
    return 1 if "rises with the slip" in said else -1 if "falls with the slip" in said else 0


def spread(width, n=N):
    return width * np.linspace(-1.0, 1.0, n)


@pytest.mark.parametrize(
    ("alpha", "force", "side"),
    [
        (spread(0.02), lambda a: -9e3 * a, -1),
        (spread(0.02), lambda a: 9e3 * a, 1),
        (spread(0.0028), lambda a: -9e3 * a, 0),
        (spread(0.0045), lambda a: -9e3 * a, -1),
        (spread(0.02), lambda a: 0.0 * a + 5.0, 0),
        (spread(0.02, 15), lambda a: -9e3 * a, 0),
        (spread(0.02, 25), lambda a: -9e3 * a, -1),
        (spread(0.02), lambda a: np.cos(40 * a), 0),
        (spread(0.2), lambda a: np.where(np.abs(a) < 0.03, -9e3 * a, 9e4 * a), -1),
        (spread(0.2), lambda a: np.where(np.abs(a) < 0.03, np.nan, -9e3 * a), 0),
        (spread(0.02), lambda a: np.where(a > 0.0, np.nan, -9e3 * a), -1),
    ],
)  # fmt: skip
def test_the_slope_is_that_of_enough_samples_of_small_slip(alpha, force, side):
    assert side_of(alpha, force(alpha)) == side


@pytest.mark.parametrize(
    ("changed", "lean"),
    [
        (lambda c: c, -1),
        (lambda c: c | {"gamma": 0.0 * c["gamma"]}, 0),
        (lambda c: c | {"gamma": 0.0 * c["gamma"] + 0.05}, 0),
        (lambda c: c | {"alpha": None, "fy": 0.0 * c["fy"]}, 0),
        (lambda c: c | {"fy": np.where(np.arange(N) < 390, np.nan, c["fy"])}, 0),
        (lambda c: c | {"fy": np.where(np.arange(N) < 100, np.nan, c["fy"])}, -1),
        (lambda c: c | {"kappa": np.resize([0.0, 0.2, -0.2], N // 2).repeat(2)}, -1),
        (lambda c: c | {"fy": np.where(np.abs(c["alpha"]) < 0.03, c["fy"],
                                       1e4 * c["gamma"] * c["fz"])}, -1),
        (lambda c: c | {"kappa": np.where(np.arange(N) < 200, 0.0, -0.2),
                        "fy": np.where(np.arange(N) < 200, c["fy"],
                                       1e4 * c["gamma"] * c["fz"])}, -1),
        (lambda c: c | {"fy": -9.0 * c["fz"] * c["alpha"]
                              + np.random.default_rng(5).normal(0.0, 30.0, N)}, 0),
        (lambda c: c | {"fy": c["fy"] - 9e-3 * c["fz"] ** 2 * c["alpha"]}, -1),
        (lambda c: c | {"fy": c["fy"] + 0.5 * c["fz"]}, -1),
    ],
)  # fmt: skip
def test_the_camber_thrust_is_what_the_slip_and_the_load_do_not_explain(changed, lean):
    columns = {k: v for k, v in changed(bench()).items() if v is not None}
    said = in_iso(columns, None, (), "a.csv")[1]
    assert ("Fy falls with camber" in said) == (lean < 0) and "Fy rises with camber" not in said


@pytest.mark.parametrize(("sign", "title"), [(1.0, ISO), (-1.0, SAE)])
def test_the_load_is_that_of_the_loaded_tire(sign, title):
    """The tire hangs most of the time, and the sensor then shows a little of the other sign."""
    columns = {name: np.tile(values, 5) for name, values in bench(gamma=None).items()}
    hangs = np.arange(5 * N) >= N
    columns["fz"] = sign * np.where(hangs, -20.0, columns["fz"])
    columns["fy"] = np.where(hangs, 0.0, columns["fy"])
    assert in_iso(columns, None, (), "a.csv")[1].startswith(f"axes: {title}")


def test_a_driven_tire_that_would_brake_is_refused_and_can_be_turned():
    kappa = spread(0.02)
    columns = bench() | {"kappa": kappa, "fx": -2e4 * kappa}
    with pytest.raises(FlatplankError, match="a driven tire would brake; .*--turn kappa, or"):
        in_iso(columns, None, (), "a.csv")
    found, said = in_iso(columns, None, ("fx",), "a.csv")
    assert (found["fx"] == 2e4 * kappa).all() and said.endswith("; turned as asked for: fx")


@pytest.mark.parametrize("name", ["beta", "kappa", "further"])
def test_only_channels_of_the_file_can_be_turned(name):
    with pytest.raises(FlatplankError) as caught:
        in_iso(bench(), None, ("alpha", name), "a.csv")
    assert str(caught.value) == (
        f"--turn: no channel '{name}' to turn; known: alpha, gamma, fz, fy, mx, my, mz"
    )
