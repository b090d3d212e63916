# SPDX-License-Identifier: Apache-2.0
"""One million evaluations of Fx, Fy, Mz with every coefficient in use, on one core.

python -m flatplank_validation.fits.magic_formula
"""

from __future__ import annotations

import time

import numpy as np

from flatplank_tire.magic_formula import DEFAULTS, Coefficients, steady_forces
from flatplank_tire.tir import shipped_tir
from flatplank_validation.fits.command import command

COUNT = 1_000_000


def full_set() -> Coefficients:
    """The packaged tire, with every zero coefficient set to a small value."""
    given = shipped_tir().values
    small = {k: 0.02 for k, v in DEFAULTS.items() if v == 0.0 and not given.get(k)}
    return Coefficients(small | {k: v for k, v in given.items() if v} | {"VXLOW": 0.0})


def measure(count: int = COUNT, repeats: int = 3) -> dict[str, float]:
    """Best time [s] for `count` points that differ in every input."""
    rng = np.random.default_rng(1)
    inputs = [
        rng.uniform(low, high, count)
        for low, high in ((1e3, 7e3), (-0.2, 0.2), (-0.2, 0.2), (-0.09, 0.09), (1.8e5, 3e5))
    ]
    fz, kappa, alpha, gamma, pressure = inputs
    c, times = full_set(), []
    for _ in range(repeats):
        begin = time.perf_counter()
        steady_forces(c, fz, kappa, alpha, gamma, pressure, 0.03)
        times.append(time.perf_counter() - begin)
    return {"evaluations": count, "time_s": min(times), "per_second": count / min(times)}


main = command(__doc__, lambda _: measure())

if __name__ == "__main__":
    main()
