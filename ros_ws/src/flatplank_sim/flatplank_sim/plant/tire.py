# SPDX-License-Identifier: Apache-2.0
"""The tire: bristles that travel through the contact patch, on a compliant carcass.

A bristle has a fixed position on the belt and moves with it from the leading edge (+a) to the
trailing edge (-a). Its tip sticks to the road until the shear force exceeds friction times the
parabolic pressure; then it slides in the direction of its slip. The sum of the bristle forces
deflects the carcass springs. The model depends on increments of travel, not of time, so a tire at
standstill has stiffness and hysteresis. Signs: ISO W; fx > 0 drives, fy < 0 for alpha > 0, fy < 0
for gamma > 0.
"""

from __future__ import annotations

import math

from flatplank_sim.plant.compiling import inner
from flatplank_sim.plant.layout import MAP_ROWS, MAP_START

TOLERANCE = 1e-5
"""imbalance between carcass and bristles that ends the iteration [N]"""
MAX_PASSES = 15


@inner
def contact(p, s, fz, pressure):
    """Set vertical stiffness, half contact length, friction and rolling radius in the state `s`
    for load [N] and pressure [bar]; returns tread stiffness x, y [N/m2] and carcass stiffness x, y
    [N/m].

    These are power laws of this plant.
    """
    pr = pressure / p.p0
    s.cz = p.cz * pr**p.cz_p
    if fz <= 0.0:
        s.a = 0.0
        return 0.0, 0.0, 0.0, 0.0
    load = fz / p.fz0
    rho = fz / s.cz
    s.a = p.a * (rho * p.cz / p.fz0) ** p.a_rho
    s.friction = p.mu * load**p.mu_f * pr**p.mu_p
    s.re = p.r0 - p.re_drop * rho / (rho + p.re_half)
    tread = pr**p.cp_p
    cx = p.cx * load**p.cx_f * pr**p.cx_p
    cy = p.cy * load**p.cy_f * pr**p.cy_p
    return p.cpx * tread, p.cpy * tread, cx, cy


@inner
def slide(tx, ty, cx, cy, limit):
    """Direction of the force on a sliding bristle, and its sliding distance: nx, ny, stretch.

    The tip slides by stretch * n against a force limit * n: solves t - limit n = stretch (cx nx,
    cy ny), |n| = 1.
    """
    size = math.sqrt(tx * tx + ty * ty)
    nx = tx / size
    ny = ty / size
    stretch = (size - limit) / (cx * nx * nx + cy * ny * ny)
    for _ in range(12):
        dx = limit + cx * stretch
        dy = limit + cy * stretch
        nx = tx / dx
        ny = ty / dy
        g = nx * nx + ny * ny - 1.0
        if abs(g) < 1e-10:
            break
        stretch += 0.5 * g / (nx * nx * cx / dx + ny * ny * cy / dy)
    size = math.sqrt(nx * nx + ny * ny)
    return nx / size, ny / size, stretch


@inner
def yielding(tx, ty, kx, ky, limit):
    """Force fx, fy of a sliding bristle, and its tangent stiffness xx, yy, xy."""
    if ty == 0.0:
        return math.copysign(limit, tx), 0.0, 0.0, ky * limit / abs(tx), 0.0
    if limit <= 0.0:
        return 0.0, 0.0, 0.0, 0.0, 0.0
    nx, ny, stretch = slide(tx, ty, kx, ky, limit)
    ax = kx / (limit + kx * stretch)
    ay = ky / (limit + ky * stretch)
    wx, wy = nx * ax, ny * ay
    d = nx * wx + ny * wy
    xx, yy, xy = limit * (ax - wx * wx / d), limit * (ay - wy * wy / d), -limit * wx * wy / d
    return limit * nx, limit * ny, xx, yy, xy


@inner
def map_row(x, rows):
    """Row of the road map at position x [m]."""
    return min(max(int((x + MAP_START) * MAP_ROWS), 0), rows - 1)


@inner
def move_belt(p, s, bristles, dq):
    """Move the belt by dq [m]; bristles that leave or enter the patch have no deflection."""
    first = int(math.ceil((s.q + dq - s.a) / p.spacing))
    last = int(math.floor((s.q + dq + s.a) / p.spacing))
    for j in range(s.first, s.last + 1):
        if j < first or j > last:
            k = j & (p.ring - 1)
            bristles[0, k] = 0.0
            bristles[1, k] = 0.0
    return first, last


@inner
def mean_pressure_sum(first, last, q, spacing, a):
    """Sum of 1 - (xi/a)^2 over the bristles in contact, closed form."""
    n = last - first + 1
    x0 = first * spacing - q
    squares = (
        n * x0 * x0 + x0 * spacing * n * (n - 1) + spacing**2 * (n - 1) * n * (2 * n - 1) / 6.0
    )
    return n - squares / (a * a)


@inner
def lift_off(p, s, bristles):
    """Reset the deflections of bristles and carcass, when there is no contact."""
    for j in range(s.first, s.last + 1):
        bristles[0, j & (p.ring - 1)] = 0.0
        bristles[1, j & (p.ring - 1)] = 0.0
    s.first, s.last = 0, -1
    s.ux = s.uy = s.ucx = 0.0
    s.fx = s.fy = s.mz = s.gx = s.gy = s.slide_share = 0.0


