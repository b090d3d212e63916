# SPDX-License-Identifier: Apache-2.0
"""The words of the outputs: what each means, with symbol and unit; `flatplank explain` prints
them."""

from __future__ import annotations

from collections.abc import Iterable, Mapping

from flatplank_analysis.column_words import COLUMNS, SWEEPS, coefficient
from flatplank_analysis.word import Word
from flatplank_data.errors import FlatplankError
from flatplank_data.names import similar_names
from flatplank_data.wording import NO_UNIT, displayed

BASE: Mapping[str, Word] = {
    "stiff": Word("slip stiffness", "Slope of Fx over the slip at zero slip.", "N", "C_Fk"),
    "peak": Word("friction", "Largest Fx of the steady curve over the load.", "-", "mu"),
    "shape": Word(
        "shape of the law", "How sharply the steady curve bends from its slope to its peak.", "-"
    ),
    "fall": Word("fall beyond the peak", "Share of the peak that is lost at large slip.", "1"),
    "round": Word(
        "quadratic term", "1: the steady curve has no quadratic term; 0: that of a brush.", "-"
    ),
    "denom": Word(
        "definition of slip",
        "1: rubber leaves the contact with the wheel; 0: it leaves the contact with the plank.",
        "-",
    ),
    "carcass": Word(
        "carcass stiffness", "Stiffness of the carcass along the road.", "N/m", "C_cx"
    ),
    "half": Word("half contact length", "Half the length of the contact patch.", "m", "a"),
    "tread": Word("tread factor", "Factor of the tread's part of the relaxation (7.19).", "-"),
    "fixed_length": Word(
        "fixed relaxation",
        "Share of the carcass's relaxation length that does not fall with the slope of the law.",
        "1",
    ),
    "patch_order": Word(
        "memory of the patch",
        "How the force of the patch follows a step of the slip. 1: as in a row of bristles.",
        "-",
    ),
    "slip_offset": Word("slip offset", "Slip at which the tire rolls freely.", "1"),
    "fx_offset": Word("force offset", "Fx of the freely rolling tire.", "N"),
    "fx_zero": Word("zero of Fx", "Reading of the hub without a force.", "N"),
    "load_share": Word(
        "share of the load",
        "Share of the changes of the load within a run that the slip stiffness follows.",
        "1",
    ),
    "stiff_y": Word("cornering stiffness", "Slope of Fy over the side slip angle.", "N", "C_Fa"),
    "carcass_y": Word("lateral carcass stiffness", "Stiffness across the road.", "N/m", "C_cy"),
    "turn_y": Word(
        "transport of the side force",
        "1: rubber moves through the contact with the wheel; 0: Fy does not feel the slip.",
        "-",
    ),
    "angle_offset": Word(
        "zero of the steering", "Steering angle that reads zero, as far as a protractor.", "rad"
    ),
    "other_slip": Word("other slip", "Share of the slip of one direction in the other.", "1"),
    "turn_share": Word(
        "turn of the sliding force",
        "Share of the sliding force that turns towards the slip at once.",
        "1",
    ),
    "turn_rate": Word("rate of the turn", "How fast the rest turns with the slip.", "-"),
    "grip_y": Word("lateral friction", "Friction across over friction along the road.", "-"),
    "slip_turned": Word(
        "speed of the wheel at an angle",
        "-1: the wheel rolls with the plank speed; 0: with its component in the wheel plane.",
        "-",
    ),
    "stiff_load": Word("slip stiffness over load", "Linear change with the load.", "1"),
    "peak_load": Word("friction over load", "Linear change with the load.", "1"),
    "slip_load": Word("slip offset over load", "Linear change with the load.", "1"),
    "slip_bend": Word("slip offset over load", "Quadratic change with the load.", "1"),
    "peak_bend": Word("friction over load", "Quadratic change with the load.", "1"),
    "stiff_pressure": Word("slip stiffness over pressure", "Linear change.", "1"),
    "peak_pressure": Word("friction over pressure", "Linear change.", "1"),
    "slip_pressure": Word("slip offset over pressure", "Linear change.", "1"),
}
"""parameters of the base of the search, by their names in model files and outputs"""

