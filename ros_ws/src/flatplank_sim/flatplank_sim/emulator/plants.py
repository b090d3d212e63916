# SPDX-License-Identifier: Apache-2.0
"""The plant behind the emulated bus, by name: the project's own, or any factory
`module:function`."""

from __future__ import annotations

import importlib
from collections.abc import Sequence
from typing import Any

from flatplank_sim.emulator.bench import PlantLike


def make_plant(
    spec: str, rate_hz: int, seed: int, options: dict[str, str], axes: Sequence[str]
) -> PlantLike:
    """'simulated' or 'module:function'; a factory is called with rate_hz, seed and the options.

    axes: those that have a drive on the bus.
    """
    if spec == "simulated":
        return _simulated(rate_hz, seed, options, axes)
    module, _, name = spec.partition(":")
    try:
        factory: Any = getattr(importlib.import_module(module), name)
    except (ImportError, AttributeError) as error:
        raise ValueError(
            f"plant '{spec}': {error}; give 'simulated' or 'module:function'"
        ) from None
    return factory(rate_hz=rate_hz, seed=seed, **options)


def _simulated(rate_hz: int, seed: int, options: dict[str, str], axes: Sequence[str]) -> PlantLike:
    from flatplank_sim.plant import Plant, PlantConfig

    tire = options.get("tire", "toyo")
    config = PlantConfig.load(
        tire,
        preset=options.get("preset") or None,
        file=options.get("config") or None,
        overrides={"driven_axes": list(axes)},
    )
    return Plant(config, seed, rate_hz)
