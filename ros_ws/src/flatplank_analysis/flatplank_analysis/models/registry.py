# SPDX-License-Identifier: Apache-2.0
"""The transient models by name; a new model is one file and one line here."""

from __future__ import annotations

from collections.abc import Callable
from importlib import resources

from .base import TransientModel
from .linear import LinearX, LinearY
from .mf_contact_point import ContactPointMF
from .mf_tyre import MFTyre
from .nonlinear import NonlinearX, NonlinearY
from .nonlinear_mass import NonlinearMassX
from .tir import TirFile, check_tir, parse_tir

SHIPPED = ("toyo_nanoenergy", "continental_ecocontact")


def shipped_tir(name: str = SHIPPED[0]) -> TirFile:
    """A parameter set that comes with the package (thesis Table I.1)."""
    file = resources.files("flatplank_analysis") / "tire_data" / f"{name}.tir"
    tir = parse_tir(file.read_text(encoding="utf-8"), f"{name}.tir")
    check_tir(tir)
    return tir


MODELS: dict[str, Callable[[], TransientModel]] = {
    "linear": LinearX,
    "linear-y": LinearY,
    "nonlinear": NonlinearX,
    "nonlinear-y": NonlinearY,
    "nonlinear-mass": NonlinearMassX,
    "mf": lambda: MFTyre(shipped_tir().coefficients, ("PKX1", "PDX1")),
    "mf-contact-point": lambda: ContactPointMF(shipped_tir().coefficients, ("PKX1", "PDX1")),
    "mf-y": lambda: MFTyre(shipped_tir().coefficients, ("PKY1", "PDY1"), "fy"),
}
