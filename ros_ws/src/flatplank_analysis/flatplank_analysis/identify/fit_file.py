# SPDX-License-Identifier: Apache-2.0
"""The file of a fit (YAML): what is free, fixed, bounded, has a prior.

```yaml
format: flatplank-fit/1
model: mf                      # linear | nonlinear | mf
campaigns: [../toyo, ../toyo_repeat]   # merged; may be left to the command line
tire: start.tir                # mf: what is not fitted
stages: [pure_x, pressure]     # mf: any of the stages, a single one too
free: [PKX2]
fixed: {PKX3: 0.0}             # nonlinear: friction, tread_stiffness
bounds: {PCX1: [1.0, 2.0]}     # nonlinear: c_cx
prior: {PEX4: [0.0, 0.1]}      # value, standard deviation
weights: {fx: 1.0}
joint: true
geometry: {vertical_stiffness: 2.13e5}   # nonlinear: Table 7.2
```
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field, fields
from pathlib import Path
from typing import Any

import yaml

from flatplank_data.errors import FlatplankError
from flatplank_data.params import alike
from flatplank_data.yaml_text import load_yaml

from ..models.contact import ContactGeometry
from .mf.fit import MFSettings
from .mf.parameters import COEFFICIENTS
from .mf.problem import Prior
from .mf.stages import STAGES

FORMAT = "flatplank-fit/1"
NONLINEAR_FIXED = ("friction", "tread_stiffness")


@dataclass(frozen=True)
class FitFile:
    """Contents of a fit file."""

    model: str = "linear"
    campaigns: tuple[str, ...] = ()
    tire: str = ""
    stages: tuple[str, ...] = tuple(STAGES)
    free: tuple[str, ...] = ()
    fixed: Mapping[str, float] = field(default_factory=dict)
    bounds: Mapping[str, tuple[float, float]] = field(default_factory=dict)
    prior: Mapping[str, tuple[float, float]] = field(default_factory=dict)
    weights: Mapping[str, float] = field(default_factory=dict)
    joint: bool = True
    geometry: Mapping[str, float] = field(default_factory=dict)

    def mf_settings(self) -> MFSettings:
        """As the Magic Formula fit takes it."""
        priors = {k: Prior(*v) for k, v in self.prior.items()}
        return MFSettings(
            self.stages, self.fixed, self.free, self.bounds, priors, self.weights, self.joint
        )

    def carcass_options(self) -> dict[str, Any]:
        """Keyword arguments of `fit_carcass`."""
        options: dict[str, Any] = {k: v for k, v in self.fixed.items() if k in NONLINEAR_FIXED}
        if "c_cx" in self.bounds:
            options["bounds"] = self.bounds["c_cx"]
        if self.geometry:
            options["geometry"] = ContactGeometry(**self.geometry)
        return options

    def to_yaml(self) -> str:
        """Text of the file; reading it gives the same object."""
        plain: dict[str, Any] = {"format": FORMAT}
        for item in fields(self):
            value = getattr(self, item.name)
            if isinstance(value, tuple):
                value = list(value)
            elif isinstance(value, Mapping):
                value = {k: list(v) if isinstance(v, tuple) else v for k, v in value.items()}
            plain[item.name] = value
        return yaml.safe_dump(plain, sort_keys=False)


def read_fit_file(path: str | Path) -> FitFile:
    """Read and check a fit file."""
    try:
        text = Path(path).read_text(encoding="utf-8")
    except (OSError, UnicodeDecodeError) as error:
        told = getattr(error, "strerror", None) or "is no text"
        raise FlatplankError(told, str(path), "give a fit file") from None
    return parse_fit(load_yaml(text, str(path)), str(path))


def parse_fit(raw: Any, where: str = "fit file") -> FitFile:
    """Check keys, names and numbers of a fit file's contents."""
    if not isinstance(raw, Mapping) or raw.get("format") != FORMAT:
        raise FlatplankError(f"format is not {FORMAT}", where, f"begin with format: {FORMAT}")
    known = {f.name for f in fields(FitFile)}
    values: dict[str, Any] = {}
    for key, value in raw.items():
        if key == "format":
            continue
        if key not in known:
            raise FlatplankError(f"unknown key {key}", where, _nearest(str(key), known))
        values[key] = _typed(key, value, where)
    fit = FitFile(**values)
    _check_names(fit, where)
    return fit


def _typed(key: str, value: Any, where: str) -> Any:
    try:
        if key in ("campaigns", "stages", "free"):
            return tuple(str(v) for v in value)
        if key in ("bounds", "prior"):
            return {str(k): (float(v[0]), float(v[1])) for k, v in value.items()}
        if key in ("fixed", "weights", "geometry"):
            return {str(k): float(v) for k, v in value.items()}
        return bool(value) if key == "joint" else str(value)
    except (TypeError, ValueError, AttributeError, IndexError, KeyError):
        raise FlatplankError(f"{key}: {value!r} is not understood", where, _shape(key)) from None


def _shape(key: str) -> str:
    pairs = "write NAME: [number, number]"
    return {"bounds": pairs, "prior": pairs}.get(key, "write a list of names or NAME: number")


def _check_names(fit: FitFile, where: str) -> None:
    allowed: dict[str, set[str]] = {
        "stages": set(STAGES),
        "free": set(COEFFICIENTS),
        "fixed": set(COEFFICIENTS) | set(NONLINEAR_FIXED),
        "bounds": set(COEFFICIENTS) | {"c_cx"},
        "prior": set(COEFFICIENTS),
        "geometry": {f.name for f in fields(ContactGeometry)},
    }
    for key, names in allowed.items():
        for name in getattr(fit, key):
            if name not in names:
                raise FlatplankError(f"{key}: unknown name {name}", where, _nearest(name, names))
    for name, (low, high) in fit.bounds.items():
        if not low < high:
            raise FlatplankError(f"bounds of {name} are {low:g}, {high:g}", where, "low first")
    for name, (_, std) in fit.prior.items():
        if not std > 0.0:
            raise FlatplankError(
                f"prior of {name} has spread {std:g}", where, "give a positive one"
            )


def _nearest(name: str, known: set[str]) -> str:
    return f"did you mean {alike(name, known, 0.0)[0]}?"
