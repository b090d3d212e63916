# SPDX-License-Identifier: Apache-2.0
"""Sweeps of a tire whose side force and moment are formulas, written from the book.

Pacejka, Tire and Vehicle Dynamics, 2012, 4.E19 to 4.E49 with the few coefficients of `P` and `Q`.
"""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

import numpy as np

P = {
    "PCY1": 1.4, "PDY1": 2.4, "PDY2": -0.2, "PDY3": 2.0, "PEY1": -0.3, "PKY1": -32.0, "PKY2": 1.8,
    "PKY4": 2.0, "PKY6": -1.2,
}  # fmt: skip
Q = {
    "QBZ1": 8.0, "QBZ2": -1.5, "QBZ9": 12.0, "QCZ1": 1.2, "QDZ1": 0.12, "QDZ2": -0.02,
    "QDZ3": 1.0, "QDZ6": 0.004, "QDZ8": -0.1, "QDZ9": 0.03, "QEZ1": -2.5, "QEZ2": 0.6,
    "QHZ1": 0.004,
}  # fmt: skip
RADIUS = 0.26
NOMINAL = 1000.0
LOADS = (400.0, 800.0, 1200.0)
NOISE, MOMENT_NOISE = 4.0, 0.2
RATE = 50.0
TIR = (
    "[UNITS]\nLENGTH='meter'\nFORCE='newton'\nANGLE='radians'\nMASS='kg'\nTIME='second'\n"
    "[MODEL]\nFITTYP = 61\nLONGVL = 11.1\n[DIMENSION]\nUNLOADED_RADIUS = 0.26\n"
    "[OPERATING_CONDITIONS]\nINFLPRES = 83000\nNOMPRES = 83000\n"
    "[VERTICAL]\nFNOMIN = 1000\nVERTICAL_STIFFNESS = 100000\n"
    "[LONGITUDINAL_COEFFICIENTS]\nPCX1 = 1.5\nPDX1 = 2.5\nPKX1 = 40\n[LATERAL_COEFFICIENTS]\n"
    + "".join(f"{key} = {value}\n" for key, value in P.items())
    + "[ALIGNING_COEFFICIENTS]\n"
    + "".join(f"{key} = {value}\n" for key, value in Q.items())
)


def peak(fz: float) -> float:
    """D [N] at no camber."""
    return (P["PDY1"] + P["PDY2"] * (fz / NOMINAL - 1.0)) * fz


def stiffness(fz):
    """B C D [N/rad]."""
    return P["PKY1"] * NOMINAL * np.sin(P["PKY4"] * np.arctan(fz / (P["PKY2"] * NOMINAL)))


def side_force(fz, alpha, gamma):
    """Fy [N] in ISO W."""
    d = peak(fz) * (1.0 - P["PDY3"] * gamma**2)
    b = stiffness(fz) / (P["PCY1"] * d)
    x = b * (alpha + P["PKY6"] * fz * gamma / stiffness(fz))
    return d * np.sin(P["PCY1"] * np.arctan(x - P["PEY1"] * (x - np.arctan(x))))


def moment(fz, alpha, gamma):
    """Mz [Nm] in ISO W: the trail at the side force without camber, and the residual moment."""
    more = fz / NOMINAL - 1.0
    x = (Q["QBZ1"] + Q["QBZ2"] * more) * (alpha + Q["QHZ1"])
    inner = x - (Q["QEZ1"] + Q["QEZ2"] * more) * (x - np.arctan(x))
    longest = (Q["QDZ1"] + Q["QDZ2"] * more) * (1.0 + Q["QDZ3"] * gamma)
    trail = longest * RADIUS * fz / NOMINAL * np.cos(Q["QCZ1"] * np.arctan(inner)) * np.cos(alpha)
    rest = Q["QDZ6"] + (Q["QDZ8"] + Q["QDZ9"] * more) * gamma
    turned = alpha + P["PKY6"] * fz * gamma / stiffness(fz)
    rest = rest * fz * RADIUS * np.cos(alpha) / np.sqrt(1.0 + (Q["QBZ9"] * turned) ** 2)
    return rest - trail * side_force(fz, alpha, 0.0)


def sweep(
    slip: np.ndarray, gammas: Sequence[float] = (0.0,), passes: int = 2, seed: int = 1
) -> dict[str, np.ndarray]:
    """Channels in ISO W and SI: each load at each camber [deg], with the same slip [deg]."""
    random = np.random.default_rng(seed)
    levels = [(g, f) for _ in range(passes) for g in gammas for f in LOADS]
    gamma, fz = (np.repeat(np.array(v), len(slip)) for v in zip(*levels, strict=True))
    alpha, gamma = np.radians(np.tile(slip, len(levels))), np.radians(gamma)
    fy = side_force(fz, alpha, gamma) + NOISE * random.standard_normal(len(fz))
    mz = moment(fz, alpha, gamma) + MOMENT_NOISE * random.standard_normal(len(fz))
    return {
        "ET": np.arange(1, 1 + len(fz)) / RATE, "SA": alpha, "IA": gamma, "FZ": fz, "FY": fy,
        "MZ": mz,
    }  # fmt: skip


def wave(n: int = 240) -> np.ndarray:
    """Slip angle there and back [deg]."""
    return 12.0 * np.sin(2.0 * np.pi * np.arange(n) / n + 1e-3)


def stairs(step: float, held: int = 6) -> np.ndarray:
    """Slip angle held in steps [deg]: up, down and up again."""
    up = np.arange(-12.0, 12.0 + 0.5 * step, step)
    return np.repeat(np.concatenate([up, up[::-1]]), held)


UNITS = {"ET": "s", "SA": "deg", "IA": "deg", "FZ": "N", "FY": "N", "MZ": "Nm"}
FACTORS = {"SA": 180.0 / np.pi, "IA": 180.0 / np.pi}


def text_of(
    columns: dict[str, np.ndarray], units: dict[str, str] | None = None, separator: str = ","
) -> str:
    """Names, units and numbers; the values in deg and N, or as `units` says after conversion."""
    named = UNITS | (units or {})
    shown = [FACTORS.get(k, 1.0) * v if k in UNITS else v for k, v in columns.items()]
    rows = [separator.join(f"{v:.7g}" for v in row) for row in zip(*shown, strict=True)]
    head = [separator.join(columns), separator.join(named.get(k, "-") for k in columns)]
    return "\n".join([*head, *rows, ""])


def files(folder: Path, text: str, name: str = "lateral.csv", encoding: str = "utf-8"):
    """The sweep and the exact tire file."""
    (folder / name).write_bytes(text.encode(encoding))
    (folder / "t.tir").write_text(TIR)
    return folder / name, folder / "t.tir"
