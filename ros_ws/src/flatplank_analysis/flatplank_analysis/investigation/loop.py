# SPDX-License-Identifier: Apache-2.0
"""Diagnose, choose, measure, repeat: until the answer is decided, nothing is left to learn, or the
budget is spent.

A batch is in the log before it is measured. So a new start with the same log resumes, and comes to
the same verdict.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable, Collection, Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any, Protocol

import numpy as np

from flatplank_analysis.contact_patch.session import Session
from flatplank_analysis.discovery.verdict import Diagnosis
from flatplank_analysis.investigation.decoys import Decoys, decoys_of
from flatplank_analysis.investigation.evidence import Evidence, e_value_words, hypothesis_of, log_e
from flatplank_analysis.investigation.inquiry import questions
from flatplank_analysis.investigation.planner import Choice, Price, choose
from flatplank_analysis.investigation.settings import (
    TWICE,
    Candidate,
    Setting,
    candidates,
    settings_of,
)
from flatplank_data.wording import quantity

BEGIN, BATCH, ANSWER, END = "begin", "batch", "answer", "end"


class Bench(Protocol):
    """Source of runs: the twin, the nodes of a ROS 2 graph, or simulated data."""

    def files(self) -> list[str]:
        """Runs that exist before the first batch."""

    def session(self, files: Collection[str]) -> Session:
        """A session of these runs."""

    def seed(self) -> Candidate:
        """The first runs of an investigation without data."""

    def price(self, candidate: Candidate) -> Price:
        """Cost of a candidate from the present state of the bench."""

    def plan(self, number: int, candidate: Candidate) -> str:
        """The text of a plan, from which `measure` always makes the same runs."""

    def measure(self, number: int, plan: str, left: float) -> BatchResult:
        """Measure a batch, or its missing runs; left: budget that remains after it [min]."""


@dataclass(frozen=True)
class BatchResult:
    """Result of a batch."""

    files: tuple[str, ...]
    """good runs"""
    handed_back: tuple[Setting, ...] = ()
    """rejected or skipped runs"""


class Log(Protocol):
    """Events, each stored before the loop continues."""

    events: list[dict[str, Any]]

    def write(self, event: Mapping[str, Any]) -> None:
        """Store one more event."""


@dataclass
class MemoryLog:
    """A log in memory."""

    events: list[dict[str, Any]] = field(default_factory=list)

    def write(self, event: Mapping[str, Any]) -> None:
        self.events.append(dict(event))


Choose = Callable[[Diagnosis, Evidence, Sequence[Setting], Sequence[Candidate],
                   Callable[[Candidate], Price], float], Choice]  # fmt: skip
Say = Callable[[str], None]
AtEnd = Callable[[Session, Diagnosis], "dict[str, Any] | None"]
"""called once with the last diagnosis, for a proposal; returns what the log keeps of it"""


def choose_by_questions(
    result: Diagnosis,
    evidence: Evidence,
    made: Sequence[Setting],
    possible: Sequence[Candidate],
    price: Callable[[Candidate], Price],
    left: float,
) -> Choice:
    """Choose the next runs by the questions that a diagnosis leaves open."""
    return choose(questions(result, evidence, made), possible, price, left)


class Loop:
    """One investigation; `run` continues to the end, `decide` and `measure` make one step."""

    def __init__(
        self,
        bench: Bench,
        log: Log,
        minutes: float,
        say: Say = lambda _: None,
        how: Choose = choose_by_questions,
        at_end: AtEnd = lambda _session, _result: None,
    ) -> None:
        self.bench, self.log, self.minutes, self.say, self.how = bench, log, minutes, say, how
        self.at_end = at_end
        self.diagnosed: tuple[tuple[str, ...], Session, Diagnosis] | None = None
        """files and their diagnosis"""

    def run(self) -> dict[str, Any]:
        """Run to the end and return the last event."""
        self.begin()
        if b := self.waiting:
            self.say(f"batch {b['number']} goes on: {b['what']}, {b['reason']}")
        while not self.ended:
            if self.waiting:
                self.measure()
            else:
                self.decide()
        return self.log.events[-1]

    def begin(self) -> None:
        """Write the budget [min] into the log; a larger one continues an ended investigation."""
        if not self.log.events:
            event = {"event": BEGIN, "minutes": self.minutes, "files": self.bench.files()}
            self.log.write(event)
        elif self.log.events[-1]["event"] == END and self.minutes > budget(self.log.events):
            self.log.write({"event": BEGIN, "minutes": self.minutes})

    # state from the log
    @property
    def waiting(self) -> dict[str, Any] | None:
        """The chosen batch that has no answer yet."""
        last = self.log.events[-1]
        return last if last["event"] == BATCH else None

    @property
    def ended(self) -> bool:
        return bool(self.log.events[-1]["event"] == END)

    @property
    def files(self) -> tuple[str, ...]:
        """Runs behind the last answer."""
        out = list(self.log.events[0]["files"])
        for e in self._of(ANSWER):
            out += e["files"]
        return tuple(out)

    @property
    def evidence(self) -> Evidence:
        """The product of the e-values of all batches so far."""
        return Evidence.of(self._of(ANSWER))

    @property
    def spent(self) -> float:
        """Minutes used by the batches so far."""
        return sum(b["minutes"] for b in batches_of(self.log.events))

    @property
    def left(self) -> float:
        return budget(self.log.events) - self.spent

    def _of(self, kind: str) -> list[dict[str, Any]]:
        return [e for e in self.log.events if e["event"] == kind]

    def _handed_back(self) -> Counter[Setting]:
        count: Counter[Setting] = Counter()
        for e in self._of(ANSWER):
            for s in e["handed_back"]:
                count[Setting(**s)] += TWICE if e.get("refused") else 1
        return count

    # steps
    def diagnosis(self) -> tuple[Session, Diagnosis]:
        """Diagnosis of the runs so far, cached."""
        files = self.files
        if self.diagnosed is None or self.diagnosed[0] != files:
            session = self.bench.session(files)
            self.diagnosed = files, session, session.diagnose()
        return self.diagnosed[1:]

    def decide(self) -> None:
        """Choose the next batch, or end; either is written into the log."""
        choice, verdict = self._choice()
        number = len(self._of(BATCH)) + 1
        if choice.candidate is None:
            proposal = self.at_end(*self.diagnosed[1:]) if self.diagnosed else None
            end = {"event": END, "why": choice.stop, "reason": choice.reason}
            self.log.write(end | {"verdict": verdict, "proposal": proposal})
            return
        c = choice.candidate
        self.say(f"batch {number}: {c.text}, {choice.reason}; {choice.price.minutes:.0f} min")
        batch = {
            "event": BATCH, "number": number, "what": c.text, "reason": choice.reason,
            "settings": [s.to_dict() for s in c.settings], "minutes": choice.price.minutes,
            "changes": choice.price.changes, "expected": round(choice.expected, 3),
        }  # fmt: skip
        self.log.write(batch | {"plan": self.bench.plan(number, c)})

    def _choice(self) -> tuple[Choice, dict[str, Any] | None]:
        if not self.files:
            return self._seed(), None
        session, result = self.diagnosis()
        made = settings_of(session.data.runs)
        possible = candidates(made, self._handed_back())
        if result.search is None:
            why = f"not decidable: {result.reason}"
            return Choice(None, why, stop="not decidable"), result.to_dict()
        choice = self.how(result, self.evidence, made, possible, self.bench.price, self.left)
        return choice, result.to_dict()

    def _seed(self) -> Choice:
        seed = self.bench.seed()
        price = self.bench.price(seed)
        if self._of(BATCH):
            return Choice(None, "no run of the first batch is good", stop="not decidable")
        if price.minutes > self.left:
            why = f"the first six runs take {price.minutes:.0f} minutes, {self.left:.0f} are there"
            return Choice(None, why, stop="budget spent")
        return Choice(seed, "nothing is known yet", price)

    def measure(self) -> None:
        """Measure the chosen batch, and diagnose."""
        batch, before = self.waiting, self.files
        assert batch is not None
        hypothesis = None
        if before:
            _, result = self.diagnosis()
            hypothesis = hypothesis_of(result.search) if result.search else None
        made = self.bench.measure(batch["number"], batch["plan"], self.left)
        files = (*before, *made.files)
        session = self.bench.session(files) if made.files else None
        log = 0.0
        if hypothesis is not None and session is not None:
            log = log_e(hypothesis, session.data, rows_of(session, made.files))
        event = {
            "event": ANSWER, "number": batch["number"], "files": list(made.files),
            "handed_back": [s.to_dict() for s in made.handed_back],
            "bet": list(hypothesis.names) if hypothesis else [], "log_e": round(log, 6),
        }  # fmt: skip
        self.log.write(event | self._answer(files, session))
        e = self.evidence
        so_far = f", {e_value_words(e.log)}" if e.batches else ""
        answer, left = self.log.events[-1]["answer"], max(self.left, 0.0)
        decoys = decoy_words(self._of(ANSWER))
        self.say(f"batch {batch['number']}: {answer}{so_far}; {decoys}; {left:.0f} min left")

    def refuse(self) -> None:
        """Drop the chosen batch; its runs are not requested again."""
        batch = self.waiting
        assert batch is not None
        answer = "refused: not made, and not asked for again"
        event = {"event": ANSWER, "number": batch["number"], "files": [], "refused": True}
        event |= {"handed_back": batch["settings"], "bet": [], "log_e": 0.0}
        self.log.write(event | {"answer": answer, "effects": []})
        self.say(f"batch {batch['number']}: {answer}; {max(self.left, 0.0):.0f} min left")

    def _answer(self, files: tuple[str, ...], session: Session | None) -> dict[str, Any]:
        """Diagnosis of all runs so far, with the evidence of the new ones."""
        if session is None:
            return {"answer": "no good run: handed back", "effects": []}
        result = session.diagnose()
        self.diagnosed = files, session, result
        decoys = decoys_of(result.search) if result.search else Decoys()
        facts = result.to_dict()
        return {
            "answer": diagnosis_line(result), "verdict": facts["verdict"],
            "effects": facts["effects"], "error": facts["rmse_after"],
            "error_alone": facts["rmse_before"], "floor": facts["floor_rmse"],
            "decoys": decoys.to_dict(),
        }  # fmt: skip


def budget(events: Sequence[Mapping[str, Any]]) -> float:
    """The most recent budget [min]."""
    return [e["minutes"] for e in events if e["event"] == BEGIN][-1]


def batches_of(events: Sequence[Mapping[str, Any]]) -> list[dict[str, Any]]:
    """Batches with their answers; a refused one has no runs and used no time."""
    answers = {e["number"]: e for e in events if e["event"] == ANSWER}
    names = ("number", "what", "reason", "settings", "minutes", "expected")
    out = []
    for batch in (e for e in events if e["event"] == BATCH):
        answer = answers.get(batch["number"], {})
        entry = {k: batch[k] for k in names} | {k: v for k, v in answer.items() if k != "event"}
        refused = {"settings": [], "minutes": 0.0} if answer.get("refused") else {}
        out.append(entry | refused)
    return out


def decoy_words(answers: Sequence[Mapping[str, Any]]) -> str:
    """Number of decoys that passed the tests so far; older logs have none."""
    looked_at, accepted = decoys_so_far(answers)
    return f"decoys accepted: {len(accepted)} of {looked_at}"


def decoys_so_far(answers: Sequence[Mapping[str, Any]]) -> tuple[int, list[str]]:
    """Number of decoys tried in all batches, and the names of the accepted ones."""
    known = [a["decoys"] for a in answers if a.get("decoys")]
    return sum(d["looked_at"] for d in known), [n for d in known for n in d["accepted"]]


def rows_of(session: Session, files: Collection[str]) -> np.ndarray:
    """Indices of the runs of a session that were read from these files."""
    wanted = {r.info.name for r in session.campaign.runs if r.info.file in set(files)}
    return np.array([i for i, n in enumerate(session.data.runs.names) if n in wanted], dtype=int)


def diagnosis_line(result: Diagnosis) -> str:
    """A diagnosis in one line."""
    if not result.found:
        return f"{result.verdict} ({result.reason})"
    parts = []
    for f in result.found:
        term = f.decision.term
        unit = term.effect.main_parameter().unit
        also = f" or {', '.join(r.name for r in f.reported)}" if f.reported else ""
        parts.append(f"{term.effect.identifier} {quantity(term.size, unit)}{also}")
    return f"{result.verdict}: {'; '.join(parts)}"