COORDINATES: Mapping[str, Word] = {
    "plank position": Word("plank position", "Travel of the plank from the motion trigger.", "m"),
    "distance since the step": Word(
        "distance since the step", "Travel of the plank from the begin of the slip step.", "m"
    ),
    "slip travel": Word(
        "slip travel", "Way by which the wheel's circumference has left the plank.", "m"
    ),
    "slip level": Word("slip level", "Commanded slip of a run.", "1"),
    "wheel angle": Word("wheel angle", "Angle of the wheel, modulo a turn.", "rad"),
    "pinion angle": Word(
        "pinion angle", "Angle of the pinion that drives the plank, modulo a turn.", "rad"
    ),
    "time": Word("time", "Time from the begin of a run.", "s"),
    "load": Word("load", "Vertical load on the tire.", "N"),
    "run order": Word("run order", "Number of a run in the campaign; the first is run 0.", "-"),
}
"""coordinates over which effects and residuals show"""

OUTPUTS: Mapping[str, Word] = {
    "base": Word("base", "The tire model without effects."),
    "error": Word("error", "Root mean square of measurement minus model.", "N", "RMSE"),
    "floor": Word(
        "noise floor",
        "The error that repeats of a run show among themselves. No model that knows all physics "
        "has a larger one; a fit can lie a little below it, because its parameters follow noise.",
        "N",
    ),
    "floors": Word("floors", "The error as a multiple of the floor of its condition.", "-"),
    "beyond": Word("beyond", "The part of the error above the floor, in quadrature.", "N"),
    "chi2": Word(
        "chi-square",
        "Sum of squared residuals over the squares of their noise: what an effect takes of it "
        "is weighed against what noise would take.",
        "-",
        "χ²",
    ),
    "worst condition": Word(
        "worst condition", "The condition whose error is the largest multiple of its own floor."
    ),
    "residual": Word("residual", "Measurement minus model.", "N"),
    "of consequence": Word(
        "of consequence",
        "Something is missing in the model where it leaves as much as this. Less is within the "
        "floor or the known errors of the model.",
        "N",
    ),
    "held out": Word(
        "held-out error",
        "Error in conditions that were left out of the fit: it falls only for what is real.",
        "N",
    ),
    "waterfall": Word("waterfall", "The error after each effect that was added, one by one.", "N"),
    "collapse": Word(
        "collapse",
        "Picture of an effect over its coordinate; with the right one all runs lie on one curve.",
    ),
    "event": Word(
        "event",
        "Stretch of a coordinate in which some conditions keep a residual beyond the floor.",
    ),
    "next run": Word(
        "next run", "The run that separates names which these runs cannot tell apart."
    ),
    "doubt": Word("doubt", "A reason why a fitted number may be wrong, beside its interval."),
    "condition": Word("condition", "All runs with the same slip, angles, load and pressure."),
    "start": Word("start", "Wheel angle at the begin of a run: 1, 2, 3 for 0, 120, 240 deg."),
    "class": Word("class", "Effects that the runs cannot tell apart."),
    "verdict": Word(
        "verdict", "What a diagnosis says about the model; each is a word of its own."
    ),
    "to do": Word("to do", "What to measure, check and mend, the first thing first."),
    "note": Word("note", "What a diagnosis has seen beside its verdict."),
    "report": Word("report", "The page with the figures of a result."),
    "interval": Word("90 % interval", "Holds the true size in nine of ten campaigns."),
    "p": Word("p", "Chance that noise alone explains as much, all searched effects counted.", "-"),
    "matters": Word("size that matters", "Sizes below are of no consequence for the error."),
    "detectable": Word(
        "detectable size", "Size that would be named in four of five campaigns like this one."
    ),
    "found": Word("found", "Verdict: the named effect is missing in the model."),
    "found group": Word("found group", "Verdict: one of the named effects is missing."),
    "at floor": Word("at floor", "Verdict: nothing of consequence is missing."),
    "tire law only": Word(
        "tire law only", "Verdict: the tire's force law has another form; nothing else is missing."
    ),
    "partly": Word("partly", "Verdict: the named effect is missing, and something else, too."),
    "none of these": Word(
        "none of these", "Verdict: something is missing that no effect of the library explains."
    ),
    "not decidable": Word("not decidable", "Verdict: these runs do not suffice for an answer."),
    "proposed": Word(
        "proposed", "Verdict: a sentence explains what is left; new runs must confirm it."
    ),
    "nothing to propose": Word(
        "nothing to propose", "Verdict: nothing is left that a sentence explains."
    ),
    "P": Word(
        "probability of an effect",
        "Search by posterior: that the effect is there, at a size of consequence.",
        "-",
        "P",
    ),
    "bet": Word(
        "bet", "Prediction of new runs by an investigation, fixed before they are measured."
    ),
    "e-value": Word(
        "e-value",
        "Likelihood of the new runs by the bet over that by the tire alone, product of all "
        "batches. Above 20 in at most one of 20 investigations where nothing is missing.",
        "-",
        "e",
    ),
    "evidence": Word(
        "evidence", "The e-value of the new runs of a batch, and of all so far.", "-"
    ),
    "end": Word("end", "Why an investigation has ended."),
    "answer": Word("answer", "What the runs of a batch said."),
    "handed back": Word("handed back", "A run that was rejected, skipped or refused."),
    "notebook": Word("notebook", "Question, runs, answer and cost of every batch."),
    "decoys accepted": Word("decoys accepted", "Number of false alarms among the decoys so far."),
    "decoy": Word(
        "decoy", "An effect that is tried in wrong conditions; an accepted one is a false alarm."
    ),
    "twin": Word("twin", "The simulated bench in one process, without ROS."),
    "simulated plant": Word("simulated plant", "The machine and tire that the twin measures."),
    "r_e": Word("rolling radius", "Road per angle of the freely rolling wheel.", "mm", "r_e"),
    "kappa": Word("slip", "Driving above zero, braking below.", "%", "κ"),
    "sigma": Word("relaxation length", "Road over which the force follows a step.", "m", "σ"),
    "MDF4": Word("measurement data format", "Files of channels with units over time (ASAM)."),
    "FMU": Word(
        "Functional Mock-up Unit", "A model in one file that programs of simulation import (FMI)."
    ),
}
"""words of the verbs' outputs"""


