# SPDX-License-Identifier: Apache-2.0
"""Compiled inner loops, powers and exponentials that a compiler can compute for several at once.

Numba notices a change in the file of the cached function only; these call each other across files,
so the cache folder carries a hash of the files. The plant does the same on its own
(`flatplank_sim.plant.compiling`): it shares no code with what is fitted to it.

Powers and exponentials of the mathematics library are calls, one element each; these are a
polynomial and the bits of the exponent. A test holds them to the library's, to 1e-13.
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

FILES = ("kernel.py", "compiling.py")
"""whose functions call each other"""
FAST = dict(nogil=True, error_model="numpy", fastmath={"contract", "arcp", "nsz"})
"""no checks for division by zero; what is not finite is found by the engine"""
inner = njit(**FAST)
"""A function that other compiled ones call."""
inline = njit(forceinline=True, **FAST)
"""One that is called for every element: a call inside a loop keeps it from being vectorised."""


def folder() -> str:
    """Where numba keeps its cache, or beside the byte code, in a folder of these sources; what
    numba says where that may not be written."""
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
    """One that Python calls: compiled once, kept on disk."""
    before = config.CACHE_DIR
    config.CACHE_DIR = folder()
    try:
        return njit(cache=True, **FAST)(function)
    finally:
        config.CACHE_DIR = before


@intrinsic
def _bits(_context, _number):
    """The 64 bits of a float as an integer."""

    def generate(context, builder, _signature, args):
        return builder.bitcast(args[0], context.get_value_type(types.int64))

    return types.int64(types.float64), generate


@intrinsic
def _float(_context, _bits):
    """The float that has these 64 bits."""

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
"""place of the exponent in the bits"""
ONE = 1023 << EXPONENT
"""bits of 1.0"""
WHOLE = 1.5 * 2.0**EXPONENT
"""a number is rounded to an integer by adding this; the last bits of the sum are the integer"""
WHOLE_BITS = int(np.float64(WHOLE).view(np.int64))
ROOT_BITS = int(np.float64(math.sqrt(0.5)).view(np.int64))
LEAST = -1000.0
"""powers of two below 2 ** LEAST are as good as nothing"""
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
