# SPDX-License-Identifier: Apache-2.0
"""Fast jobs without a fit: list campaigns, runs with verdicts and curves, unloaded turns."""

from __future__ import annotations

from collections import Counter
from collections.abc import Sequence
from functools import lru_cache
from pathlib import Path
from typing import Any

import numpy as np

from flatplank_control.calibration.parasitic import identify_turn, turn_of_bag
from flatplank_data.campaign import Campaign
from flatplank_data.errors import FlatplankError
from flatplank_data.folders import Stamp, campaign_folders, stamp_of, verdicts
from flatplank_data.progress import Progress, told
from flatplank_data.run_record import FILE_NAME
from flatplank_panel.analysis import repeats
from flatplank_panel.signals import CHANNELS, OVER

DEPTH = 3
"""levels below the data folder that are searched for campaigns"""
POINTS = 400
"""a curve is averaged over 1/POINTS of its length, and drawn with twice as many points"""
UNLOADED_TURN = "\nmeasurement: unloaded_turn\n"


def campaigns(_progress: Progress, root: str) -> list[dict[str, Any]]:
    """Folders below `root` that hold runs."""
    return [{"folder": folder, "runs": runs} for folder, runs in campaign_folders(root, DEPTH)]


@lru_cache(maxsize=4)
def _read(_folder: str, _stamp: Stamp) -> list[Campaign]:
    """Room for the campaign."""
    return []


def _campaign(progress: Progress, folder: str) -> Campaign:
    read = _read(folder, stamp_of(folder))
    if not read:
        read.append(Campaign.load(folder, progress=progress))
    return read[0]


def runs(progress: Progress, folder: str) -> dict[str, Any]:
    """One row per run, and the problems found."""
    campaign = _campaign(progress, folder)
    judged = verdicts(campaign)
    rows = [
        {
            "file": i.file, "tire": i.tire, "measurement": i.measurement,
            "condition": i.condition.label(), "kappa_percent": round(100.0 * i.kappa, 3),
            "fz": i.fz, "pressure": i.pressure, "alpha": i.alpha_deg, "gamma": i.gamma_deg,
            "start": i.start, "order": i.run_index, "status": i.status or "complete",
            "lost": i.cycles_lost, "notes": i.notes, "verdict": judged[i.file],
        }
        for i in (run.info for run in campaign.runs)
    ]  # fmt: skip
    problems = [str(p) for p in campaign.problems]
    return {"tire": campaign.tire, "rows": rows, "problems": problems}


def curves(
    progress: Progress,
    folder: str,
    files: Sequence[str],
    channel: str,
    over: str,
    beside: str = "",
) -> dict[str, Any]:
    """Measured curves of some runs, thinned; the scatter between repeats of a condition; and the
    verdicts, updated from the samples. With `beside`, another campaign: its curves in the same
    conditions, and how far they are away."""
    if channel not in CHANNELS or over not in OVER:
        raise FlatplankError(f"no curve of {channel} over {over}", folder, "choose from the lists")
    wanted = set(files)
    whole = _campaign(progress, folder)
    drawn = _curves(progress, whole.where(lambda i: i.file in wanted), channel, over)
    others = _others(progress, beside, drawn, channel, over) if beside else []
    return {
        "curves": drawn,
        "others": others,
        "scatter": repeats.scatter(drawn),
        "differences": repeats.differences(drawn, others),
        "verdicts": verdicts(whole),
        "problems": [str(p) for p in whole.problems],
    }


def _others(
    progress: Progress, folder: str, drawn: Sequence[dict[str, Any]], channel: str, over: str
) -> list[dict[str, Any]]:
    """Curves of another campaign, as many of each condition as are drawn."""
    left = Counter(curve["condition"] for curve in drawn)
    campaign = _campaign(progress, folder)
    wanted = set()
    for info in (run.info for run in campaign.runs):
        label = info.condition.label()
        if left[label] > 0:
            left[label] -= 1
            wanted.add(info.file)
    if not wanted:
        raise FlatplankError(
            "no run in a condition of the drawn runs", folder, "choose a campaign that shares some"
        )
    return _curves(progress, campaign.where(lambda i: i.file in wanted), channel, over)


def _curves(
    progress: Progress, campaign: Campaign, channel: str, over: str
) -> list[dict[str, Any]]:
    out = []
    for run in told(campaign.runs, progress):
        table = campaign.try_table(run, [channel, over, "plank_position"])
        if table is None or channel not in table or over not in table:
            continue
        x, y = table[over], table[channel]
        step = max(1, len(x) // (POINTS * 4))
        width = max(1, len(x) // POINTS)
        smooth = np.convolve(y, np.ones(width) / width, mode="same") if width > 1 else y
        inner = slice(width, len(x) - width, max(1, width // 2) if width > 2 else step)
        out.append(
            {
                "file": run.info.file,
                "condition": run.info.condition.label(),
                "points": np.stack([x[inner], smooth[inner]], axis=1),
            }
        )
    return out


def turns(_progress: Progress, root: str) -> list[str]:
    """Bags below `root` with turns of the unloaded wheel, by their record."""
    base = Path(root)
    return [
        str(record.parent.relative_to(base))
        for record in sorted(base.rglob(FILE_NAME))
        if UNLOADED_TURN in record.read_text(encoding="utf-8")
    ]


def identify(
    _progress: Progress, root: str, bag: str, mounting: str, date: str, target: str
) -> dict[str, Any]:
    """Write the fit of a mounting to `target`; `left`: once-per-turn force before and after it
    [N]."""
    if bag not in turns(_progress, root):
        raise ValueError(f"{bag}: not a run of three unloaded turns; choose one of the list")
    turn = turn_of_bag(Path(root) / bag)
    return {"left": identify_turn(turn, mounting, date, Path(target))}
