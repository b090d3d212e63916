# SPDX-License-Identifier: Apache-2.0
"""Fast jobs without a fit: list campaigns, runs with verdicts and curves, unloaded turns."""

from __future__ import annotations

from collections import Counter
from collections.abc import Mapping, Sequence
from functools import lru_cache
from pathlib import Path
from typing import Any

import numpy as np

from flatplank_control.calibration.parasitic import identify_turn, turn_of_bag
from flatplank_control.recording.bag_writer import METADATA, bag_file_name
from flatplank_control.runner.campaign import SUFFIX, read_lines
from flatplank_data.campaign import CAMPAIGN_FILE, Campaign
from flatplank_data.errors import FlatplankError
from flatplank_data.progress import Progress, told
from flatplank_data.readers import suffixes
from flatplank_data.run_record import FILE_NAME
from flatplank_panel.analysis import repeats
from flatplank_panel.signals import CHANNELS, OVER

Line = Mapping[str, Any]
Stamp = tuple[tuple[str, int, int], ...]
"""name, time [ns] and size of each file"""
DEPTH = 3
"""levels below the data folder that are searched for campaigns"""
POINTS = 400
"""a curve is averaged over 1/POINTS of its length, and drawn with twice as many points"""
UNLOADED_TURN = "\nmeasurement: unloaded_turn\n"


def campaigns(_progress: Progress, root: str) -> list[dict[str, Any]]:
    """Folders below `root` that hold runs."""
    base, found = Path(root), []
    for folder in (base, *sorted(p for p in base.rglob("*") if p.is_dir())):
        parts = folder.relative_to(base).parts
        if len(parts) > DEPTH or any(p.startswith(".") for p in parts):
            continue
        of_a_bag = (METADATA, bag_file_name(folder.name))
        if any((folder / name).exists() for name in of_a_bag):
            continue
        bags = sum(1 for _ in folder.glob(f"*/{METADATA}"))
        tables = sum(1 for p in folder.iterdir() if p.name.lower().endswith(tuple(suffixes())))
        if (folder / CAMPAIGN_FILE).exists() or bags or tables:
            found.append({"folder": str(folder.relative_to(base)) or ".", "runs": bags or tables})
    return found


@lru_cache(maxsize=4)
def _read(_folder: str, _stamp: Stamp) -> list[Campaign]:
    """Room for the campaign."""
    return []


def _campaign(progress: Progress, folder: str) -> Campaign:
    read = _read(folder, stamp_of(folder))
    if not read:
        read.append(Campaign.load(folder, progress=progress))
    return read[0]


def _verdicts(campaign: Campaign) -> dict[str, str]:
    """file -> verdict of the campaign and problems of the file, or ok."""
    judged = verdicts_of(campaign.path)
    out = {}
    for file in (run.info.file for run in campaign.runs):
        remarks = [p.what for p in campaign.problems if p.file == file]
        out[file] = "; ".join([*([judged[file]] if file in judged else []), *remarks]) or "ok"
    return out


def runs(progress: Progress, folder: str) -> dict[str, Any]:
    """One row per run, and the problems found."""
    campaign = _campaign(progress, folder)
    verdicts = _verdicts(campaign)
    rows = [
        {
            "file": i.file, "tire": i.tire, "measurement": i.measurement,
            "condition": i.condition.label(), "kappa_percent": round(100.0 * i.kappa, 3),
            "fz": i.fz, "pressure": i.pressure, "alpha": i.alpha_deg, "gamma": i.gamma_deg,
            "start": i.start, "order": i.run_index, "status": i.status or "complete",
            "lost": i.cycles_lost, "notes": i.notes, "verdict": verdicts[i.file],
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
        "verdicts": _verdicts(whole),
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


def stamp_of(folder: str | Path) -> Stamp:
    """Name, time [ns] and size of all files of the runs, also inside bags; no model files."""
    ends = (*suffixes(), CAMPAIGN_FILE, SUFFIX)
    base = Path(folder)
    tables = (p for p in base.iterdir() if p.name.lower().endswith(ends))
    files = [p for p in (*tables, *base.glob("*/*")) if p.is_file()]
    return tuple(sorted((str(p), p.stat().st_mtime_ns, p.stat().st_size) for p in files))


def verdicts_of(folder: str | Path) -> dict[str, str]:
    """file of a run -> verdict of the campaign; runs in no journal are absent."""
    found: dict[str, str] = {}
    for path in sorted(Path(folder).glob(f"*{SUFFIX}")):
        attempts: dict[str, list[Line]] = {}
        for line in read_lines(path):
            if line.get("event") == "end":
                attempts.setdefault(line["run"], []).append(line)
        for lines in attempts.values():
            found |= {line["file"]: _text(lines, k) for k, line in enumerate(lines)}
    return found


def _text(lines: Sequence[Line], k: int) -> str:
    """Verdict on attempt `k` of a run."""
    reasons = _reasons(lines[k].get("facts") or {})
    if lines[k]["ok"]:
        return reasons or "good"
    later = f", made again as {lines[k + 1]['file']}" if k + 1 < len(lines) else ""
    return f"rejected{later}: {reasons}"


def _reasons(facts: Line) -> str:
    """Text of the verdict in the journal; journals of older versions have only numbers."""
    numbers = (f"{name} {value:.3g}" for name, value in (facts.get("findings") or {}).items())
    return str(facts.get("verdict") or "") or ", ".join(numbers)


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
