# SPDX-License-Identifier: Apache-2.0
"""Results of fits: numbers with their uncertainty and bounds, and what is not determined."""

from __future__ import annotations

import math
from dataclasses import dataclass, field, fields, is_dataclass, replace
from typing import Any

import numpy as np
from scipy.special import stdtrit

from flatplank_data.wording import plain

NORMAL_90 = 1.645
"""half width of a two-sided 90 % interval of a normal distribution, in standard deviations"""


@dataclass(frozen=True)
class Estimate:
    """One fitted parameter."""

    name: str
    value: float
    unit: str = "-"
    std_error: float = math.nan
    """Standard error from autocorrelated noise and run-to-run scatter; NaN when not determined."""
    dof: float = math.inf
    """Degrees of freedom of the standard error, for the t distribution."""
    at_bound: str = ""
    """Bound on which the value rests: "lower", "upper", or empty."""
    determined: bool = True
    """False when the data do not determine this parameter."""
    fixed: bool = False
    note: str = ""

    @property
    def text(self) -> str:
        """The value with five digits, in parentheses where it is not determined."""
        text = plain(self.value, 5)
        return text if self.determined else f"({text})"

    def interval(self, level: float = 0.90) -> tuple[float, float]:
        """Interval that contains the true value with this probability; infinite if unknown."""
        if not (self.determined and math.isfinite(self.std_error)):
            return (-math.inf, math.inf)
        reach = t_quantile(0.5 + level / 2.0, self.dof) * self.std_error
        return (self.value - reach, self.value + reach)

    def times(self, factor: float) -> Estimate:
        """The estimate multiplied by a known factor."""
        return replace(self, value=factor * self.value, std_error=factor * self.std_error)

    def with_note(self, text: str) -> Estimate:
        """The estimate with one more note; unchanged without a text."""
        return replace(self, note="; ".join(filter(None, (self.note, text))))

    def to_json(self) -> dict[str, Any]:
        """Plain values, with the 90 % interval."""
        low, high = self.interval()
        return to_plain(self) | {"interval90": to_plain([low, high])}


@dataclass(frozen=True)
class Confusion:
    """Parameters that these data cannot separate, and the run that would separate them."""

    names: tuple[str, ...]
    correlation: float
    """Largest correlation inside the group, or 1 when a direction is not determined at all."""
    statement: str
    remedy: str

    def to_json(self) -> dict[str, Any]:
        """Plain values."""
        return to_plain(self)


@dataclass(frozen=True)
class Fit:
    """Result of one identification."""

    model: str
    estimates: tuple[Estimate, ...]
    correlation: np.ndarray = field(repr=False)
    confusions: tuple[Confusion, ...] = ()
    rmse: float = math.nan
    """Root mean square of the unweighted residual, in the output's unit."""
    runs: int = 0
    converged: bool = True
    notes: tuple[str, ...] = ()

    def __getitem__(self, name: str) -> Estimate:
        return next(e for e in self.estimates if e.name == name)

    def to_json(self) -> dict[str, Any]:
        """Plain values, ready for json.dumps."""
        plain = {f.name: to_plain(getattr(self, f.name)) for f in fields(self)}
        return plain | {"estimates": [e.to_json() for e in self.estimates]}


def t_quantile(probability: float, dof: float) -> float:
    """Quantile of Student's t distribution."""
    return float(stdtrit(min(max(dof, 1.0), 1e6), probability))


def plain_condition(condition: Any) -> Any:
    """A condition as JSON has it: its fields by name, or its text."""
    fields_of = getattr(condition, "_asdict", None)
    return to_plain(fields_of()) if fields_of else str(condition)


def to_plain(value: Any) -> Any:
    """Dataclasses, arrays and NaN as JSON has them (NaN and infinity become None).

    A field may have another key there, as its metadata `json`.
    """
    if hasattr(value, "to_json") and not isinstance(value, (Fit, Estimate, Confusion)):
        return value.to_json()
    if is_dataclass(value) and not isinstance(value, type):
        names = {f.name: f.metadata.get("json", f.name) for f in fields(value)}
        return {key: to_plain(getattr(value, name)) for name, key in names.items()}
    if isinstance(value, dict):
        return {str(k): to_plain(v) for k, v in value.items()}
    if isinstance(value, np.ndarray):
        return to_plain(value.tolist())
    if isinstance(value, (list, tuple)):
        return [to_plain(v) for v in value]
    if isinstance(value, (float, np.floating)):
        return float(value) if math.isfinite(value) else None
    if isinstance(value, np.generic):
        return value.item()
    return value


def rmse(measured: np.ndarray, modelled: np.ndarray, mask: np.ndarray | None = None) -> float:
    """Root-mean-square error over the samples of the mask, in the unit of the data."""
    error = np.asarray(measured, float) - np.asarray(modelled, float)
    if mask is not None:
        error = error[mask]
    return float(np.sqrt(np.mean(error**2))) if error.size else float("nan")


def relative_error(measured: np.ndarray, modelled: np.ndarray) -> float:
    """Relative error e_r of (7.28) as a fraction."""
    return float(np.sum(np.abs(measured - modelled)) / np.sum(np.abs(measured)))
