# SPDX-License-Identifier: Apache-2.0
"""Computes bridge volts from forces at the contact point: the inverse of thesis Appendix A, with
sensor errors.

(A.2) gives the wrench at the wheel centre, (A.1) the channels: C2, C3 from Fx, Mz; C5, C6 from Fz,
Mx; C1 from Fy; C4 measures no force and is only logged.
"""

from __future__ import annotations

import math

import numpy as np

from flatplank_sim.plant.compiling import inner

TURN = 2.0 * math.pi


@inner
def wheel_centre(m, fx, fy, fz, mx, my, mz, radius, gamma):
    """Fx, Fy, Fz, Mx, Mz at the wheel centre from the forces and moments at the contact point.

    m.spin_moment: 0: no moment about the spin axis is assumed, as in the thesis; 1: My is used.
    """
    cos = math.cos(gamma)
    sin = math.sin(gamma)
    fyc = cos * fy + sin * fz
    fzc = cos * fz - sin * fy
    thesis = (mz - radius * sin * fx) / cos
    full = cos * mz - sin * my
    mzc = full if m.spin_moment > 0.0 else thesis
    return fx, fyc, fzc, mx + radius * fyc, mzc


@inner
def bridge_scales(m):
    """Scale g 4e5 / A of the bridges, and arms of the outer and the inner bridges [m]."""
    outer = 0.3475 - m.et_value + m.adapter
    inner_arm = 0.0475 - m.et_value + m.adapter
    return m.gravity * 4e5 / m.amplification, outer, inner_arm


@inner
def volts(m, wheel, out):
    """C1..C6 [V] from Fx, Fy, Fz, Mx, Mz at the wheel centre."""
    base, outer, inner_arm = bridge_scales(m)
    span = outer - inner_arm
    u2 = (wheel[4] + inner_arm * wheel[0]) / span
    u3 = -wheel[0] - u2
    u6 = (wheel[3] - inner_arm * wheel[2]) / span
    u5 = wheel[2] - u6
    out[0] = wheel[1] * m.k_fy / base
    out[1] = u2 * m.k_fx1 / base
    out[2] = u3 * m.k_fx2 / base
    out[3] = 0.0
    out[4] = u5 * m.k_fz2 / base
    out[5] = u6 * m.k_fz1 / base


@inner
def quantise(x, step, most):
    """Quantise a value like an analogue-digital converter."""
    x = min(max(x, -most), most)
    return math.floor(x / step + 0.5) * step if step > 0.0 else x


def past_of_bridges(skew: float, dt: float) -> np.ndarray:
    """Make the memory of `lagged`: a ring of lagged values; the last row is for the last value
    before the lag."""
    return np.zeros((max(int(skew / dt) + 4, 4) + 1, 6))


@inner
def read_bridges(m, s, p, ts, mix, drift, work, history, noise, out):
    """One sample of the six bridges and the LVDT into `out` [V]."""
    my = -p.rolling * s.fz * s.height
    fx = ts.fx + s.slope_force
    mx = ts.uy * s.fz
    work[0], work[1], work[2], work[3], work[4] = wheel_centre(
        m, fx, ts.fy, s.fz, mx, my, ts.mz, s.height, s.gamma
    )
    if m.para_fx != 0.0 or m.para_fz != 0.0:
        work[0] += m.para_fx * math.sin(s.theta + m.para_phase)
        work[2] += m.para_fz * math.cos(s.theta + m.para_phase)
    for i in range(5):
        total = 0.0
        for j in range(5):
            total += mix[i, j] * work[j]
        work[5 + i] = total
    volts(m, work[5:10], out)
    if m.skew > 0.0 or m.lag > 0.0:
        lagged(m, s, history, out)
    hum = m.hum * math.sin(TURN * m.hum_frequency * s.t) if m.hum > 0.0 else 0.0
    for c in range(6):
        v = out[c] + drift[c, 0] + drift[c, 1] * s.t + m.noise_bridge * noise[c] + hum
        out[c] = quantise(v, m.adc_step, m.volts_max)
    v = (s.height - m.lvdt_zero) / m.lvdt_slope * (1.0 + drift[6, 1]) + drift[6, 0]
    out[6] = quantise(v + m.noise_lvdt * noise[6], m.adc_step, m.volts_max)


@inner
def lagged(m, s, history, out):
    """Apply first-order lag and pure delay to the bridge channels in `out`."""
    n = history.shape[0] - 1
    now = s.cycle % n
    before = (s.cycle - 1) % n
    lags = m.lag > 0.0 and s.cycle > 0
    part = m.dt / (m.lag + 0.5 * m.dt)
    for c in range(6):
        if not lags:
            history[now, c] = out[c]
        else:
            # trapezoidal rule: delays by exactly the lag at any rate
            mean = 0.5 * (history[n, c] + out[c])
            history[now, c] = history[before, c] + part * (mean - history[before, c])
        history[n, c] = out[c]
    delay = min(m.skew / m.dt, float(min(s.cycle, n - 2)))
    k = int(math.floor(delay))
    w = delay - k
    for c in range(6):
        out[c] = history[(now - k) % n, c] * (1.0 - w) + history[(now - k - 1) % n, c] * w


@inner
def forces_from_volts(m, v, radius, gamma, out):
    """Compute Fx..Mz at the contact point from C1..C6 by (A.1), (A.2) with nominal constants."""
    base, outer, inner_arm = bridge_scales(m)
    u2, u3 = base * v[1] / m.k_fx1, base * v[2] / m.k_fx2
    u5, u6 = base * v[4] / m.k_fz2, base * v[5] / m.k_fz1
    fx, fy, fz = -(u2 + u3), base * v[0] / m.k_fy, u5 + u6
    mx, mz = u5 * inner_arm + u6 * outer, u2 * outer + u3 * inner_arm
    cos, sin = math.cos(gamma), math.sin(gamma)
    out[0], out[1], out[2] = fx, cos * fy - sin * fz, sin * fy + cos * fz
    out[3] = mx - radius * fy
    out[4] = radius * cos * fx - sin * mz
    out[5] = radius * sin * fx + cos * mz
