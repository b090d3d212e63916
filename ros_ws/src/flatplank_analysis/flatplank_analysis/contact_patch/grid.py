# SPDX-License-Identifier: Apache-2.0
"""One zero-phase filter for inputs and outputs, and the nodes on which a run is computed.

Nodes are fine (20 Hz at 0.03 m/s) after the start and after the step, coarse (5 Hz) elsewhere.
They lie at equal plank positions in all runs, so that repeats can be compared node by node.
"""

from __future__ import annotations

import numpy as np
from numpy.lib.stride_tricks import sliding_window_view
from scipy.ndimage import gaussian_filter1d, maximum_filter1d

SPEED = 0.03
"""[m/s] speed for which node distances and the filter are given"""
FINE = 0.05 * SPEED
COARSE = 0.2 * SPEED
"""[m] fine and coarse distance of nodes"""
FILTER = 0.075
"""[s] standard deviation of the Gaussian filter at SPEED"""
SAMPLE = 0.05
"""[s] block length at SPEED; faster recordings are averaged in blocks first"""
START = 0.0005
"""[m] plank travel above which the run counts as started"""
WIDTHS = (0.4, 1.5, 5.0)
"""[s] widths of the curves through counted values, the narrow ones first"""
BEFORE = 0.4
"""[s] time before the start, at SPEED, that has nodes"""


def blocks(values: np.ndarray, count: int) -> np.ndarray:
    """Means of `count` samples, shape (samples // count, ...)."""
    rows = len(values) // count
    shape = (rows, count, *values.shape[1:])
    return values[: rows * count].reshape(shape).mean(axis=1)


def gaussian(values: np.ndarray, sigma: float) -> np.ndarray:
    """Zero-phase Gaussian along axis 0, `sigma` in samples; odd reflection at the ends, so that a
    ramp stays a ramp."""
    if sigma < 0.2:
        return values
    reach = min(int(np.ceil(4.0 * sigma)), len(values) - 1)
    kernel = np.exp(-0.5 * (np.arange(-reach, reach + 1) / sigma) ** 2)
    kernel /= kernel.sum()
    head = 2.0 * values[0] - values[reach:0:-1]
    tail = 2.0 * values[-1] - values[-2 : -reach - 2 : -1]
    padded = np.concatenate([head, values, tail])
    out = np.zeros_like(values)
    for i, weight in enumerate(kernel):
        out += weight * padded[i : i + len(values)]
    return out


def quantum(values: np.ndarray) -> float:
    """Step of a counting encoder, 0 when the values have no common step."""
    changes = np.abs(np.diff(values))
    # most files have single precision or a few digits; a finer step needs double precision
    for kind in (np.float32, np.float64):
        blur = 8.0 * float(np.finfo(kind).eps) * float(np.abs(values).max())
        step = _common_step(changes[changes > blur], blur)
        if step is not None:
            return step
    return 0.0


def _common_step(changes: np.ndarray, blur: float) -> float | None:
    """Number of which all changes are multiples but for rounding errors up to `blur`, 0 when there
    is none; None where the changes differ by too little for this precision."""
    gaps = np.diff(np.sort(changes))
    if np.any((gaps > blur) & (gaps <= 4.0 * blur)):
        return None
    gaps = gaps[gaps > blur]
    cells, counts = np.unique(np.round(changes / (2.0 * blur)), return_counts=True)
    if len(changes) < 20 or not len(gaps) or len(cells) > 400:
        return 0.0
    one = float(np.median(gaps[gaps < 1.5 * gaps.min()]))
    tried = one * np.linspace(0.7, 1.4, 3000)
    turns = np.exp(2j * np.pi * np.outer(1.0 / tried, cells * 2.0 * blur))
    sharp = np.abs(turns @ counts) / counts.sum()
    best = int(np.argmax(sharp))
    return float(tried[best]) if sharp[best] > 0.9 else 0.0