@inner
def patch_forces(p, s, b, first, last, q, shift, spin, peak, cx, cy, wear, x, road_map, mapped):
    """Forces of all bristles for a trial shift of the belt against the road; trial deflections go
    to b[2], b[3].

    shift = (dsx, dsy) of the belt centre [m], spin = turn of the belt [rad]; returns fx, fy, mz
    [N, N m], tangent stiffness xx, yy, xy [N/m] and the share of sliding bristles.
    """
    dsx, dsy = shift
    mask, spacing, a = p.ring - 1, p.spacing, s.a
    kx = cx * spacing
    ky = cy * spacing
    dq = q - s.q
    top = peak * wear
    inverse = 1.0 / (a * a)
    fx = fy = mz = sx = sy = sxy = 0.0
    sliding = 0
    for j in range(first, last + 1):
        k = j & mask
        xi = j * spacing - q
        part = 1.0
        if j < s.first or j > s.last:
            part = min((a - abs(xi)) / max(abs(dq), 1e-15), 1.0)
        tx = kx * (b[0, k] + part * dsx)
        ty = ky * (b[1, k] + part * (dsy - xi * spin))
        limit = top * (1.0 - xi * xi * inverse)
        if mapped:
            limit *= road_map[map_row(x + xi, road_map.shape[0]), 0]
        if tx < 0.0:
            limit *= 1.0 - p.brake_friction
        if tx * tx + ty * ty <= limit * limit:
            sx += part * kx
            sy += part * ky
            b[4, k] = 0.0
        else:
            sliding += 1
            b[4, k] = 1.0
            tx, ty, xx, yy, xy = yielding(tx, ty, kx, ky, limit)
            sx += part * xx
            sy += part * yy
            sxy += part * xy
        b[2, k] = tx / kx
        b[3, k] = ty / ky
        fx += tx
        fy += ty
        mz += xi * ty
    return fx, fy, mz, sx, sy, sxy, sliding / max(last - first + 1, 1)


@inner
def newton_step(p, s, cx, cy, ux, uy, fx, fy, sx, sy, sxy):
    """Newton step of the carcass deflection [m]; zero when carcass and bristles are in balance."""
    v = ux - s.ucx
    soft = 1.0 + p.softening * abs(v)
    rx = cx * v / soft - fx
    ry = cy * uy - fy
    if abs(rx) < TOLERANCE and abs(ry) < TOLERANCE:
        return 0.0, 0.0
    jx = cx / (soft * soft) + sx
    jy = cy + sy
    det = jx * jy - sxy * sxy
    return (ry * sxy - rx * jy) / det, (rx * sxy - ry * jx) / det


@inner
def accept_deflections(p, b, first, last):
    """Accept the trial deflections of the bristles."""
    for j in range(first, last + 1):
        k = j & (p.ring - 1)
        b[0, k] = b[2, k]
        b[1, k] = b[3, k]


@inner
def advance(p, s, b, fz, pressure, dq, dx, dy, turn, gamma, x, wear, road_map, mapped, dt):
    """One step of the tire; forces are left in the state.

    dq: belt travel [m]; dx, dy: travel of the wheel over the road along and across its plane [m];
    turn: turn of the wheel about z [rad]; gamma: camber [rad]; x: road position under the wheel
    [m]; wear: factor on friction; dt [s] only for creep.
    """
    cpx, cpy, cx, cy = contact(p, s, fz, pressure)
    if fz <= 0.0 or s.a < 2.0 * p.spacing:
        lift_off(p, s, b)
        s.q += dq
        return
    if p.creep > 0.0:
        s.ucx += (s.fx * p.creep / cx - s.ucx) * (1.0 - math.exp(-dt / p.creep_time))
    first, last = move_belt(p, s, b, dq)
    q = s.q + dq
    peak = s.friction * fz / mean_pressure_sum(first, last, q, p.spacing, s.a)
    dsx = dq - dx
    dsy = -dy - math.sin(p.ply_steer) * dq
    spin = turn + p.camber * (gamma + p.conicity) * dq / s.re
    ux = s.ux + s.gx * dsx / cx
    uy = s.uy + s.gy * dsy / cy
    fx = fy = mz = sx = sy = share = 0.0
    for _ in range(MAX_PASSES):
        shift = (dsx - (ux - s.ux), dsy - (uy - s.uy))
        fx, fy, mz, sx, sy, sxy, share = patch_forces(
            p, s, b, first, last, q, shift, spin, peak, cpx, cpy, wear, x, road_map, mapped
        )
        more_x, more_y = newton_step(p, s, cx, cy, ux, uy, fx, fy, sx, sy, sxy)
        if more_x == 0.0 and more_y == 0.0:
            break
        ux += more_x
        uy += more_y
    accept_deflections(p, b, first, last)
    s.q, s.first, s.last = q, first, last
    s.ux, s.uy, s.fx, s.fy, s.mz = ux, uy, fx, fy, mz - uy * fx
    s.gx = cx * sx / (cx + sx)
    s.gy = cy * sy / (cy + sy)
    s.slide_share = share
