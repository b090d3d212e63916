# SPDX-License-Identifier: Apache-2.0
"""Proposals that earlier versions wrote as Python: read as data, never executed.

A file is a proposal only when each of its statements is one that those versions wrote: the same
imports, class variables that are literals, and a hook method that is that of one sentence of the
grammar, number by number. Anything else is an effect file like others, which needs consent.
"""

from __future__ import annotations

import ast
import itertools
import re
from collections.abc import Mapping
from typing import Any

from flatplank_analysis.effects.grammar import hooks, modulators
from flatplank_analysis.effects.grammar.file import EVENT, checked_name, text_of
from flatplank_analysis.effects.grammar.file import sentence_of as sentence_of_file
from flatplank_analysis.effects.grammar.hooks import NONE
from flatplank_analysis.effects.grammar.sentence import Sentence, Site, SiteCoordinate, effect_of
from flatplank_analysis.effects.grammar.shapes import shapes
from flatplank_analysis.effects.grammar.shapes.base import PLACE, Shape, Span
from flatplank_data.errors import FlatplankError

LINES = {
    "fx": "signal.fx = signal.fx + change",
    "fy": "signal.fy = signal.fy + change",
    "gain": "signal.fx = signal.fx + change * signal.true_fx",
    "slip": "motion.rolled = motion.rolled * (1.0 + change)",
    "travel": "motion.travel = motion.travel + np.diff(change, axis=-1, prepend=change[..., :1])",
    "friction": "tire.friction = tire.friction * (1.0 + change)",
    "stiffness": "tire.x.stiff = tire.x.stiff * (1.0 + change.mean(axis=-1))",
    "carcass": "tire.x.carcass = tire.x.carcass * (1.0 + change.mean(axis=-1))",
    "load": "tire.load = tire.load + change",
    "delay": "signal.fx = shifted(signal.fx, data.runs.time, change)",
}
"""hook -> last line of the method"""
_AFTER = "(data.since_step > 0.0)"
FACTORS = {
    "": "",
    "driving": f"(data.kappa[:, None] > 0.0) * {_AFTER}",
    "braking": f"(data.kappa[:, None] < 0.0) * {_AFTER}",
    "slipping": f"(data.kappa[:, None] != 0.0) * {_AFTER}",
    "sign of slip": f"np.sign(data.kappa[:, None]) * {_AFTER}",
    "slip": f"data.kappa[:, None] / 0.05 * {_AFTER}",
    "size of slip": f"np.abs(data.kappa[:, None]) / 0.05 * {_AFTER}",
    "little slip": f"np.exp(-np.abs(data.kappa[:, None]) * {_AFTER} / 0.02)",
    "load": "data.load / 4000.0",
    "speed": "data.runs.facts['speed'][:, None] / 0.03",
}
"""modulator -> its factor"""
_WAVE, _OTHER = "2.0 * np.pi * u / self.period", "2.0 * np.pi * u / self.second"
TERMS: Mapping[str, tuple[str, ...]] = {
    "constant": ("np.ones_like(u)",),
    "ramp": ("(u - {middle}) / {width}",),
    "power": ("(np.maximum(u - {low}, 0.0) / {width} + 1e-9) ** self.power",),
    "relaxation": ("(1.0 - np.exp(-np.maximum(u - {begin}, 0.0) / self.length))",),
    "step": ("(0.5 + 0.5 * np.tanh((u - self.at) / {edge}))",),
    "threshold": ("np.maximum(u - self.at, 0.0) / {width}",),
    "bump": ("np.sin(np.pi * np.clip((u - self.start) / self.length, 0.0, 1.0))",),
    "sign": ("np.tanh(u / {edge})",),
    "size": ("np.abs(u) / {width}",),
    "dead band": ("(u - np.clip(u, -self.band, self.band)) / {width}",),
    "saturation": ("np.tanh(u / self.scale)",),
    "lag": ("(follow(u, time, self.lag) - {middle}) / {width}",),
    "play": ("play(u, self.gap)",),
    **{f"harmonic {n}": (f"np.cos({n} * u)", f"np.sin({n} * u)") for n in range(1, 5)},
    "wave": ("np.cos(wave)", "np.sin(wave)"),
    "beat": ("np.cos(wave)", "np.sin(wave)", "np.cos(other)", "np.sin(other)"),
    "ringing": ("fading * np.cos(wave)", "fading * np.sin(wave)"),
}
"""shape -> its terms, with the names of the numbers of a range"""
PARTS: Mapping[str, tuple[str, ...]] = {
    "wave": (f"wave = {_WAVE}",),
    "beat": (f"wave = {_WAVE}", f"other = {_OTHER}"),
    "ringing": (
        f"wave = {_WAVE}", "fading = (u > 0.0) * np.exp(-np.maximum(u, 0.0) / self.fade)"
    ),
    "lag": ("time = data.runs.time",),
}  # fmt: skip
"""shape -> lines before its terms"""
NUMBER = re.compile(r"(?<![\w.])\d+(?:\.\d*)?(?:e[-+]?\d+)?")
ROUNDED = 1e-3
"""the range of a coordinate was written with four digits"""
TOGETHER = 2
"""terms on one line of the sum"""
IMPORTS = {"from dataclasses import dataclass", "import numpy as np"}
SOURCE = "flatplank_analysis.proposal.proposed"
HELPERS = {"Proposed", "Signal", "Motion", "Tire", "param", "follow", "play", "shifted"}
KINDS: Mapping[str, type] = {
    "identifier": str, "kind": str, "coordinate": str, "what": str, "check": str, "ranges": dict,
    "order": int, "interval": tuple,
}  # fmt: skip
"""class variable -> type of its literal"""
Fields = dict[str, dict[str, Any]]
"""parameter -> `null`, and the named arguments of its `param`"""


