# SPDX-License-Identifier: Apache-2.0
"""Magic Formula 5.2 for one point in plain `math`, every term spelt out; no turn slip.

Written from the list of equations of 5.2 (Pacejka 2006, section 4.3.2; manual of MF-Tyre 5.2).
"""

from __future__ import annotations

from math import atan, copysign, cos, exp, sin, sqrt, tan


def _sgn(x: float) -> float:
    return 1.0 if x >= 0.0 else -1.0


def _inner(c: float, b: float, e: float, x: float) -> float:
    return c * atan(b * x - e * (b * x - atan(b * x)))


def forces(
    k: dict[str, float], fz: float, kappa: float, alpha: float, gamma: float, vx: float
) -> dict[str, float]:
    """Fx, Fy, Mz, Mx and the relaxation lengths at one operating point."""
    fz0, r0 = k["FNOMIN"], k["UNLOADED_RADIUS"]
    df = (fz - fz0 * k["LFZO"]) / (fz0 * k["LFZO"])
    gx, gy, gz = (gamma * k[f"LGA{n}"] for n in "XYZ")
    # longitudinal
    sx = kappa + (k["PHX1"] + k["PHX2"] * df) * k["LHX"]
    dx = (k["PDX1"] + k["PDX2"] * df) * (1 - k["PDX3"] * gx**2) * k["LMUX"] * fz
    kx = fz * (k["PKX1"] + k["PKX2"] * df) * exp(k["PKX3"] * df) * k["LKX"]
    ex = (k["PEX1"] + k["PEX2"] * df + k["PEX3"] * df**2) * (1 - k["PEX4"] * _sgn(sx)) * k["LEX"]
    cx = k["PCX1"] * k["LCX"]
    fx0 = dx * sin(_inner(cx, kx / (cx * dx + 1e-6), min(ex, 1.0), sx))
    fx0 += fz * (k["PVX1"] + k["PVX2"] * df) * k["LVX"] * k["LMUX"]
    bxa = k["RBX1"] * cos(atan(k["RBX2"] * kappa)) * k["LXAL"]
    exa = min(k["REX1"] + k["REX2"] * df, 1.0)
    fx = fx0 * cos(_inner(k["RCX1"], bxa, exa, alpha + k["RHX1"]))
    fx /= cos(_inner(k["RCX1"], bxa, exa, k["RHX1"]))
    # lateral
    muy = (k["PDY1"] + k["PDY2"] * df) * (1 - k["PDY3"] * gy**2) * k["LMUY"]
    ky = k["PKY1"] * fz0 * k["LFZO"] * k["LKY"] * (1 - k["PKY3"] * abs(gy))
    ky *= sin(2 * atan(fz / (k["PKY2"] * fz0 * k["LFZO"])))
    shy = (k["PHY1"] + k["PHY2"] * df) * k["LHY"] + k["PHY3"] * gy
    svy = (k["PVY1"] + k["PVY2"] * df) * k["LVY"] + (k["PVY3"] + k["PVY4"] * df) * gy
    svy *= fz * k["LMUY"]
    sy = alpha + shy
    ey = (k["PEY1"] + k["PEY2"] * df) * (1 - (k["PEY3"] + k["PEY4"] * gy) * _sgn(sy)) * k["LEY"]
    cy = k["PCY1"] * k["LCY"]
    by = ky / (cy * muy * fz + copysign(1e-6, muy))
    fy0 = muy * fz * sin(_inner(cy, by, min(ey, 1.0), sy)) + svy
    byk = k["RBY1"] * cos(atan(k["RBY2"] * (alpha - k["RBY3"]))) * k["LYKA"]
    eyk, shk = min(k["REY1"] + k["REY2"] * df, 1.0), k["RHY1"] + k["RHY2"] * df
    gyk = cos(_inner(k["RCY1"], byk, eyk, kappa + shk)) / cos(_inner(k["RCY1"], byk, eyk, shk))
    svk = muy * fz * (k["RVY1"] + k["RVY2"] * df + k["RVY3"] * gamma) * k["LVYKA"]
    svk *= cos(atan(k["RVY4"] * alpha)) * sin(k["RVY5"] * atan(k["RVY6"] * kappa))
    fy = fy0 * gyk + svk
    # aligning
    kyp = ky + copysign(1e-6, ky)
    st = alpha + k["QHZ1"] + k["QHZ2"] * df + (k["QHZ3"] + k["QHZ4"] * df) * gz
    sr = alpha + shy + svy / kyp
    bt = (k["QBZ1"] + k["QBZ2"] * df + k["QBZ3"] * df**2) * k["LKY"] / k["LMUY"]
    bt *= 1 + k["QBZ4"] * gz + k["QBZ5"] * abs(gz)
    et = k["QEZ1"] + k["QEZ2"] * df + k["QEZ3"] * df**2
    et *= 1 + (k["QEZ4"] + k["QEZ5"] * gz) * 2 / 3.141592653589793 * atan(bt * k["QCZ1"] * st)
    dt = fz * (k["QDZ1"] + k["QDZ2"] * df) * (1 + k["QDZ3"] * gz + k["QDZ4"] * gz**2)
    dt *= r0 / fz0 * k["LTR"]
    steq, sreq = (_sgn(s) * atan(sqrt(tan(s) ** 2 + (kx / kyp * kappa) ** 2)) for s in (st, sr))
    trail = dt * cos(_inner(k["QCZ1"], bt, min(et, 1.0), steq))
    trail *= vx / (abs(vx) * sqrt(1 + tan(alpha) ** 2) + 1e-6)  # cos(alpha), finite at rest
    dr = (k["QDZ6"] + k["QDZ7"] * df) * k["LRES"] + (k["QDZ8"] + k["QDZ9"] * df) * gz
    br = k["QBZ9"] * k["LKY"] / k["LMUY"] + k["QBZ10"] * by * cy
    mzr = dr * fz * r0 * k["LMUY"] * cos(atan(br * sreq)) * cos(alpha)
    arm = k["SSZ1"] + k["SSZ2"] * fy / fz0 + (k["SSZ3"] + k["SSZ4"] * df) * gamma
    mz = -trail * (fy - svk) + mzr + arm * r0 * k["LS"] * fx
    # overturning, relaxation
    mx = (k["QSX3"] * fy / fz0 - k["QSX2"] * gamma) * k["LMX"]
    sigma_x = (k["PTX1"] + k["PTX2"] * df) * exp(-k["PTX3"] * df) * fz * r0 / fz0 * k["LSGKP"]
    sigma_y = k["PTY1"] * sin(2 * atan(fz / (k["PTY2"] * fz0 * k["LFZO"])))
    sigma_y *= (1 - k["PKY3"] * abs(gy)) * r0 * k["LFZO"] * k["LSGAL"]
    return {
        "fx": fx, "fy": fy, "mz": mz, "mx": r0 * fz * (k["QSX1"] * k["LVMX"] + mx),
        "sigma_x": sigma_x, "sigma_y": sigma_y,
    }  # fmt: skip