def unquantise(values: np.ndarray, step: float, sample: float) -> np.ndarray:
    """Replace counted values by a smooth curve where it stays within one encoder step of them.

    Counting adds waves of any length (a slip of 1 % beats with the sampling at 0.14 m) that are
    the same in every run, so that no mean removes them. Beside a change of the motion (start,
    step) the curve is the line through the counts on one side of it; where the motion changes
    the counts are kept. sample: samples per second at SPEED.
    """
    if step <= 0.0:
        return values
    out, kept, usual = values, np.ones(len(values)), []
    for seconds in WIDTHS:
        width = seconds * sample
        reach = min(int(3.0 * width) + 1, len(values) - 1)
        # odd reflection: a ramp stays a ramp at the ends
        padded = np.pad(values, reach, mode="reflect", reflect_type="odd")
        smooth = gaussian_filter1d(padded, width, truncate=3.0)[reach:-reach]
        # counters round down or to the nearest: a constant mean error
        centre = float(np.median(smooth - values))
        off = np.abs(smooth - values - centre)
        worst = maximum_filter1d(off, 2 * int(2.0 * width) + 1, mode="nearest")
        trust = gaussian_filter1d((worst < 0.6 * step).astype(float), 0.5 * width)
        trust = np.minimum(trust, worst < 0.6 * step)
        usual.append(np.quantile(worst[worst < 0.6 * step], 0.9) if np.any(trust) else 0.0)
        out, kept = out + trust * (smooth - centre - out), kept * (1.0 - trust)
    for seconds, off in zip(WIDTHS, usual, strict=True):
        length = int(2.0 * seconds * sample) + 1
        for side in (slice(None), slice(None, None, -1)):
            line, holds = _end_of_line(values[side], length, off)
            trust = kept[side] * holds
            out[side] += trust * (line - out[side])
    return out


def _end_of_line(values: np.ndarray, length: int, off: float) -> tuple[np.ndarray, np.ndarray]:
    """Per value the end of the line through it and those before it, `length` in all, and whether
    none of these is further from the line than `off`."""
    end, holds = values.copy(), np.zeros(len(values), dtype=bool)
    if length < 4 or length > len(values):
        return end, holds
    design = np.stack([np.ones(length), np.arange(length) - length + 1.0], axis=1)
    window = sliding_window_view(values, length)
    lines = window @ np.linalg.pinv(design).T
    worst = np.abs(window - lines @ design.T).max(axis=1)
    end[length - 1 :], holds[length - 1 :] = lines[:, 0], worst < off
    return end, holds


def smooth_columns(
    time: np.ndarray, columns: np.ndarray, speed: float, counted: tuple[int, ...] = ()
) -> tuple[np.ndarray, np.ndarray, dict[int, float]]:
    """Filter and decimate one run: (time, columns, noise), columns of shape (samples, channels).

    counted: columns of counting encoders; noise: error by their steps after the filter, by column.
    Column 0 is the plank position from 0. A recording that begins with the motion is extended
    backwards by a standstill: extended by a ramp, the motion would start sharply and the force
    would not.
    """
    dt = float(np.median(np.diff(time)))
    steps = {c: quantum(columns[:, c]) for c in counted}
    stretch = SPEED / max(speed, 1e-4)
    count = max(1, int(SAMPLE * stretch / dt + 0.25))
    time, columns = blocks(time, count), blocks(columns, count)
    for c, step in steps.items():
        columns[:, c] = unquantise(columns[:, c], step, stretch / (dt * count))
    time, columns = _standing(time, columns, stretch)
    width = FILTER * stretch / (dt * count)
    # white error of step / sqrt(12) after block mean and Gaussian
    share = np.sqrt(1.0 / (12.0 * count * max(2.0 * np.sqrt(np.pi) * width, 1.0)))
    noise = {c: float(share * step) for c, step in steps.items()}
    return time, gaussian(columns, width), noise


def _standing(
    time: np.ndarray, columns: np.ndarray, stretch: float
) -> tuple[np.ndarray, np.ndarray]:
    """The recording, extended backwards by its first values when it begins later than the nodes
    before the start."""
    dt = float(np.median(np.diff(time)))
    began = int(np.argmax(columns[:, 0] > START))
    if began * dt >= BEFORE * stretch:
        return time, columns
    more = int(np.ceil((BEFORE + 4.0 * FILTER) * stretch / dt)) - began
    early = time[0] - dt * np.arange(more, 0, -1)
    return np.concatenate([early, time]), np.concatenate([columns[[0] * more], columns])


def node_positions(step: float, end: float) -> np.ndarray:
    """Plank positions [m] of the nodes of a run with a step at `step` (NaN: no step)."""
    starts = [(0.0, FINE), (0.09, 2.0 * FINE), (0.15, COARSE)]
    if np.isfinite(step) and step > 0.2:
        starts += [(step - 2.0 * COARSE, FINE), (step + 0.15, 2.0 * FINE), (step + 0.4, COARSE)]
    starts.append((end, COARSE))
    parts = [
        np.arange(a, b - 0.5 * h, h)
        for (a, h), (b, _) in zip(starts[:-1], starts[1:], strict=True)
        if b > a
    ]
    return np.concatenate(parts)[1:]


def uniform_positions(end: float) -> np.ndarray:
    """Node positions [m] of a run whose slip changes all the time (waveforms)."""
    return np.arange(2.0 * FINE, end, 2.0 * FINE)
