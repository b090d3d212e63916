# SPDX-License-Identifier: Apache-2.0
"""A repair: a campaign before it against one after it, by the effects that it should remove."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from flatplank_analysis.contact_patch.session import Session
from flatplank_analysis.discovery import determined
from flatplank_analysis.discovery.effect import Effect
from flatplank_analysis.discovery.modelfile import ModelFile
from flatplank_analysis.discovery.steps import Step
from flatplank_analysis.words import BASE
from flatplank_data.errors import FlatplankError
from flatplank_data.wording import quantity, six_digits, sized, table


@dataclass(frozen=True)
class Side:
    """A campaign, fitted without and with the effects."""

    session: Session
    bare: Step
    full: Step
    sizes: Mapping[str, tuple[float, tuple[float, float]]]
    """effect -> size and its 90 % interval"""

    @classmethod
    def of(cls, session: Session, names: Sequence[str]) -> Side:
        """Fit the tire alone, and with the effects added in this order."""
        model, step, sizes = ModelFile(), session.fit(None), {}
        bare = step
        for name in names:
            model, step, numbers = session.add(model, name, before=step)
            low, high = numbers["interval"]
            sizes[name] = numbers["size"], (low, high)
        return cls(session, bare, step, sizes)

    def errors(self) -> dict[str, Any]:
        """Error of Fx without and with the effects, and its floor [N]."""
        rmse = self.session.rmse
        floor = self.full.state.floors[0].floor
        each = {"without": rmse(self.bare), "with": rmse(self.full), "floor": floor}
        return {name: six_digits(value) for name, value in each.items()}

    def by_condition(self) -> dict[str, tuple[float, float, float]]:
        """Condition -> error without, error with the effects, floor [N]."""
        names = self.bare.state.runs.condition_names
        bare, full = (s.state.floors[0] for s in (self.bare, self.full))
        rows = zip(names, bare.rmse_condition, full.rmse_condition, full.by_condition, strict=True)
        return {name: (float(a), float(b), float(c)) for name, a, b, c in rows}


def numbers(before: Side, after: Side) -> dict[str, Any]:
    """What a repair changed, for programs. Raises FlatplankError without a common condition."""
    old, new = before.by_condition(), after.by_condition()
    common = [name for name in old if name in new]
    if not common:
        raise FlatplankError(
            "the campaigns have no condition in common", after.session.campaign.path,
            "measure the same conditions before and after the repair",
        )  # fmt: skip
    return {
        "effects": [_effect(before, after, name) for name in before.sizes],
        "errors": {"before": before.errors(), "after": after.errors()},
        "conditions": [
            {
                "condition": name,
                "before": _rounded(("without", "with", "floor"), old[name]),
                "after": _rounded(("without", "with", "floor"), new[name]),
            }
            for name in common
        ],
        "tire": list(_changed(before.full, after.full)),
    }


def _rounded(names: Sequence[str], values: Sequence[float]) -> dict[str, Any]:
    return {name: six_digits(value) for name, value in zip(names, values, strict=True)}


def _effect(before: Side, after: Side, name: str) -> dict[str, Any]:
    effect = before.session.effects[name]
    sides = {"before": before.sizes[name], "after": after.sizes[name]}
    told = {k: {"size": size, "interval": list(ends)} for k, (size, ends) in sides.items()}
    unit = effect.main_parameter().unit
    return {"name": name, "unit": unit, **told, "change": change(effect, **sides)}


def change(
    effect: type[Effect],
    before: tuple[float, tuple[float, float]],
    after: tuple[float, tuple[float, float]],
) -> str:
    """What a repair did to an effect, in words; a size with its 90 % interval on each side."""
    p = effect.main_parameter()
    (old, (_, _)), (new, (low, high)) = before, after
    most = max(abs(low), abs(high))
    if most < p.matters:
        return f"gone: below the {quantity(p.matters, p.unit)} that matters"
    if low <= 0.0 <= high:
        return f"no longer seen; up to {quantity(most, p.unit)} of it would not be"
    apart = high < before[1][0] or low > before[1][1]
    if not apart:
        return "as before"
    if abs(new) < abs(old):
        return f"less by {100.0 * (1.0 - abs(new / old)):.0f} %"
    return f"more by {100.0 * (abs(new / old) - 1.0):.0f} %"


def _changed(before: Step, after: Step) -> Iterator[dict[str, Any]]:
    """Numbers of the tire whose 90 % intervals before and after have nothing in common."""
    known = {n.name: n for n in determined.numbers_of(before.state) if not n.owner}
    for new in determined.numbers_of(after.state):
        old = known.get(new.name)
        if new.owner or old is None:
            continue
        ends = (*old.interval, *new.interval)
        if np.isfinite(ends).all() and (ends[1] < ends[2] or ends[3] < ends[0]):
            yield {
                "parameter": new.name, "unit": new.unit,
                "before": six_digits(old.value), "after": six_digits(new.value),
            }  # fmt: skip


def text_of(data: Mapping[str, Any]) -> str:
    """The text that `flatplank repair` prints, from the result of `numbers`."""
    lines = []
    for e in data["effects"]:
        old, new = (sized(e[k]["size"], e[k]["interval"], e["unit"]) for k in ("before", "after"))
        lines += [f"{e['name']}: {e['change']}", f"  before {old}", f"  after  {new}"]
    old, new = data["errors"]["before"], data["errors"]["after"]
    lines += [
        f"error of Fx of the tire alone: {old['without']:.1f} N before, {new['without']:.1f} N "
        f"after (floors {old['floor']:.1f} and {new['floor']:.1f} N)",
        f"what the effect said: {old['with']:.1f} N without the fault",
        "",
    ]
    rows = [("condition", "before [N]", "with the effect [N]", "after [N]", "floor after [N]")]
    rows += [
        (
            c["condition"], f"{c['before']['without']:.1f}", f"{c['before']['with']:.1f}",
            f"{c['after']['without']:.1f}", f"{c['after']['floor']:.1f}",
        )
        for c in data["conditions"]
    ]  # fmt: skip
    lines += [table(rows), ""]
    tire = [
        f"{BASE[t['parameter']].title} {quantity(t['before'], t['unit'])} -> "
        f"{quantity(t['after'], t['unit'])}"
        for t in data["tire"]
    ]
    changed = "; ".join(tire) or "no number left its interval"
    return "\n".join([*lines, f"tire, before and after: {changed}"])
