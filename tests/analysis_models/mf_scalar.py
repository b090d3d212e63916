# SPDX-License-Identifier: Apache-2.0
"""The Magic Formula once more, for one point and in plain `math`: every term spelt out.

Written from the equation list of Besselink, Schmeitz, Pacejka (2010), (A1)-(A60), so that a slip
of the pen in the array code does not stay hidden behind coefficients that are zero. Turn
slip is from Pacejka (2012), 4.75 to 4.106.
"""

from __future__ import annotations

from math import acos, atan, copysign, cos, exp, pi, sin, sqrt, tan


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
    turn: tuple[float, float] | None = None,
) -> dict[str, float]:
    """Fx, Fy, Mz, Mx and the slip stiffnesses at one operating point.

    turn: path curvature [1/m] and effective rolling radius [m].
    """
    fz0 = k["FNOMIN"] * k["LFZO"]
    df, dp = fz / fz0 - 1.0, p / k["NOMPRES"] - 1.0
    g, g2, ag = gamma, gamma * gamma, abs(gamma)
    most = 1.0 if k["CAP_E"] else float("inf")
    tangent, angle = bool(k["TAN_ALPHA"]), alpha
    alpha = tan(angle) if tangent else angle
    lmux, lmuy = (
        k["A_MU"] * k[name] / (1 + (k["A_MU"] - 1) * k[name]) for name in ("LMUX", "LMUY")
    )
    zeta1 = zeta2 = zeta3 = zeta5 = zeta6 = zeta7 = 1.0
    r0, phi, eps = k["UNLOADED_RADIUS"], 0.0, 0.0
    if turn is not None:
        eps = k["PECP1"] + k["PECP1"] * k["PECP2"] * df
        phi = turn[0] + (1 - eps) * (1 + kappa) * cos(angle) / turn[1] * sin(gamma)
        zeta1 = cos(
            atan(k["PDXP1"] * (1 + k["PDXP2"] * df) * cos(atan(k["PDXP3"] * kappa)) * r0 * phi)
        )
        byp = k["PDYP1"] * (1 + k["PDYP2"] * df) * cos(atan(k["PDYP3"] * tan(angle)))
        zeta2 = cos(atan(byp * (r0 * abs(phi) + k["PDYP4"] * sqrt(r0 * abs(phi)))))
        zeta3 = cos(atan(k["PKYP1"] * r0**2 * phi**2))
        zeta5 = cos(atan(k["QDTP1"] * r0 * phi))
        zeta6 = cos(atan(k["QBRP1"] * r0 * phi))
    # longitudinal
    kx = fz * (k["PKX1"] + k["PKX2"] * df) * exp(k["PKX3"] * df)
    kx *= (1 + k["PPX1"] * dp + k["PPX2"] * dp**2) * k["LKX"]
    mux = (k["PDX1"] + k["PDX2"] * df) * (1 - k["PDX3"] * g2) * k["LMUX"]
    mux *= 1 + k["PPX3"] * dp + k["PPX4"] * dp**2
    cx = k["PCX1"] * k["LCX"]
    shx = (k["PHX1"] + k["PHX2"] * df) * k["LHX"]
    svx = fz * (k["PVX1"] + k["PVX2"] * df) * k["LVX"] * lmux * zeta1
    sx = kappa + shx
    ex = (k["PEX1"] + k["PEX2"] * df + k["PEX3"] * df**2) * (1 - k["PEX4"] * _sgn(sx)) * k["LEX"]
    dx = mux * fz * zeta1
    fx0 = _mf(dx, cx, kx / (cx * dx + 1e-6), min(ex, most), sx) + svx
    bxa = (k["RBX1"] + k["RBX3"] * g2) * cos(atan(k["RBX2"] * kappa)) * k["LXAL"]
    exa = min(k["REX1"] + k["REX2"] * df, most)
    fx = fx0 * _mfc(1, k["RCX1"], bxa, exa, alpha + k["RHX1"])
    fx /= _mfc(1, k["RCX1"], bxa, exa, k["RHX1"])

    def pure_side(
        cam: float, spun: bool = True
    ) -> tuple[float, float, float, float, float, float]:
        c2 = cam * cam
        spun = spun and turn is not None
        z2, z3 = (zeta2, zeta3) if spun else (1.0, 1.0)
        load = (k["PKY2"] + k["PKY5"] * c2) * (1 + k["PPY2"] * dp)
        ky = k["PKY1"] * fz0 * (1 + k["PPY1"] * dp) * (1 - k["PKY3"] * abs(cam))
        ky *= sin(k["PKY4"] * atan(fz / fz0 / load)) * k["LKY"] * z3
        svg = fz * (k["PVY3"] + k["PVY4"] * df) * cam * k["LKYC"] * lmuy * z2
        kyg = fz * (k["PKY6"] + k["PKY7"] * df) * (1 + k["PPY5"] * dp) * k["LKYC"]
        shy = (k["PHY1"] + k["PHY2"] * df) * k["LHY"]
        if not spun:
            shy += (kyg * cam - svg) / (ky + copysign(1e-6, ky))
        else:
            ky0 = k["PKY1"] * fz0 * (1 + k["PPY1"] * dp) * z3 * k["LKY"]
            ky0 *= sin(k["PKY4"] * atan(fz / fz0 / (k["PKY2"] * (1 + k["PPY2"] * dp))))
            chyp, dhyp = k["PHYP1"], (k["PHYP2"] + k["PHYP3"] * df) * _sgn(vx)
            bhyp = kyg / (1 - eps) / (chyp * dhyp * (ky0 + copysign(1e-6, ky0)))
            shy += _mf(dhyp, chyp, bhyp, k["PHYP4"], r0 * phi) * _sgn(vx)
            shy -= svg / (ky + copysign(1e-6, ky))
        svy = fz * (k["PVY1"] + k["PVY2"] * df) * k["LVY"] * lmuy * z2 + svg
        sy = alpha + shy
        muy = (k["PDY1"] + k["PDY2"] * df) * (1 - k["PDY3"] * c2) * k["LMUY"]
        muy *= 1 + k["PPY3"] * dp + k["PPY4"] * dp**2
        ey = 1 + k["PEY5"] * c2 - (k["PEY3"] + k["PEY4"] * cam) * _sgn(sy)
        ey = min((k["PEY1"] + k["PEY2"] * df) * ey * k["LEY"], most)
        cy = k["PCY1"] * k["LCY"]
        by = ky / (cy * muy * fz * z2 + copysign(1e-6, muy))
        return _mf(muy * fz * z2, cy, by, ey, sy) + svy, ky, muy, shy, svy, by * cy

    fy0, ky, muy, shy, svy, bycy = pure_side(g)
    byk = (k["RBY1"] + k["RBY4"] * g2) * cos(atan(k["RBY2"] * (alpha - k["RBY3"]))) * k["LYKA"]
    eyk = min(k["REY1"] + k["REY2"] * df, most)
    shk = k["RHY1"] + k["RHY2"] * df
    gyk = _mfc(1, k["RCY1"], byk, eyk, kappa + shk) / _mfc(1, k["RCY1"], byk, eyk, shk)
    dvk = muy * fz * (k["RVY1"] + k["RVY2"] * df + k["RVY3"] * g)
    dvk *= cos(atan(k["RVY4"] * alpha)) * zeta2
    fy = gyk * fy0 + dvk * sin(k["RVY5"] * atan(k["RVY6"] * kappa)) * k["LVYKA"]
    # aligning moment
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
    trail = _mfc(dt, k["QCZ1"], bt, min(et, most), steq) * course * zeta5
    dr = (k["QDZ6"] + k["QDZ7"] * df) * k["LRES"] * zeta2
    tilt = (k["QDZ8"] + k["QDZ9"] * df) * (1 + k["PPZ2"] * dp)
    if turn is None:
        dr += (tilt + (k["QDZ10"] + k["QDZ11"] * df) * ag) * g * k["LKZC"]
    dr *= fz * r0 * k["LMUY"] * _sgn(vx) * cos(angle)
    br = (k["QBZ9"] * k["LKY"] / k["LMUY"] + k["QBZ10"] * bycy) * zeta6
    if turn is not None:
        mzinf = k["QCRP1"] * abs(muy) * r0 * fz * sqrt(fz / fz0) * k["LMP"]
        ddrp = mzinf / sin(pi / 2 * k["QDRP1"])
        kzgr = k["QDZ8"] + k["QDZ9"] * df + (k["QDZ10"] + k["QDZ11"] * df) * ag
        bdrp = fz * r0 * kzgr * k["LKZC"] / (k["QDRP1"] * ddrp * (1 - eps))
        drp = _mf(ddrp, k["QDRP1"], bdrp, k["QDRP2"], r0 * phi)
        mz90 = mzinf * 2 / pi * atan(k["QCRP2"] * r0 * abs(turn[0])) * gyk
        zeta7 = 2 / pi * acos(max(min(mz90 / (abs(drp) + 1e-6), 1.0), -1.0))
        dr += drp
    arm = k["SSZ1"] + k["SSZ2"] * fy / k["FNOMIN"] + (k["SSZ3"] + k["SSZ4"] * df) * g
    mz = -trail * gyk * pure_side(0.0, spun=False)[0] + dr * cos(zeta7 * atan(br * sreq))
    mz += r0 * arm * k["LS"] * fx
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
    my *= _sgn(vx)  # it resists
    return {"fx": fx, "fy": fy, "mz": mz, "mx": mx, "my": my, "kx": kx, "ky": ky}
