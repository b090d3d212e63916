# SPDX-License-Identifier: Apache-2.0
"""What a diagnosis says to people: named causes with their class ('A or B'), and what to do next.

Command, page, panel and notebooks show these; none of them words a class or a task by itself.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import asdict, dataclass
from typing import Any

from flatplank_analysis.discovery.fit import Term
from flatplank_analysis.discovery.sources import NONE, PARTLY
from flatplank_analysis.discovery.steps import AcceptedEffect
from flatplank_data.wording import one_of, plain, probability_words, quantity, six_digits, sized


@dataclass(frozen=True)
class Member:
    """An effect that may be the cause, with its size where it stands for the cause."""

    name: str
    title: str
    kind: str
    size: float | None
    unit: str
    what: str
    check: str
    shown_by: str
    removes: str

    @classmethod
    def of(cls, term: Term) -> Member:
        e = term.effect
        return cls(
            e.identifier, e.title, e.kind, six_digits(term.size), e.main_parameter().unit,
            e.what, e.check, e.shown_by, e.removes,
        )  # fmt: skip

    @property
    def sized(self) -> str:
        """The size in its display unit."""
        return quantity(self.size or 0.0, self.unit)


@dataclass(frozen=True)
class Cause:
    """A found effect with the members of its class, the likeliest first: one of them is it."""

    members: tuple[Member, ...]
    interval: tuple[float, float]
    """90 % interval of the size of the first member"""
    generic: bool = False
    """True for a free form of the tire's law: no fault of the machine"""

    @classmethod
    def of(cls, found: AcceptedEffect) -> Cause:
        terms = [found.decision.term, *(r.term for r in found.reported)]
        members = tuple(Member.of(t) for t in terms)
        return cls(members, found.decision.interval, terms[0].effect.generic)

    @property
    def name(self) -> str:
        """'A or B'."""
        return one_of([m.name for m in self.members])

    @property
    def title(self) -> str:
        return one_of([m.title for m in self.members])

    @property
    def sized(self) -> str:
        """The size of the first member with its interval; those of the others behind it."""
        first, *others = self.members
        own = sized(first.size or 0.0, self.interval, first.unit)
        return one_of([own, *(f"{m.sized} as {m.name}" for m in others)])


@dataclass(frozen=True)
class Task:
    """One line of the list of what to do; `each` has (name, text) of every member of a class."""

    do: str
    each: tuple[tuple[str, str], ...] = ()

    def lines(self) -> Iterator[str]:
        yield self.do + (":" if self.each else "")
        yield from (f"  {name}: {text}" for name, text in self.each)


def tasks(
    verdict: str, causes: Sequence[Cause], plan: Mapping[str, Any], folder: str
) -> list[Task]:
    """What to do next, the first thing first; `plan`: the next run, `folder`: of the campaign, ""
    for runs that are none."""
    named = [c for c in causes if not c.generic]
    return [
        *_runs(plan),
        *_checks(named, bool(plan.get("settings"))),
        *_remedies(named, folder),
        *_of_the_rest(verdict, folder),
    ]


def _runs(plan: Mapping[str, Any]) -> Iterator[Task]:
    if plan.get("settings"):
        apart = " from ".join(", ".join(names) for names in plan["separates"])
        yield Task(f"measure {plan['what']}: tells {apart}; then diagnose again")
    elif plan.get("shows"):
        yield Task(f"measure {plan['what']}: shows {' and '.join(plan['shows'])}")


def _checks(named: Sequence[Cause], planned: bool) -> Iterator[Task]:
    """Checks on the machine; a class without a planned run is decided by them alone."""
    for cause in named:
        checks = tuple((m.name, m.check) for m in cause.members)
        if len(checks) == 1:
            yield Task("check on the machine", checks)
        elif planned:
            yield Task("or check on the machine which it is", checks)
        else:
            yield Task("check on the machine which it is, none of the planned runs tells", checks)


def _remedies(named: Sequence[Cause], folder: str) -> Iterator[Task]:
    removes = tuple((m.name, m.removes) for c in named for m in c.members if m.removes)
    if removes:
        names = " ".join(c.members[0].name for c in named)
        verb = f": flatplank repair {folder} AFTER {names}" if folder else ""
        yield Task(f"remove the cause, and measure the same again{verb}", removes)


def _of_the_rest(verdict: str, folder: str) -> Iterator[Task]:
    if verdict in (NONE, PARTLY) and folder:
        yield Task(f"describe what is left as an effect file: flatplank propose {folder}")


def task_dict(task: Task) -> dict[str, Any]:
    """A task for programs."""
    return {"do": task.do, "each": [{"name": n, "text": t} for n, t in task.each]}


def cause_dict(found: AcceptedEffect) -> dict[str, Any]:
    """One found effect for programs; `class`: the other names that may be it."""
    d, cause = found.decision, Cause.of(found)
    first, *others = cause.members
    return {
        "name": first.name,
        "title": first.title,
        "kind": first.kind,
        "size": first.size,
        "unit": first.unit,
        "interval": [six_digits(d.interval[0]), six_digits(d.interval[1])],
        "class": [m.name for m in others],
        "weakly": list(found.excluded_names),
        "members": [asdict(m) | {"sized": m.sized} for m in cause.members],
        "text": {
            "name": cause.name,
            "title": cause.title,
            "size": cause.sized,
            "probability": probability_words(d.probability),
        },
        "held_out_gain": six_digits(d.held_out_gain),
        "probability": six_digits(d.probability),
        "parameters": {k: six_digits(v) for k, v in d.term.named().items()},
    }


def stored(effect: Mapping[str, Any]) -> dict[str, Any]:
    """A found effect of a stored diagnosis; earlier versions stored less of its class."""
    if "probability" in effect.get("text", {}):
        return dict(effect)
    text = {
        "name": one_of([effect["name"], *effect["class"]]),
        "title": effect["title"],
        "size": sized(effect["size"], effect["interval"], effect["unit"]),
        "probability": f"p = {plain(effect['p_value'], 2)}" if "p_value" in effect else "",
    }
    return {**effect, "members": effect.get("members") or effect.get("advice") or [], "text": text}
