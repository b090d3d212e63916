# SPDX-License-Identifier: Apache-2.0
"""Writes the page docs/reference/discovery-blind.md from a journal."""

from __future__ import annotations

import math
from collections import Counter
from collections.abc import Mapping, Sequence
from typing import Any

from flatplank_validation.blind import tables
from flatplank_validation.blind.points import share
from flatplank_validation.blind.rival_scores import rival_scores
from flatplank_validation.evaluation.paired import reliability
from flatplank_validation.evaluation.version import of_which_search

WORLDS = {
    "plant": "the bristle plant of the simulated bench, without bus and hub",
    "second": "a tire of cells that are carried through the patch, with a machine of its own, "
    "several of whose faults have the form of the library's",
    "forms": "the same cells on a machine whose faults have other forms: clearances with a Hertz "
    "contact, an oil film and friction, wear and crosstalk that saturate, drifts that fade, creep "
    "with two times, load that is let go with hysteresis; written without a look at the library",
    "circle": "the tire of `second` whose grip is shared by both directions, for combined slip",
    "third": "threads of rubber between belt and road, not alike along and across, on a carcass "
    "with damping, on a bench of its own",
}


def page(entries: Sequence[Mapping[str, Any]], header: Mapping[str, Any]) -> str:
    """The whole page in Markdown.

    header: command, seed, whole (campaigns of the list), rivals (entries of the rivals), beside
    (text of a paired comparison, or empty).
    """
    points = tables.scored(entries)
    not_asked = sorted(
        {f"{'+'.join(e['case']['hidden'])} ({e['case']['world']})" for e in _invisible(entries)}
    )
    made = Counter(f"{e['commit']} (search {e['code']})" for e in entries)
    parts = [
        "# Blind test of the discovery",
        f"Written by `{header['command']}` from {len(points)} campaigns"
        f"{_part(len(entries), header['whole'])}. Nothing on this page is typed by hand; the "
        "journal that it is written from is [beside it](discovery-blind.jsonl.gz).",
        f"Seed {header['seed']}; commit {', '.join(f'{c}: {n}' for c, n in made.items())}; "
        f"worlds: {', '.join(sorted({p['world'] for p in points}))}.",
        of_which_search(e["commit"] for e in entries),
        _what({p["world"] for p in points}),
        "## Scores",
        tables.scores(points),
        tables.beside(points),
        "## What was missed, and how",
        _MISSED,
        tables.ways(points),
        tables.missed(points),
        "## Sizes and held-out error",
        _SIZES,
        tables.sizes(points),
        *_stated(entries),
        "## Power",
        _POWER,
        tables.power(points),
        "## Confusion matrix",
        "Rows: what was hidden. Columns: what was named first (in brackets a verdict, when "
        "nothing was named), with counts.",
        tables.matrix(points),
    ]
    if not_asked:
        parts.append(
            "Not visible in the runs of its design, by the generator's own computation, or only "
            f"beyond its range, and so not asked: {', '.join(not_asked)}."
        )
    if header.get("beside"):
        parts += ["## Beside the earlier search", _BESIDE, header["beside"]]
    if header["rivals"]:
        parts += ["## Beside what one would do today", rival_scores(header["rivals"])]
    return "\n\n".join(parts) + "\n"


def _invisible(entries: Sequence[Mapping[str, Any]]) -> list[Mapping[str, Any]]:
    """Campaigns that were not scored at a multiple of the detectable size."""
    return [e for e in entries if e["diagnosis"] is None and e["case"]["rung"] == "x"]


def _stated(entries: Sequence[Mapping[str, Any]]) -> list[str]:
    """How true the stated probabilities are, where some are stated."""
    own = [e for e in entries if e["diagnosis"] and e["diagnosis"].get("posterior")]
    return ["## Stated probabilities", _STATED, reliability(own)] if own else []


def _part(done: int, whole: int) -> str:
    if done >= whole:
        return ""
    return (
        f" (**{done} of the {whole} of the list were looked at so far**: read the intervals in "
        "brackets; the command goes on where it stopped)"
    )


def _what(worlds: set[str]) -> str:
    told = "\n".join(f"- `{w}`: {text}." for w, text in WORLDS.items() if w in worlds)
    return f"{_WORLDS}\n\n{told}\n\n{_RULES}"


