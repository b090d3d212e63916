# SPDX-License-Identifier: Apache-2.0
"""Numbers that are fitted: declared as `name = param(...)` in a class, handed to its methods."""

from __future__ import annotations

import dataclasses
import re
from collections.abc import Iterable
from types import SimpleNamespace

import numpy as np

from flatplank_analysis.discovery.effect import Effect
from flatplank_analysis.discovery.parameters import Parameter


def parameters_in(kind: type) -> tuple[Parameter, ...]:
    """Fields made by `param` in the body of a class and of those that it is made of, in order."""
    found: dict[str, Parameter] = {}
    for part in reversed(kind.__mro__):
        for name, item in vars(part).items():
            if isinstance(item, dataclasses.Field) and "parameter" in item.metadata:
                found[name] = Parameter(name, **item.metadata["parameter"])
    return tuple(found.values())


def named(names: Iterable[str], values: np.ndarray) -> SimpleNamespace:
    """Values (lanes, parameters) by name, each (lanes, 1)."""
    return SimpleNamespace(**{n: values[:, i, None] for i, n in enumerate(names)})


class Missing(Effect):
    """Something that a `Motion` may lack: a subclass has numbers made by `param`, and one or more
    of `force`, `damping` and `friction` of (p, s), as the model has them.

    The identifier is the name of the class (`LoadFriction`: load_friction), the title the first
    sentence of its docstring, what it is the rest, unless they are given. `check` says how it is
    checked on the machine, `removes` what takes it away, `coordinate` where it shows.
    """

    coordinate = "speed"

    def __init_subclass__(cls) -> None:
        for parameter in parameters_in(cls):
            cls.__annotations__.setdefault(parameter.name, float)
        dataclasses.dataclass(frozen=True)(cls)
        words = re.sub(r"\s+", " ", cls.__doc__ or "").strip()
        title, _, rest = words.partition(". ")
        cls.identifier = vars(cls).get("identifier") or _snake(cls.__name__)
        cls.title = vars(cls).get("title") or title.rstrip(".")
        cls.what = vars(cls).get("what") or rest or words


def _snake(name: str) -> str:
    return re.sub(r"(?<=[a-z0-9])(?=[A-Z])", "_", name).lower()
