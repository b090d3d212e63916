# SPDX-License-Identifier: Apache-2.0
"""Folders of campaigns below a folder: where they are, whether they changed, verdicts of runs."""

from __future__ import annotations

import os
from collections.abc import Iterator

from flatplank_data.campaign import CAMPAIGN_FILE, Campaign
from flatplank_data.journals import SUFFIX, verdicts_of
from flatplank_data.readers import suffixes
from flatplank_data.readers.bag import METADATA_FILE

Stamp = tuple[tuple[str, int, int], ...]
"""name, time [ns] and size of each file"""
PAGES = {"report.html", "index.html"}
"""files by which the folder of a report is known"""
OF_A_PAGE = {"figures", "tables"}
"""folders of a report with the numbers of its figures and tables"""


def campaign_folders(
    root: str | os.PathLike[str], depth: int | None = None
) -> Iterator[tuple[str, int]]:
    """Folders below `root` that hold runs, and how many runs; in order, relative to `root`.

    depth: levels below the root that are searched; None for all. Hidden folders are left out, and
    the numbers of a report.
    """
    base, ends = os.fspath(root), tuple(suffixes())
    for path, folders, files in os.walk(base):
        folder = os.path.relpath(path, base)
        level = 0 if folder == os.curdir else folder.count(os.sep) + 1
        bags = {METADATA_FILE, f"{os.path.basename(path)}_0.mcap"}
        if not bags.isdisjoint(files):
            folders.clear()
            continue
        folders[:] = sorted(f for f in folders if not f.startswith("."))
        if not PAGES.isdisjoint(files):
            folders[:] = [f for f in folders if f not in OF_A_PAGE]
            files = [name for name in files if f"{os.path.splitext(name)[0]}.svg" not in files]
        known = sum(os.path.exists(os.path.join(path, f, METADATA_FILE)) for f in folders)
        tables = sum(name.lower().endswith(ends) for name in files)
        if CAMPAIGN_FILE in files or known or tables:
            yield folder, known or tables
        if level == depth:
            folders.clear()


def stamp_of(folder: str | os.PathLike[str]) -> Stamp:
    """Name, time [ns] and size of all files of the runs, also inside bags; no model files."""
    ends = (*suffixes(), CAMPAIGN_FILE, SUFFIX)
    found = []
    for entry in os.scandir(folder):
        if entry.is_dir():
            found += [inner for inner in os.scandir(entry) if inner.is_file()]
        elif entry.name.lower().endswith(ends):
            found.append(entry)
    stats = ((entry.path, entry.stat()) for entry in found)
    return tuple(sorted((path, s.st_mtime_ns, s.st_size) for path, s in stats))


def verdicts(campaign: Campaign) -> dict[str, str]:
    """file -> verdict of the campaign's journal and problems of the file, or ok."""
    judged = verdicts_of(campaign.path)
    remarks: dict[str, list[str]] = {}
    for problem in campaign.problems:
        remarks.setdefault(problem.file, []).append(problem.what)
    files = [run.info.file for run in campaign.runs]
    told = {f: [*([judged[f]] if f in judged else []), *remarks.get(f, ())] for f in files}
    return {file: "; ".join(words) or "ok" for file, words in told.items()}
