# SPDX-License-Identifier: Apache-2.0
"""Data of a pendulum and of a servo, simulated with code of their own: `solve_ivp` with dry
friction as a state that sticks or slips."""

from __future__ import annotations

import csv
import json
from pathlib import Path

import numpy as np
from scipy.integrate import solve_ivp


def swing(path: Path, mu: float = 0.0, viscous: float = 0.0, air: float = 0.0) -> Path:
    """A swing-out from 12 deg, encoder of 40000 counts, 1 kHz; friction over the inertia."""
    counts = 2.0 * np.pi / 40000
    state, began, parts = [0.21, 0.0], 0.0, []
    way = -1.0
    while began < 9.0:
        # between two turns the friction has one direction
        def motion(t, s, way=way):
            return [
                s[1],
                -60.0 * np.sin(s[0]) - viscous * s[1] - air * s[1] * abs(s[1]) - way * mu,
            ]

        def turn(t, s, way=way, began=began):
            return way * s[1] if t > began + 0.05 else 1.0

        turn.terminal = True
        done = solve_ivp(motion, (began, 9.5), state, events=turn, max_step=1e-3, rtol=1e-9)
        parts.append((done.t[:-1], done.y[0][:-1]))
        began, state = float(done.t[-1]), [float(done.y[0][-1]), 0.0]
        if abs(60.0 * np.sin(state[0])) <= mu:
            break
        way = -way
    time = np.arange(0.0, min(began, 9.0), 1e-3)
    angle = np.interp(time, *(np.concatenate([p[k] for p in parts]) for k in (0, 1)))
    rows = zip(time, np.round(angle / counts) * counts, strict=True)
    with path.open("w", newline="", encoding="utf-8") as file:
        csv.writer(file).writerows([("time", "theta"), *rows])
    return path


def goal(name: str, t: float) -> tuple[float, bool]:
    """Where the servo is told to go, and whether it has torque."""
    if name == "chirp":
        return float(np.sin(t * t)), True
    if name == "rise":
        return float(0.5 * np.pi * np.sin(0.5 * t)), True
    if name == "drop":
        return (
            (-0.25 * np.pi * (1.0 - np.cos(0.5 * np.pi * t)), True) if t < 2.0 else (-1.57, False)
        )
    return float(np.sin(t) * 0.5 * np.pi + 0.5 * np.sin(5.0 * t) * np.sin(2.0 * t)), True


NAMES = ("chirp", "rise", "drop", "both")


def servo(folder: Path, load: float = 0.0, stribeck: float = 0.0) -> Path:
    """Sixteen logs of 6 s: four trajectories, two masses, two gains; 4096 counts, 200 Hz."""
    folder.mkdir(exist_ok=True)
    rng = np.random.default_rng(5)
    for mass, length in ((0.4, 0.10), (0.9, 0.15)):
        for kp in (8, 32):
            for name in NAMES:
                log = {"mass": mass, "arm_mass": 0.05, "length": length, "kp": kp, "vin": 15.0,
                       "trajectory": name}  # fmt: skip
                log["entries"] = _log(log, load, stribeck, rng)
                path = folder / f"{name}_{mass}_{kp}.json"
                path.write_text(json.dumps(log), encoding="utf-8")
    return folder


def _log(log, load, stribeck, rng) -> list[dict]:
    inertia = (log["mass"] + log["arm_mass"] / 3) * log["length"] ** 2 + 0.02
    lever = (log["mass"] + log["arm_mass"] / 2) * 9.80665 * log["length"]
    dt, q, v, out = 2e-4, 0.0, 0.0, []
    for n in range(30000):
        t = n * dt
        target, on = goal(log["trajectory"], t)
        if n % 25 == 0:
            count = 2.0 * np.pi / 4096
            seen = np.round((q + 2e-4 * rng.standard_normal()) / count) * count
            entry = {"timestamp": t, "position": float(seen), "speed": v, "load": 0.0}
            out.append(entry | {"goal_position": target, "torque_enable": on})
        volts = 15.0 * float(np.clip(0.05 * log["kp"] * (target - q), -1.0, 1.0))
        drive = (0.6 * volts - 1.1 * v) if on else 0.0
        pull = drive - lever * np.sin(q)
        size = 0.09 + 0.04 * abs(v) + load * abs(drive + lever * np.sin(q))
        size += stribeck * np.exp(-((v / 0.4) ** 2))
        # sticks as long as the pull is less than the friction, slips against its motion else
        if abs(v) < 1e-3 and abs(pull) <= size:
            v = 0.0
        else:
            way = np.sign(v) if abs(v) >= 1e-3 else np.sign(pull)
            after = v + dt * (pull - way * size) / inertia
            v = 0.0 if v * after < 0.0 and abs(pull) <= size else after
        q += dt * v
    return out
