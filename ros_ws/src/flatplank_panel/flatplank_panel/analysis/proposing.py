# SPDX-License-Identifier: Apache-2.0
"""Jobs for proposed effects outside the library: propose, add under a name, confirm by new runs.

A proposal is data and stays in this process until it is added.
"""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np

from flatplank_analysis.contact_patch.session import Session
from flatplank_analysis.discovery.modelfile import save_unchanged
from flatplank_analysis.effects import consent
from flatplank_analysis.effects.grammar.file import SUFFIX, renamed, text_of
from flatplank_analysis.effects.grammar.sentence import Sentence
from flatplank_analysis.effects.registry import proposal_of
from flatplank_analysis.proposal import confirm as confirming
from flatplank_analysis.proposal.picture import lines_of
from flatplank_analysis.proposal.propose import PROPOSED
from flatplank_analysis.proposal.propose import propose as search
from flatplank_data.errors import FlatplankError
from flatplank_data.files import write_atomic
from flatplank_data.progress import Progress
from flatplank_panel.analysis import fit_jobs

_SENTENCES: dict[str, Sentence] = {}
"""campaign folder -> its last proposal"""


def propose(progress: Progress, folder: str, model: str) -> dict[str, Any]:
    """Propose an effect file for the residual, with curve, band and form."""
    at = fit_jobs._opened(progress, folder, model)
    result = search(at.session, at.start, progress)
    _SENTENCES.pop(folder, None)
    answer = result.to_dict()
    if result.verdict != PROPOSED or result.sentence is None:
        return answer
    _SENTENCES[folder] = result.sentence
    lines = lines_of(result)
    drawn = {"over": lines.over, "unit": lines.unit, "form": _points(lines.u, lines.form)}
    if lines.free is not None and lines.half is not None:
        drawn["free"] = _points(lines.u, lines.free)
        drawn["low"] = _points(lines.u, lines.free - lines.half)
        drawn["high"] = _points(lines.u, lines.free + lines.half)
    return answer | {"drawn": drawn}


def _points(u: np.ndarray, values: np.ndarray) -> np.ndarray:
    return np.stack([u, values], axis=1)


def accept(progress: Progress, folder: str, model: str, name: str) -> dict[str, Any]:
    """Save the last proposal of a campaign under a name, and add it to the model."""
    _require_proposed(folder)
    at, text = (
        fit_jobs._opened(progress, folder, model),
        text_of(renamed(_SENTENCES[folder], name)),
    )
    file = _free(Path(folder) / f"{name}{SUFFIX}", text)
    write_atomic(file, text)
    try:
        files = [*at.session.files, str(file)]
        at = at._replace(session=Session.of(at.session.campaign, files))
        progress("refit of everything", 0.3)
        changed, step, numbers = at.session.add(at.model, name)
    except BaseException:
        file.unlink(missing_ok=True)
        raise
    return fit_jobs._kept(at, changed, step) | {"added": numbers, "text": text}


def rename(progress: Progress, folder: str, model: str, old: str, new: str) -> dict[str, Any]:
    """Rename the last proposal, or an effect of the model with a file."""
    at = fit_jobs._opened(progress, folder, model)
    entry = next((e for e in at.model.effects if e.name == old), None)
    if entry is None:
        _require_proposed(folder)
        _SENTENCES[folder] = renamed(_SENTENCES[folder], new)
        return {"text": text_of(_SENTENCES[folder])}
    before = Path(entry.file)
    if not entry.file:
        raise FlatplankError(f"'{old}' is of the library", at.path.name, "it keeps its name")
    sentence = proposal_of(before, consent.read(before))
    if sentence is None:
        raise FlatplankError("is no proposal", str(before), "rename the effect in its file")
    text = text_of(renamed(sentence, new))
    after = _free(before.with_name(f"{new}{SUFFIX}"), text)
    write_atomic(after, text)
    try:
        changed = save_unchanged(at.model.renamed(old, new, str(after)), at.path)
    except BaseException:
        after.unlink(missing_ok=True)
        raise
    before.unlink(missing_ok=True)
    return fit_jobs._model(at._replace(model=changed)) | {"text": text}


def _require_proposed(folder: str) -> None:
    if folder not in _SENTENCES:
        raise FlatplankError("nothing is proposed", folder, "propose it first")


def _free(file: Path, text: str) -> Path:
    """Check that a file does not exist, or has this text already."""
    if file.exists() and file.read_text(encoding="utf-8") != text:
        raise FlatplankError("is there already", str(file), "choose another name")
    return file


def confirm(progress: Progress, folder: str, model: str, name: str, new: str) -> dict[str, Any]:
    """Test whether the runs of another folder agree with an effect of the model."""
    at = fit_jobs._opened(progress, folder, model)
    if name not in at.session.effects:
        raise FlatplankError(f"no effect '{name}' in the model", folder, "add it first")
    sets = confirming.new_sessions(at.session, [new])
    progress("fit of the first campaign", 0.3)
    fitted = confirming.fit_with_effect(at.session, at.model, name)
    return confirming.confirm(at.session, fitted, name, sets).to_dict()
