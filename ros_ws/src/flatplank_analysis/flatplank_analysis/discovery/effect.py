# SPDX-License-Identifier: Apache-2.0
"""An effect as the engine uses it: names, parameters, and the coordinate over which it shows."""

from __future__ import annotations

import dataclasses
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Any, ClassVar, Literal

import numpy as np

from flatplank_analysis.discovery.parameters import Parameter, parameters_of
from flatplank_analysis.discovery.runs import RunSet
from flatplank_analysis.word import Word
from flatplank_data.errors import FlatplankError

Kind = Literal["machine", "sensor", "tire"]
KINDS: Mapping[str, str] = {
    "machine": "a fault of the machine",
    "sensor": "a fault of a sensor",
    "tire": "the tire itself",
}
"""kinds of effects, in words"""


@dataclass(frozen=True)
class Effect:
    """Base of all effects. A subclass is a frozen dataclass whose `param` fields are fitted.

    Hooks define what an effect does; effect and model agree on them, and the engine only
    varies the parameters. With every parameter at its null value an effect does nothing.
    """

    identifier: ClassVar[str] = ""
    title: ClassVar[str] = ""
    kind: ClassVar[Kind] = "machine"
    coordinate: ClassVar[str] = ""
    """name of the coordinate (`RunSet.coordinates`) over which the effect shows"""
    source: ClassVar[str] = ""
    what: ClassVar[str] = ""
    """physical description on the machine"""
    check: ClassVar[str] = ""
    """how to check it on the machine"""
    shown_by: ClassVar[str] = ""
    """runs of the bench in which it shows; empty where any run does"""
    removes: ClassVar[str] = ""
    """remedy on the machine"""
    main: ClassVar[str] = ""
    """name of the parameter whose value is the size; empty: the first one"""
    generic: ClassVar[bool] = False
    """True for a free form without a physical cause: the law of the model is incomplete"""
    law: ClassVar[bool] = False
    """True for a part of the model's own law: what it alone explains is no fault of the machine"""
    instances: ClassVar[int] = 1
    """largest number of instances in one model, at different places"""
    rarity: ClassVar[int] = 0
    """of indistinguishable effects the one with the lowest number is named first"""
    in_base: ClassVar[float] = 0.0
    """part of the size that a `known` parameter of the base takes: the screening shows the rest"""
    order: ClassVar[int] = 0
    """hooks of a lower order act first"""
    file: ClassVar[str] = ""
    """the user's file that defines it; empty for all others"""

    @classmethod
    def parameters(cls) -> tuple[Parameter, ...]:
        return parameters_of(cls)

    @classmethod
    def main_parameter(cls) -> Parameter:
        """The parameter whose unit is that of the size."""
        found = [p for p in cls.parameters() if p.name == cls.main] or list(cls.parameters())
        return found[0]

    @classmethod
    def word(cls) -> Word:
        """What it is, for people, with the unit of its size."""
        sentence = f"{cls.what[0].upper()}{cls.what[1:].rstrip('.')}." if cls.what else ""
        return Word(cls.title, sentence, cls.main_parameter().unit)

    @classmethod
    def linear(cls) -> tuple[Parameter, ...]:
        """Parameters with a screening step; the screening is linear in them."""
        return tuple(p for p in cls.parameters() if p.screen != 0.0)

    @classmethod
    def variants(cls, runs: RunSet, residual: np.ndarray) -> list[dict[str, float]]:
        """Settings {name: value} of parameters without meaning at the null (position, period).

        residual (channels, runs, samples) may suggest them; see `scanned`.
        """
        return [{}]

    @classmethod
    def separable(cls, runs: RunSet, values: Mapping[str, float] | None = None) -> bool:
        """False where no residual of these runs can tell the effect, with the parameter values of
        a refit, from the base."""
        return True

    @classmethod
    def scanned(cls, runs: RunSet) -> int:
        """Number of settings that were tested to find the variants; divides the test level."""
        return 1

    @classmethod
    def held(cls) -> tuple[str, ...]:
        """Parameters that a variant sets and no fit changes."""
        return ()

    @classmethod
    def starts(cls) -> tuple[float, ...]:
        """Multiples of the screened size from which a refit is tried."""
        return (1.0,)

    @classmethod
    def size(cls, values: dict[str, float]) -> float:
        """The size that is reported, from the parameter values."""
        return values[cls.main_parameter().name]

    @classmethod
    def vector(cls, values: dict[str, float]) -> np.ndarray:
        """Values by name as an array, nulls where not named."""
        return np.array([values.get(p.name, p.null) for p in cls.parameters()], dtype=float)

    @classmethod
    def with_values(cls, values: np.ndarray, axes: int) -> Effect:
        """An instance whose parameters are arrays (sets, 1, ...) with `axes` extra axes.

        `values` has the shape (sets, parameters).
        """
        names = [p.name for p in cls.parameters()]
        shape = (len(values),) + (1,) * axes
        fields: dict[str, Any] = {n: values[:, i].reshape(shape) for i, n in enumerate(names)}
        return dataclasses.replace(cls(), **fields)


def call_hook(effect: type[Effect], hook: Callable[..., Any], *arguments: Any) -> Any:
    """Call a hook of an effect; its errors become a FlatplankError with the effect's name."""
    try:
        return hook(*arguments)
    except FlatplankError:
        raise
    except Exception as error:
        raise hook_error(effect, hook, f"raised {type(error).__name__}: {error}") from error


def hook_error(effect: type[Effect], hook: Callable[..., Any], what: str) -> FlatplankError:
    """The error for a wrong hook of an effect."""
    return FlatplankError(
        what,
        f"effect {effect.identifier}, {hook.__name__}()",
        "mend the file of the effect; `flatplank effects check FILE` tests it",
    )


def variants_of(
    effect: type[Effect], runs: RunSet, residual: np.ndarray
) -> list[dict[str, float]]:
    """Result of `variants`; FlatplankError when it fails or names an unknown parameter."""
    found = call_hook(effect, effect.variants, runs, residual)
    if not isinstance(found, list) or not all(isinstance(s, Mapping) for s in found):
        raise hook_error(effect, effect.variants, "gives no list of settings {parameter: value}")
    known = {p.name for p in effect.parameters()}
    for name in (name for setting in found for name in setting):
        if name not in known:
            raise hook_error(effect, effect.variants, f"sets '{name}', which is no parameter")
    return found
