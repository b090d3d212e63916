# SPDX-License-Identifier: Apache-2.0
"""A test bench of another kind: sweeps of slip angle or slip, load by load, in SAE axes.

The tire is a brush with a parabolic pressure; it shares no formula with the models.
"""

from __future__ import annotations

from pathlib import Path

import numpy as np
import scipy.io

RATE = 100.0
LOADS = (400.0, 800.0, 1200.0)
CAMBERS = (0.0, 4.0)
PRESSURES = (70.0, 83.0)
STIFFNESS, SOFTENS = 26.0, 5e-5
"""per load [1/rad, 1/slip], and how it falls with the load [1/N]"""
GRIP, TIRES = 1.4, 1.2e-4
"""friction, and how it falls with the load [1/N]"""
CAMBER = 0.9
"""thrust per load [1/rad]"""
TRAIL = 0.02


def brush(slip: np.ndarray, fz: np.ndarray) -> np.ndarray:
    """Force of a brush with parabolic pressure over the slip [N]."""
    c = STIFFNESS * (1.0 - SOFTENS * fz) * fz
    limit = GRIP * (1.0 - TIRES * fz) * fz
    t = np.clip(c * np.abs(slip) / (3.0 * limit), 0.0, 1.0)
    return np.sign(slip) * limit * (3.0 * t - 3.0 * t**2 + t**3)


def triangle(top: float, n: int) -> np.ndarray:
    """0, top, -top, 0."""
    return np.interp(np.linspace(0.0, 4.0, n), [0.0, 1.0, 3.0, 4.0], [0.0, top, -top, 0.0])


def recording(
    swept: str = "alpha", seed: int = 0, noise: float = 12.0, cambers=CAMBERS, pressures=PRESSURES
) -> dict[str, np.ndarray]:
    """Channels in ISO W and SI: every load at every camber and pressure, with passages between."""
    random = np.random.default_rng(seed)
    parts = []
    for pressure in pressures:
        for gamma in cambers:
            for load in LOADS:
                n = 1200
                slip = triangle(0.2 if swept == "alpha" else 0.15, n)
                fz = load * (1.0 + 0.02 * np.sin(2.0 * np.pi * np.arange(n) / 37.0))
                parts.append((slip, fz, np.full(n, np.radians(gamma)), np.full(n, pressure)))
                parts.append((np.zeros(60), np.full(60, load), np.full(60, np.radians(gamma)),
                              np.full(60, pressure)))  # fmt: skip
    slip, fz, gamma, pressure = (np.concatenate(p) for p in zip(*parts, strict=True))
    late = np.empty_like(slip)  # the force follows the slip a little late: up and down differ
    value = 0.0
    for k, target in enumerate(slip):
        value += 0.25 * (target - value)
        late[k] = value
    zero = np.zeros(len(slip))
    force = brush(late, fz)
    columns = {
        "time": np.arange(len(slip)) / RATE,
        "alpha": slip if swept == "alpha" else zero,
        "kappa": slip if swept == "kappa" else zero,
        "gamma": gamma,
        "fx": force if swept == "kappa" else zero,
        "fy": (-force if swept == "alpha" else zero) - CAMBER * fz * gamma,
        "fz": fz,
        "mz": TRAIL * force,
        "pressure": 1e3 * pressure,
        "speed": np.full(len(slip), 11.1),
        "TSTC": 40.0 + 20.0 * np.arange(len(slip)) / len(slip),
    }
    for name in ("fx", "fy", "fz"):
        columns[name] = columns[name] + noise * random.standard_normal(len(slip))
    return columns


NAMES = {
    "time": ("ET", "sec", 1.0),
    "alpha": ("SA", "deg", 180.0 / np.pi),
    "kappa": ("SL", "none", 1.0),
    "gamma": ("IA", "deg", 180.0 / np.pi),
    "fx": ("FX", "N", 1.0),
    "fy": ("FY", "N", 1.0),
    "fz": ("FZ", "N", 1.0),
    "mz": ("MZ", "N-m", 1.0),
    "pressure": ("P", "kPa", 1e-3),
    "speed": ("V", "kph", 3.6),
    "TSTC": ("TSTC", "degC", 1.0),
}
SAE = ("alpha", "fy", "fz", "mz")
ADAPTED = ("fy", "mz")


def as_written(columns: dict[str, np.ndarray], turned: tuple[str, ...]) -> dict[str, np.ndarray]:
    """Names and units of such benches, in another axis system."""
    return {NAMES[k][0]: NAMES[k][2] * (-v if k in turned else v) for k, v in columns.items()}


def write_mat(path: Path, columns: dict[str, np.ndarray], turned=SAE, units: bool = True) -> Path:
    """One vector per channel, and a struct with names and units."""
    written = as_written(columns, turned)
    extra = {"source": "a bench", "tireid": "a tire"}
    if units:
        by_name = {name: unit for name, unit, _ in NAMES.values()}
        texts = [by_name[name] for name in written]
        extra["channel"] = {
            "name": np.array(list(written), object), "units": np.array(texts, object),
        }  # fmt: skip
    scipy.io.savemat(path, {**{k: v[:, None] for k, v in written.items()}, **extra})
    return path


def write_dat(path: Path, columns: dict[str, np.ndarray], turned=SAE) -> Path:
    """A title, names, units and numbers with tabs between."""
    written = as_written(columns, turned)
    by_name = {name: unit for name, unit, _ in NAMES.values()}
    head = ["Run 7 of a bench", "\t".join(written), "\t".join(by_name[n] for n in written)]
    rows = ["\t".join(f"{v:.5g}" for v in row) for row in zip(*written.values(), strict=True)]
    path.write_text("\n".join([*head, *rows]) + "\n")
    return path


def write_csv(path: Path, columns: dict[str, np.ndarray], turned=()) -> Path:
    """Names and numbers with commas, no units."""
    written = as_written(columns, turned)
    rows = [",".join(f"{v:.6g}" for v in row) for row in zip(*written.values(), strict=True)]
    path.write_text("\n".join([",".join(written), *rows]) + "\n")
    return path
