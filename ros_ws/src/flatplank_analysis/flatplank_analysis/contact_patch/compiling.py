# SPDX-License-Identifier: Apache-2.0
"""Compiled inner loops, and powers and exponentials that a compiler can vectorise.

Numba notices changes only in the file of the cached function. These functions call each other
across files, so the cache folder carries a hash of the files. The plant has its own version
(`flatplank_sim.plant.compiling`), because it shares no code with the models that are fitted to it.

Powers and exponentials of the mathematics library are calls for one element each; here they are a
polynomial and the bits of the exponent. A test compares them with the library's, to 1e-13.
"""

from __future__ import annotations

import hashlib
import math
import os
from collections.abc import Callable
from importlib.util import cache_from_source
from pathlib import Path
from typing import Any

import numpy as np
from numba import njit, types
from numba.core import config
from numba.extending import intrinsic

FILES = ("kernel.py", "laws.py", "compiling.py")
"""files whose functions call each other"""
FAST = dict(nogil=True, error_model="numpy", fastmath={"contract", "arcp", "nsz"})
"""no checks for division by zero; the engine detects non-finite results"""
inner = njit(**FAST)
"""A function called by other compiled functions."""
inline = njit(forceinline=True, **FAST)
"""A function called for every element: a call inside a loop would prevent vectorisation."""


def folder() -> str:
    """Cache folder of numba for these sources, beside the byte code; numba's own choice where that
    is not writable."""
    digest = hashlib.sha256()
    for name in FILES:
        digest.update((Path(__file__).parent / name).read_bytes())
    root = Path(config.CACHE_DIR or Path(cache_from_source(__file__)).parent)
    made = root / f"contact_patch-{digest.hexdigest()[:16]}"
    try:
        made.mkdir(parents=True, exist_ok=True)
    except OSError:
        return config.CACHE_DIR
    return str(made) if os.access(made, os.W_OK) else config.CACHE_DIR


def entry(function: Callable[..., Any]) -> Any:
    """A function that Python calls: compiled once, cached on disk."""
    before = config.CACHE_DIR
    config.CACHE_DIR = folder()
    try:
        return njit(cache=True, **FAST)(function)
    finally:
        config.CACHE_DIR = before


@intrinsic
def _bits(_context, _number):
    """The 64 bits of a float, as an integer."""

    def generate(context, builder, _signature, args):
        return builder.bitcast(args[0], context.get_value_type(types.int64))

    return types.int64(types.float64), generate


@intrinsic
def _float(_context, _bits):
    """The float with these 64 bits."""

    def generate(context, builder, _signature, args):
        return builder.bitcast(args[0], context.get_value_type(types.float64))

    return types.float64(types.int64), generate


@intrinsic
def choose(_context, _condition, _first, _second):
    """The first number where the condition holds, else the second; both are computed.

    `a if c else b` is a branch, and several on one condition keep a loop from being vectorised.
    """

    def generate(_context, builder, _signature, args):
        return builder.select(*args)

    return types.float64(types.boolean, types.float64, types.float64), generate


@intrinsic
def pointer(_context, _address):
    """A pointer to an address, for `numba.carray`."""

    def generate(context, builder, _signature, args):
        return builder.inttoptr(args[0], context.get_value_type(types.voidptr))

    return types.voidptr(types.uintp), generate


EXPONENT = 52
"""position of the exponent in the bits"""
ONE = 1023 << EXPONENT
"""bits of 1.0"""
WHOLE = 1.5 * 2.0**EXPONENT
"""adding this rounds to an integer, which is then in the last bits of the sum"""
WHOLE_BITS = int(np.float64(WHOLE).view(np.int64))
ROOT_BITS = int(np.float64(math.sqrt(0.5)).view(np.int64))
LEAST = -1000.0
"""2 ** LEAST is taken as zero"""
LN2, TWO_OVER_LN2 = math.log(2.0), 2.0 / math.log(2.0)


@inline
def _log2(x):
    """Logarithm of a positive, normal number: atanh series of the mantissa in 0.71 .. 1.41."""
    bits = _bits(x)
    exponent = (bits - ROOT_BITS) >> EXPONENT
    mantissa = _float(bits - (exponent << EXPONENT))
    s = (mantissa - 1.0) / (mantissa + 1.0)
    z = s * s
    q = 1.0 / 15.0 + z * (1.0 / 17.0)
    q = 1.0 / 11.0 + z * (1.0 / 13.0 + z * q)
    q = 1.0 / 7.0 + z * (1.0 / 9.0 + z * q)
    q = 1.0 / 3.0 + z * (1.0 / 5.0 + z * q)
    return (_float(exponent + WHOLE_BITS) - WHOLE) + TWO_OVER_LN2 * s * (1.0 + z * q)


@inline
def _exp2(x):
    """2 ** x for x < 1000: Taylor series within half a power of two."""
    y = max(x, LEAST)
    rounded = y + WHOLE
    f = LN2 * (y - (rounded - WHOLE))
    p = 1.0 / 39916800.0 + f * (1.0 / 479001600.0)
    p = 1.0 / 362880.0 + f * (1.0 / 3628800.0 + f * p)
    p = 1.0 / 5040.0 + f * (1.0 / 40320.0 + f * p)
    p = 1.0 / 120.0 + f * (1.0 / 720.0 + f * p)
    p = 1.0 / 6.0 + f * (1.0 / 24.0 + f * p)
    p = 1.0 + f * (1.0 + f * (0.5 + f * p))
    return p * _float(((_bits(rounded) - WHOLE_BITS) << EXPONENT) + ONE)


@inline
def power(x, exponent):
    """x ** exponent for a positive, normal x."""
    return _exp2(exponent * _log2(x))


@inline
def exponential(x):
    """e ** x for x < 690."""
    return _exp2(x / LN2)