ALL: Mapping[str, Word] = {**SWEEPS, **BASE, **COORDINATES, **COLUMNS, **OUTPUTS}


def known(name: str) -> Word | None:
    """The word of that name or symbol, or of that column with its unit in brackets."""
    plain = name.partition(" [")[0]
    symbols = {word.symbol: word for word in ALL.values() if word.symbol}
    return ALL.get(name) or ALL.get(plain) or symbols.get(plain) or coefficient(plain)


def explain(name: str, others: Iterable[str] = ()) -> Word:
    """The word of that name; FlatplankError names the nearest, of `others` too."""
    word = known(name)
    if word is None:
        near = ", ".join(similar_names(name, [*ALL, *others], 0.5, most=3))
        raise FlatplankError(
            f"'{name}' is no word of the glossary",
            remedy=f"the nearest: {near}" if near else "`flatplank explain` lists them",
        )
    return word


def line(name: str, word: Word) -> str:
    """The word in one line: name, title, symbol, unit, sentence."""
    shown = displayed(word.unit)[1]
    unit = "" if shown in NO_UNIT else f"in {shown}"
    inside = ", ".join(part for part in (word.symbol, unit) if part)
    title = "" if word.title == name else f" {word.title}"
    return f"{name}:{title}{f' ({inside})' * bool(inside)}{'.' * bool(title)} {word.sentence}"


def sentence(name: str) -> str:
    """A word of the glossary with its sentence."""
    return told(explain(name))


def told(word: Word) -> str:
    """Title and sentence of a word, as a hover text."""
    return ": ".join(filter(None, [word.title, word.sentence]))