_WORLDS = """Answers are kept apart; what diagnoses sees the tables of the runs only. The
campaigns are made in worlds that share no code with the models:"""

_RULES = f"""**Strict** is what counts: a hidden effect is found when it is named by its own
name, or stands in the class that the program itself gave (four names at most) under the verdict
`found group`, and nothing else is named. **Lenient** also counts a relative that the answer's
own list holds; it is what earlier pages showed. An extra `tire_law` is not counted as a false
effect: it says that the force law is of another form, not that the machine has a fault. What the
tire of a world really has (`circle`: combined slip; `third`: that and rolling resistance) is
neither right nor false, by name or in a group.

The *detectable size* is computed by the generator from its own noise and scatter (80 % power at
a family-wise level of 5 % over 100 columns, a perfect fit of its own tire and any symmetric
force law allowed). No least size is put in: effects are hidden at 1, 2 and 4 times it, and at
1.5 and 3 times the size that is of no consequence where that is larger. Below {tables.CLEAR:g}
times the latter nobody is asked to name an effect, and silence is no mistake. Of a pair each
has three times the larger of the two. Forces outside the library have 1, 2 and 4 times the size
at which a force of their own form could be found, and 1.5 and 3 times the one that is of no
consequence: 0.3 floors in the mean over all runs, or one floor in the mean over 0.2 m of the runs
with one sign of the slip, and no less than the form of the base is known to miss; the floor by
the generator's own noise and scatter.

Noise and scatter of the tire from run to run (0 to 3 %) are drawn for every campaign: white
with slow parts, trends, 1 N and 30 N, and one like a measured signal (1/f, hum with harmonics
that the sampling folds down, warming up, steps of the converter, outliers, a channel that
stands still). The list belongs to the seed, too. Intervals in brackets are Wilson's, 95 %. A
size in another unit than the hidden one counts as not covered."""

_MISSED = """Of the rows with a goal, every campaign that was not right. *Error / floor*: error of
the base without any effect over the scatter between repeats; at 1 and below the whole effect is
less than what repeats differ by, and only its regularity can tell it. *Size / detectable*: the
detectable size of the generator, which fits its own tire with the few parameters that this tire
has. *Size / detectable by the search*: the smallest size that `diagnose --json` states for these
runs (80 % power with its own base, noise, scatter and model errors). Below 1 the search states
itself that it cannot find the effect: its base must fit any tire, and so imitates more of it.
*none*: it states that these runs show no size within the effect's range.
*Plain size / no consequence*: the size in the plain law (below) over the size that is of no
consequence. A fault of another form whose plain size is below 1 looks like one that does not
matter; a diagnosis, which reads it by the plain law, is silent about it. It counts as missed."""

_SIZES = """On the machine with other forms the hidden number is a coefficient of another law than
that of the effect: the crosstalk of a small force, where the crosstalk saturates; the final value
of a drift that fades. An interval states the size of the effect's own, plain law. *Size in the
plain law*: the size of the machine `second`, whose laws are plain, whose change of the forces is
closest to that of the hidden fault, beside all that a fit of the tire takes. The generator
computes it; on the other machines it is the hidden number. Both are counted, with nothing left
out."""

_STATED = """Every effect of the posterior, and `nothing`, is a claim with a probability; of those
that are stated with 0.9 nine in ten should be true. Effects too small to be seen count as hidden
from the size of consequence on."""

_BESIDE = """The search before decided each effect by itself, by steps; its answers are those of
its published journal. McNemar's exact test of the campaigns on which only one of both is right."""

_POWER = """Strictly right over the ratio of the hidden size to the detectable size. The third
column says how many detectable sizes the size of no consequence is: where it is large the
search could see far smaller effects than it names. *80 % from*: the ratio from which on at
least 80 % are right; the honest detectable size of this search is so many times the
generator's."""


def summary(entries: Sequence[Mapping[str, Any]]) -> dict[str, Any]:
    """The scores as data, for programs."""
    out: dict[str, Any] = {}
    for key, own in tables.rows_of(tables.scored(entries)).items():
        s = share(p["right"] for p in own)
        low, high = s.interval()
        out[key] = {
            "hits": s.hits,
            "trials": s.trials,
            "interval": None if math.isnan(low) else [round(low, 4), round(high, 4)],
            "lenient": sum(p["kin_right"] for p in own),
        }
    return out
