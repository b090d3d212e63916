# SPDX-License-Identifier: Apache-2.0
"""Frequency response over path frequency, from runs with a sine or a triangle of slip.

A first-order tire has H(s) = C / (1 + i 2 pi s sigma) over path frequency s [1/m] (7.11 over
distance).
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from flatplank_data.errors import FlatplankError

SHARE = 0.05
"""least amplitude of a line in the slip spectrum, as a share of the largest"""
MAX_FREQUENCY = 20.0
"""[1/m]: a wavelength of 50 mm, shorter than a contact patch"""


@dataclass(frozen=True)
class FrequencyResponse:
    """Fx over slip at a few path frequencies; arrays of shape (k,)."""

    frequency: np.ndarray
    """[1/m], increasing"""
    response: np.ndarray
    """complex, N per unit slip"""

    @property
    def gain(self) -> np.ndarray:
        """|H| [N]."""
        return np.abs(self.response)

    @property
    def phase_deg(self) -> np.ndarray:
        """Phase of Fx against the slip [deg]; negative: the force lags."""
        return np.degrees(np.angle(self.response))

    def first_order(self) -> tuple[float, float]:
        """sigma [m] and C [N] of the first-order response that fits best.

        1/H = (1 + i 2 pi s sigma)/C is linear in 1/C and sigma/C. Wavelengths much shorter than
        2 pi sigma determine only the ratio C/sigma.
        """
        inverse = 1.0 / self.response
        weight = np.abs(self.response)
        flexibility = float(np.average(inverse.real, weights=weight))
        path = 2.0 * np.pi * self.frequency
        slope = float(np.sum(weight * path * inverse.imag) / np.sum(weight * path**2))
        return slope / flexibility, 1.0 / flexibility


def frequency_response(
    distance: np.ndarray, slip: np.ndarray, force: np.ndarray, skip: float = 0.0
) -> FrequencyResponse:
    """Response at the lines of the slip's spectrum.

    `distance` uniform [m], `slip` [-], `force` [N], each (n,); the first `skip` metres contain the
    transient of the start and are left out. A whole number of periods is used.
    """
    keep = distance >= distance[0] + skip
    x, kappa, fx = distance[keep], slip[keep], force[keep]
    fundamental = _fundamental(x, kappa)
    periods = int(np.floor((x[-1] - x[0]) * fundamental + 1e-6))
    if periods < 1:
        raise FlatplankError(
            "less than one period of slip", "frequency response", "use a shorter wavelength"
        )
    whole = x <= x[0] + periods / fundamental
    x, kappa, fx = x[whole], kappa[whole], fx[whole]
    orders = np.arange(1, max(2, int(MAX_FREQUENCY / fundamental)))
    lines = fundamental * orders
    basis = _basis(x, lines)
    slip_lines = _amplitudes(basis, kappa)
    chosen = np.abs(slip_lines) >= SHARE * np.abs(slip_lines).max()
    force_lines = _amplitudes(basis, fx)
    return FrequencyResponse(lines[chosen], force_lines[chosen] / slip_lines[chosen])


def _fundamental(x: np.ndarray, kappa: np.ndarray) -> float:
    """Path frequency of the largest line, refined to least squares [1/m]."""
    spacing = float(np.mean(np.diff(x)))
    wave = kappa - kappa.mean()
    spectrum = np.abs(np.fft.rfft(wave * np.hanning(wave.size), 8 * wave.size))
    frequencies = np.fft.rfftfreq(8 * wave.size, spacing)
    inside = (frequencies > 0.5 / (x[-1] - x[0])) & (frequencies < MAX_FREQUENCY)
    if not inside.any() or np.ptp(kappa) == 0.0:
        raise FlatplankError("slip does not vary", "frequency response", "use a sine or triangle")
    coarse = float(frequencies[inside][np.argmax(spectrum[inside])])
    trials = coarse * np.linspace(0.9, 1.1, 201)
    bases = [_basis(x, np.array([f])) for f in trials]
    errors = [np.sum((b @ np.linalg.lstsq(b, wave, rcond=None)[0] - wave) ** 2) for b in bases]
    return float(trials[int(np.argmin(errors))])


def _basis(x: np.ndarray, lines: np.ndarray) -> np.ndarray:
    """Columns 1, x, then cos and sin of every line."""
    phase = 2.0 * np.pi * (x - x[0])[:, None] * lines
    return np.hstack([np.ones((x.size, 1)), (x - x.mean())[:, None], np.cos(phase), np.sin(phase)])


def _amplitudes(basis: np.ndarray, values: np.ndarray) -> np.ndarray:
    """Complex amplitude of every line: Re(A exp(i phase))."""
    found, *_ = np.linalg.lstsq(basis, values, rcond=None)
    count = (basis.shape[1] - 2) // 2
    return found[2 : 2 + count] - 1j * found[2 + count :]