class NotFormerError(Exception):
    """An earlier version did not write this."""


def sentence_of(text: str | bytes) -> Sentence | None:
    """The sentence of a file; None when an earlier version did not write the file like this."""
    try:
        module = ast.parse(text)
        return _sentence(*_parts(_class_of(module)), ast.get_docstring(module) or "")
    except (NotFormerError, FlatplankError, SyntaxError, ValueError, RecursionError, TypeError):
        return None


def _require(held: bool) -> None:
    if not held:
        raise NotFormerError


def _class_of(module: ast.Module) -> ast.ClassDef:
    """The only class of a file that has nothing else but a docstring and known imports."""
    classes = [node for node in module.body if isinstance(node, ast.ClassDef)]
    for i, node in enumerate(module.body):
        docstring = i == 0 and isinstance(node, ast.Expr) and isinstance(node.value, ast.Constant)
        _require(docstring or node in classes or _is_known_import(node))
    _require(len(classes) == 1)
    (found,) = classes
    head = [ast.unparse(d) for d in found.decorator_list], [ast.unparse(b) for b in found.bases]
    _require(head == (["dataclass(frozen=True)"], ["Proposed"]) and not found.keywords)
    return found


def _is_known_import(node: ast.stmt) -> bool:
    if isinstance(node, ast.ImportFrom) and node.module == SOURCE and not node.level:
        return all(a.name in HELPERS and a.asname is None for a in node.names)
    return ast.unparse(node) in IMPORTS


def _parts(found: ast.ClassDef) -> tuple[dict[str, Any], Fields, list[str]]:
    """Class variables, parameters, and the lines of the method with its head."""
    facts: dict[str, Any] = {}
    fields: Fields = {}
    method: list[str] = []
    for node in found.body:
        match node:
            case ast.Assign(targets=[ast.Name(id=name)]) if name in KINDS:
                facts[name] = ast.literal_eval(node.value)
                _require(isinstance(facts[name], KINDS[name]))
            case ast.AnnAssign(
                target=ast.Name(id=name),
                annotation=ast.Name(id="float"),
                value=ast.Call(func=ast.Name(id="param"), args=[null], keywords=more),
            ):
                named = {str(k.arg): ast.literal_eval(k.value) for k in more}
                fields[name] = {"null": ast.literal_eval(null), **named}
            case ast.FunctionDef(decorator_list=[]):
                _require(not method)
                method = [ast.unparse(node.args), *map(ast.unparse, node.body)]
                method[0] = f"{node.name}({method[0]}) -> {ast.unparse(node.returns or node.args)}"
            case _:
                raise NotFormerError
    return facts, fields, method


