# SPDX-License-Identifier: Apache-2.0
"""The Magic Formula once more, for one point and in plain `math`: every term spelt out.

Written from the equation list of Besselink, Schmeitz, Pacejka (2010), (A1)-(A60), so that a slip
of the pen in the array code does not stay hidden behind coefficients that are zero.
"""

from __future__ import annotations

from math import atan, copysign, cos, exp, sin, sqrt, tan


def _sgn(x: float) -> float:
    return 1.0 if x >= 0.0 else -1.0


def _mf(d: float, c: float, b: float, e: float, x: float) -> float:
    return d * sin(c * atan(b * x - e * (b * x - atan(b * x))))


def _mfc(d: float, c: float, b: float, e: float, x: float) -> float:
    return d * cos(c * atan(b * x - e * (b * x - atan(b * x))))


def forces(
    k: dict[str, float],
    fz: float,
    kappa: float,
    alpha: float,
    gamma: float,
    p: float,
    vx: float = 16.7,
) -> dict[str, float]:
    """Fx, Fy, Mz, Mx and the slip stiffnesses at one operating point."""
    fz0 = k["FNOMIN"] * k["LFZO"]
    df, dp = fz / fz0 - 1.0, p / k["NOMPRES"] - 1.0
    g, g2, ag = gamma, gamma * gamma, abs(gamma)
    most = 1.0 if k["CAP_E"] else float("inf")
    tangent, angle = bool(k["TAN_ALPHA"]), alpha
    alpha = tan(angle) if tangent else angle
    lmux, lmuy = (
        k["A_MU"] * k[name] / (1 + (k["A_MU"] - 1) * k[name]) for name in ("LMUX", "LMUY")
    )
    # longitudinal
    kx = fz * (k["PKX1"] + k["PKX2"] * df) * exp(k["PKX3"] * df)
    kx *= (1 + k["PPX1"] * dp + k["PPX2"] * dp**2) * k["LKX"]
    mux = (k["PDX1"] + k["PDX2"] * df) * (1 - k["PDX3"] * g2) * k["LMUX"]
    mux *= 1 + k["PPX3"] * dp + k["PPX4"] * dp**2
    cx = k["PCX1"] * k["LCX"]
    shx = (k["PHX1"] + k["PHX2"] * df) * k["LHX"]
    svx = fz * (k["PVX1"] + k["PVX2"] * df) * k["LVX"] * lmux
    sx = kappa + shx
    ex = (k["PEX1"] + k["PEX2"] * df + k["PEX3"] * df**2) * (1 - k["PEX4"] * _sgn(sx)) * k["LEX"]
    fx0 = _mf(mux * fz, cx, kx / (cx * mux * fz + 1e-6), min(ex, most), sx) + svx
    bxa = (k["RBX1"] + k["RBX3"] * g2) * cos(atan(k["RBX2"] * kappa)) * k["LXAL"]
    exa = min(k["REX1"] + k["REX2"] * df, most)
    fx = fx0 * _mfc(1, k["RCX1"], bxa, exa, alpha + k["RHX1"])
    fx /= _mfc(1, k["RCX1"], bxa, exa, k["RHX1"])

    def pure_side(cam: float) -> tuple[float, float, float, float, float, float]:
        c2 = cam * cam
        load = (k["PKY2"] + k["PKY5"] * c2) * (1 + k["PPY2"] * dp)
        ky = k["PKY1"] * fz0 * (1 + k["PPY1"] * dp) * (1 - k["PKY3"] * abs(cam))
        ky *= sin(k["PKY4"] * atan(fz / fz0 / load)) * k["LKY"]
        svg = fz * (k["PVY3"] + k["PVY4"] * df) * cam * k["LKYC"] * lmuy
        kyg = fz * (k["PKY6"] + k["PKY7"] * df) * (1 + k["PPY5"] * dp) * k["LKYC"]
        shy = (k["PHY1"] + k["PHY2"] * df) * k["LHY"]
        shy += (kyg * cam - svg) / (ky + copysign(1e-6, ky))
        svy = fz * (k["PVY1"] + k["PVY2"] * df) * k["LVY"] * lmuy + svg
        sy = alpha + shy
        muy = (k["PDY1"] + k["PDY2"] * df) * (1 - k["PDY3"] * c2) * k["LMUY"]
        muy *= 1 + k["PPY3"] * dp + k["PPY4"] * dp**2
        ey = 1 + k["PEY5"] * c2 - (k["PEY3"] + k["PEY4"] * cam) * _sgn(sy)
        ey = min((k["PEY1"] + k["PEY2"] * df) * ey * k["LEY"], most)
        cy = k["PCY1"] * k["LCY"]
        by = ky / (cy * muy * fz + copysign(1e-6, muy))
        return _mf(muy * fz, cy, by, ey, sy) + svy, ky, muy, shy, svy, by * cy

    fy0, ky, muy, shy, svy, bycy = pure_side(g)
    byk = (k["RBY1"] + k["RBY4"] * g2) * cos(atan(k["RBY2"] * (alpha - k["RBY3"]))) * k["LYKA"]
    eyk = min(k["REY1"] + k["REY2"] * df, most)
    shk = k["RHY1"] + k["RHY2"] * df
    gyk = _mfc(1, k["RCY1"], byk, eyk, kappa + shk) / _mfc(1, k["RCY1"], byk, eyk, shk)
    dvk = muy * fz * (k["RVY1"] + k["RVY2"] * df + k["RVY3"] * g)
    dvk *= cos(atan(k["RVY4"] * alpha))
    fy = gyk * fy0 + dvk * sin(k["RVY5"] * atan(k["RVY6"] * kappa)) * k["LVYKA"]
    # aligning moment
    r0 = k["UNLOADED_RADIUS"]
    kyp = ky + copysign(1e-6, ky)
    course = vx / (abs(vx) * sqrt(1 + tan(angle) ** 2) + 1e-6)
    st = alpha + k["QHZ1"] + k["QHZ2"] * df + (k["QHZ3"] + k["QHZ4"] * df) * g
    sr = alpha + shy + svy / kyp
    mixed = (kx / kyp * kappa) ** 2
    if tangent:
        steq, sreq = (_sgn(s) * sqrt(s * s + mixed) for s in (st, sr))
    else:
        steq, sreq = (_sgn(s) * atan(sqrt(tan(s) ** 2 + mixed)) for s in (st, sr))
    bt = (k["QBZ1"] + k["QBZ2"] * df + k["QBZ3"] * df**2) * k["LKY"] / k["LMUY"]
    bt *= 1 + k["QBZ4"] * g + k["QBZ5"] * ag
    et = k["QEZ1"] + k["QEZ2"] * df + k["QEZ3"] * df**2
    et *= 1 + (k["QEZ4"] + k["QEZ5"] * g) * 2 / 3.141592653589793 * atan(bt * k["QCZ1"] * st)
    dt = (k["QDZ1"] + k["QDZ2"] * df) * (1 - k["PPZ1"] * dp) * fz * r0 / fz0 * k["LTR"]
    dt *= (1 + k["QDZ3"] * g + k["QDZ4"] * g2) * k["LFZO"]
    trail = _mfc(dt, k["QCZ1"], bt, min(et, most), steq) * course
    dr = (k["QDZ6"] + k["QDZ7"] * df) * k["LRES"]
    tilt = (k["QDZ8"] + k["QDZ9"] * df) * (1 + k["PPZ2"] * dp)
    dr += (tilt + (k["QDZ10"] + k["QDZ11"] * df) * ag) * g * k["LKZC"]
    dr *= fz * r0 * k["LMUY"] * _sgn(vx) * cos(angle)
    br = k["QBZ9"] * k["LKY"] / k["LMUY"] + k["QBZ10"] * bycy
    arm = k["SSZ1"] + k["SSZ2"] * fy / k["FNOMIN"] + (k["SSZ3"] + k["SSZ4"] * df) * g
    mz = -trail * gyk * pure_side(0.0)[0] + dr * cos(atan(br * sreq)) + r0 * arm * k["LS"] * fx
    # overturning moment
    n, s = fz / k["FNOMIN"], fy / k["FNOMIN"]
    mx = k["QSX1"] * k["LVMX"] - k["QSX2"] * g * (1 + k["PPMX1"] * dp) - k["QSX12"] * g * ag
    mx += k["QSX3"] * s + k["QSX10"] * atan(k["QSX11"] * n) * g
    mx += (
        k["QSX4"]
        * cos(k["QSX5"] * atan((k["QSX6"] * n) ** 2))
        * sin(k["QSX7"] * g + k["QSX8"] * atan(k["QSX9"] * s))
    )
    mx = r0 * k["LMX"] * (fz * mx + fy * (k["QSX13"] + k["QSX14"] * ag))
    # rolling resistance
    v = vx / k["LONGVL"]
    my = k["QSY1"] + k["QSY2"] * fx / k["FNOMIN"] + k["QSY3"] * abs(v) + k["QSY4"] * v**4
    my += (k["QSY5"] + k["QSY6"] * n) * g2
    my *= -r0 * k["FNOMIN"] * n ** k["QSY7"] * (p / k["NOMPRES"]) ** k["QSY8"] * k["LMY"]
    return {"fx": fx, "fy": fy, "mz": mz, "mx": mx, "my": my, "kx": kx, "ky": ky}
