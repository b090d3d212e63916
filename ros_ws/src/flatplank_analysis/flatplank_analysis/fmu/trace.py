# SPDX-License-Identifier: Apache-2.0
"""C statements from Python: a function of numpy is called with expressions in place of arrays.

Each operation of numpy becomes one C statement in double precision, in the same order, so that
both compute the same number but for the last digits of exp, sin and the others. Conditions on
numbers that are known (`np.any(c.PTX1)`) are decided here; a choice between expressions must be
`np.where`.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping
from typing import Any

import numpy as np
from numpy.lib.mixins import NDArrayOperatorsMixin

UFUNCS: Mapping[np.ufunc, str] = {
    np.add: "{} + {}", np.subtract: "{} - {}", np.multiply: "{} * {}", np.divide: "{} / {}",
    np.negative: "-{}", np.absolute: "fabs({})", np.sqrt: "sqrt({})", np.exp: "exp({})",
    np.expm1: "expm1({})", np.sin: "sin({})", np.cos: "cos({})", np.tan: "tan({})",
    np.arctan: "atan({})", np.arctan2: "atan2({}, {})", np.minimum: "lesser({}, {})",
    np.maximum: "greater({}, {})", np.less: "{} < {}", np.greater: "{} > {}",
    np.equal: "{} == {}",
}  # fmt: skip
"""operation of numpy -> the same in C; `lesser` and `greater` are in fmi3.c"""


class Trace:
    """The statements of one C function, each computed once."""

    def __init__(self) -> None:
        self._named: dict[str, str] = {}
        self._needs: dict[str, list[str]] = {}

    def variable(self, code: str) -> Expression:
        """An input of the function, as `in[0]`, read before anything is written."""
        return self.statement(code, ())

    def statement(self, pattern: str, operands: Iterable[Any]) -> Expression:
        """The expression for an operation; the same operation has the same one."""
        codes = [code_of(operand) for operand in operands]
        text = pattern.format(*codes)
        if text not in self._named:
            name = f"v{len(self._named)}"
            self._named[text] = name
            self._needs[name] = codes
        return Expression(self, self._named[text])

    def lines(self, results: Mapping[str, Any]) -> list[str]:
        """C lines that set each target, as `out[0]`, to its expression or number."""
        wanted, open_names = set(), [code_of(value) for value in results.values()]
        while open_names:
            name = open_names.pop()
            if name in self._needs and name not in wanted:
                wanted.add(name)
                open_names += self._needs[name]
        lines = [
            f"    const double {name} = {text};"
            for text, name in self._named.items()
            if name in wanted
        ]
        return lines + [f"    {target} = {code_of(value)};" for target, value in results.items()]


class Expression(NDArrayOperatorsMixin):
    """A number of the C function that is not known yet; numpy's functions take it as an array."""

    __hash__ = None  # type: ignore[assignment]

    def __init__(self, trace: Trace, code: str) -> None:
        self.trace = trace
        self.code = code

    def __array_ufunc__(self, ufunc: np.ufunc, method: str, *inputs: Any, **options: Any) -> Any:
        if ufunc not in UFUNCS or method != "__call__" or options:
            return NotImplemented
        known = NEUTRAL.get(ufunc, _never)(*inputs)
        return self.trace.statement(UFUNCS[ufunc], inputs) if known is None else known

    def __array_function__(
        self, function: Any, _types: Any, arguments: Any, options: Mapping[str, Any]
    ) -> Any:
        if function not in FUNCTIONS or options:
            return NotImplemented
        return FUNCTIONS[function](self.trace, *arguments)

    def __bool__(self) -> bool:
        raise TypeError("a choice between expressions must be np.where")


def code_of(value: Any) -> str:
    """C text of an expression, or of a number with all its digits."""
    if isinstance(value, Expression):
        return value.code
    number = float(value)
    return f"({number!r})" if number < 0.0 else repr(number)


def _is(value: Any, number: float) -> bool:
    return not isinstance(value, Expression) and float(value) == number


def _never(*_inputs: Any) -> None:
    return None


def _sum(a: Any, b: Any) -> Any:
    return b if _is(a, 0.0) else a if _is(b, 0.0) else None


def _difference(a: Any, b: Any) -> Any:
    return a if _is(b, 0.0) else None


def _product(a: Any, b: Any) -> Any:
    if _is(a, 0.0) or _is(b, 0.0):
        return 0.0
    return b if _is(a, 1.0) else a if _is(b, 1.0) else None


def _quotient(a: Any, b: Any) -> Any:
    if _is(a, 0.0):
        return 0.0
    return a if _is(b, 1.0) else None


NEUTRAL: Mapping[np.ufunc, Callable[..., Any]] = {
    np.add: _sum, np.subtract: _difference, np.multiply: _product, np.divide: _quotient,
}  # fmt: skip
"""operation -> its result where a 0 or a 1 makes it known"""


def _where(trace: Trace, condition: Any, yes: Any, no: Any) -> Any:
    if not isinstance(condition, Expression):
        return yes if condition else no
    return trace.statement("{} ? {} : {}", (condition, yes, no))


def _clip(_trace: Trace, value: Any, low: Any, high: Any) -> Any:
    return np.minimum(np.maximum(value, low), high)


def _any(_trace: Trace, _value: Any) -> bool:
    """An unknown number counts as one that is not zero."""
    return True


FUNCTIONS: Mapping[Any, Callable[..., Any]] = {np.where: _where, np.clip: _clip, np.any: _any}
"""function of numpy -> what it is with expressions"""