def _sentence(facts: dict[str, Any], fields: Fields, method: list[str], doc: str) -> Sentence:
    ((name, (low, high)),) = (facts.get("ranges") or {"": (0.0, 1.0)}).items()
    _require(facts["coordinate"] == (name or "slip level"))
    known = [s for s in shapes().values() if s.name in TERMS]
    conditions = [m for m in modulators.MODULATORS if m.name in FACTORS]
    for hook, modulator, shape in itertools.product(hooks.HOOKS, conditions, known):
        units = [
            fields[n.name]["unit"] for n in shape.numbers if n.name in fields and n.unit == "u"
        ]
        span = Span(low, high, PLACE if name else NONE, (units or ["1"])[0], name == EVENT)
        site = Site(hook, SiteCoordinate(name, span), modulator)
        if not _alike(_method_of(site, shape), method):
            continue
        _require((facts.get("kind", "machine"), facts.get("order", 0)) == (hook.kind, hook.order))
        numbers = {n.name: float(fields[n.name]["null"]) for n in shape.numbers}
        said = Sentence(
            site, shape, numbers, interval=facts.get("interval"),
            evidence=(" ".join(doc.split()),), name=checked_name(facts["identifier"]),
            told_what=facts["what"], told_check=facts["check"],
        )  # fmt: skip
        _require_fields(said, fields)
        return sentence_of_file(text_of(said), "former")
    raise NotFormerError


def _require_fields(s: Sentence, fields: Fields) -> None:
    """The parameters are those of the sentence, with the ranges that the earlier version wrote."""
    own = effect_of(s).parameters()
    _require([p.name for p in own] == list(fields))
    for p in own:
        told = dict(fields[p.name])
        low, high = told.pop("bounds")
        told.pop("note", None)
        size = {"screen": p.screen, "matters": p.matters} if p.screen else {}
        _require(told == {"null": p.null, "unit": p.unit, **size})
        near = ROUNDED * (p.upper - p.lower)
        _require(abs(low - p.lower) <= near and abs(high - p.upper) <= near)


def _method_of(site: Site, shape: Shape) -> list[str]:
    """Head and lines of the method, as the earlier version wrote them."""
    hook, span, name = site.hook, site.coordinate.span, site.coordinate.name
    where = f"data.coordinate({name!r})" if name else "np.zeros(data.position.shape)"
    terms = [f"self.{n} * {t}" for n, t in zip(shape.sizes, TERMS[shape.name], strict=True)]
    known = {k: repr(getattr(span, k)) for k in ("low", "middle", "width", "begin", "edge")}
    lines = [f"data = {hook.method}.data", f"u = {where}", *PARTS.get(shape.name, ())]
    lines += [line.format(**known) for line in _summed(terms)]
    if site.modulator.name:
        lines.append(f"change = change * ({FACTORS[site.modulator.name]})")
    head = f"{hook.method}(self, {hook.method}: {hook.method.capitalize()}) -> None"
    return [head, *(ast.unparse(ast.parse(line)) for line in [*lines, LINES[hook.name]])]


def _summed(terms: list[str]) -> list[str]:
    """Lines that sum the terms as `change`; a sum of four was written on two lines."""
    first = [f"change = {' + '.join(terms[:TOGETHER])}"]
    return first + (
        [f"change = change + {' + '.join(terms[TOGETHER:])}"] if terms[TOGETHER:] else []
    )


def _alike(wanted: list[str], found: list[str]) -> bool:
    """True when the lines differ in nothing but the last digits of their numbers."""
    one, other = "\n".join(wanted), "\n".join(found)
    if NUMBER.sub("#", one) != NUMBER.sub("#", other):
        return False
    pairs = zip(NUMBER.findall(one), NUMBER.findall(other), strict=True)
    return all(abs(float(a) - float(b)) <= ROUNDED * abs(float(a)) for a, b in pairs)
