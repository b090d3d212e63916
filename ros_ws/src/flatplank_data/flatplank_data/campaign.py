# SPDX-License-Identifier: Apache-2.0
"""A campaign folder as one object: it reads all run records at once, samples on request."""

from __future__ import annotations

import dataclasses
import os
from collections.abc import Callable, Collection, Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any

from flatplank_data import checks
from flatplank_data.condition import Condition, is_nan
from flatplank_data.errors import FlatplankError, NothingUsableError
from flatplank_data.identity import TOLD_BY, Identity, KnownRuns, copy_of, identity_of
from flatplank_data.measured import (
    UNKNOWN,
    is_rolling_run_without_load,
    missing_keys,
    stop_text,
    with_measured_values,
    with_values_in_use,
)
from flatplank_data.naming import FOLDERS, facts_of_name
from flatplank_data.problem import Problem, problem_from_error
from flatplank_data.progress import Progress, told
from flatplank_data.readers import Request, read_description, reader_for, suffixes
from flatplank_data.readers.bag import MEASURED, METADATA_FILE
from flatplank_data.readers.base import turned_columns, turned_facts, turned_info, turned_names
from flatplank_data.record_checks import default_of
from flatplank_data.run_record import FILE_NAME, RunRecord, read_run, stem_of
from flatplank_data.stamps import in_order
from flatplank_data.stops import COLUMNS as STOP_COLUMNS
from flatplank_data.stops import wheel_stop
from flatplank_data.store import Store, open_store
from flatplank_data.table import COLUMN_UNITS, MeasurementTable
from flatplank_data.turns import whole_turns
from flatplank_data.yaml_text import load_yaml

STOPPABLE = ("slip", "free_rolling", UNKNOWN, "cleat", "camber_sweep")
"""kinds of measurement in which the wheel rolls from the beginning to the end"""
FORMAT = "flatplank-measurement-table/1"
CAMPAIGN_FILE = "campaign.yaml"
USED = ("", "complete")
"""statuses of the runs that are evaluated; empty: the file states no status"""


@dataclass(frozen=True)
class Run:
    """One run of a campaign; `table` reads its samples."""

    info: RunRecord
    store: Store
    mapping: Mapping[str, Any] | None = None
    given: Collection[str] = ()
    """keys that campaign.yaml sets; they override the run's own file"""

    def table(self, columns: Sequence[str] | None = None, check: bool = True) -> MeasurementTable:
        """The samples, `columns` only or all; raises `FlatplankError` when they are unusable."""
        return self.read(columns, check)[0]

    def read(
        self, columns: Sequence[str] | None = None, check: bool = True, further: bool = False
    ) -> tuple[MeasurementTable, list[Problem]]:
        """The samples and the remarks on them.

        columns: None for all; further: also numeric columns with unknown names. Raises
        FlatplankError for a file that cannot be read and, with `check`, on a fatal remark.
        """
        table, remarks, _ = self._read(columns, check, further)
        return _selected(table, columns), remarks

    def record(self) -> RunRecord:
        """The record, completed by the run's own file where that can be read."""
        try:
            facts = turned_facts(dict(read_description(self.store, self.info.file)), self.mapping)
        except FlatplankError:
            return self.info  # reading its samples tells what is wrong with the file
        return _merged(self.info, facts, self.given)

    def identity(self) -> Identity:
        """See `identity_of`; raises FlatplankError when the samples are unusable."""
        columns = () if self.info.measurement in checks.REQUIRED else None
        return identity_of(self._read(columns, check=True, further=False)[2])

    def _read(
        self, columns: Sequence[str] | None, check: bool, further: bool
    ) -> tuple[MeasurementTable, list[Problem], MeasurementTable]:
        """As `read`, with all columns that were read for the checks; and the whole table, bad
        samples included."""
        wanted = columns
        needed = checks.REQUIRED.get(self.info.measurement, ()) if check else ()
        if columns is not None:
            wanted = [*dict.fromkeys([*columns, *needed, *STOP_COLUMNS, *TOLD_BY])]
        request = Request(self.store, self.info.file, wanted, self.mapping, further, needed)
        loaded = reader_for(self.store, self.info.file)(request)
        facts = dict(loaded.facts)
        measured = turned_facts(facts.pop(MEASURED, {}), self.mapping)
        merged = _merged(self.info, turned_facts(facts, self.mapping), self.given)
        info, remarks = with_values_in_use(merged, measured)
        ordered, told = in_order(turned_columns(loaded.columns, self.mapping))
        if check:
            ordered, more = whole_turns(ordered, self.info.file)
            told += more
        table = MeasurementTable(ordered, info)
        remarks += [
            Problem(self.info.file, text, fatal=False) for text in (*loaded.remarks, *told)
        ]
        whole = table
        table, stopped = up_to_stop(whole, measured)
        remarks += stopped
        if check:
            table, found = checks.run_checks(table)
            remarks += found
        for problem in remarks:
            if check and problem.fatal:
                raise problem.as_error()
        return table, remarks, whole


def _selected(table: MeasurementTable, columns: Sequence[str] | None) -> MeasurementTable:
    """The table with these columns and the further ones only."""
    if columns is None:
        return table
    more = [name for name in table.columns if name not in COLUMN_UNITS]
    return table.select([*(name for name in columns if name in table), *more])


def _described(store: Store, info: RunRecord, mapping: Mapping | None) -> RunRecord:
    """Complete the record: from the file first, then from its name, then from the samples."""
    facts = dict(read_description(store, info.file))
    facts.pop("file", None)
    given = {k: v for k, v in info.to_dict().items() if k != "_own"} | facts
    found = read_run(given, info.file)[0]
    if not is_rolling_run_without_load(found):
        return found
    loaded = reader_for(store, info.file)(Request(store, info.file, (), mapping))
    return read_run(with_measured_values(given, loaded.facts.get(MEASURED, {})), info.file)[0]


def up_to_stop(
    table: MeasurementTable, measured: Mapping[str, Any]
) -> tuple[MeasurementTable, list[Problem]]:
    """The run up to the first stop of its wheel, and a remark on it; unchanged without one."""
    if table.info.measurement not in STOPPABLE:
        return table, []
    stop = wheel_stop(table.columns)
    if stop is None:
        return table, []
    text = str(measured.get("stop_reason") or stop_text(stop))
    remedy = "what follows is left out; make the run again if it is missed"
    place = f"row {stop.row + 1}"
    return table.rows(slice(0, stop.row)), [Problem(table.info.file, text, place, remedy, False)]


def _merged(info: RunRecord, facts: Mapping[str, Any], given: Collection[str]) -> RunRecord:
    """The record in campaign.yaml, which sets the keys `given`; the run's own file supplies the
    others."""
    own, _ = read_run(facts, info.file)
    changes = {}
    for item in dataclasses.fields(RunRecord):
        ours, theirs, usual = getattr(info, item.name), getattr(own, item.name), default_of(item)
        if item.name in ("file", "name", "extra") or theirs == usual:
            continue
        if is_nan(ours) or (ours == usual and item.name not in given):
            changes[item.name] = theirs
    return dataclasses.replace(info, **changes) if changes else info


@dataclass
class Campaign:
    """Runs of one folder. `problems` grows while tables are read; nothing else changes."""

    path: str
    runs: list[Run]
    tire: str = ""
    problems: list[Problem] = field(default_factory=list)
    _files: dict[str, str] = field(default_factory=dict, repr=False)
    _known: KnownRuns = field(default_factory=KnownRuns, repr=False)

    @classmethod
    def load(
        cls,
        path: str | os.PathLike[str],
        mapping: Mapping[str, Any] | None = None,
        progress: Progress | None = None,
    ) -> Campaign:
        """Read the run records of a folder of tables or bags; `progress` is told of each.

        Raises NothingUsableError without a usable run, FlatplankError for a wrong campaign.yaml.
        """
        store = open_store(path)
        problems: list[Problem] = []
        raw = _records(store, problems)
        campaign = cls(os.fspath(path), [], str(raw.get("tire") or ""), problems)
        mapping = mapping or _mapping(store, raw)
        turned_names(mapping)
        for number, entry in enumerate(told(raw["runs"], progress), start=1):
            campaign._add(store, entry, number, mapping)
        campaign._drop_doubles()
        campaign._tell_unlisted(store)
        if not campaign.runs:
            first = f" (first problem: {problems[0]})" if problems else ""
            raise NothingUsableError(
                f"no usable run{first}", os.fspath(path), "check the folder and its campaign.yaml"
            )
        return campaign

    def _add(self, store: Store, entry: Any, number: int, mapping: Mapping | None) -> None:
        where = f"{CAMPAIGN_FILE}, run {number}"
        try:
            if not isinstance(entry, Mapping) or not entry.get("file"):
                raise FlatplankError("entry without 'file'", where, "name the file of the run")
            info, remarks = read_run(entry, f"{entry['file']}, {where}")
            if not info.tire:
                info = dataclasses.replace(info, tire=self.tire)
            if not store.exists(info.file):
                raise FlatplankError(
                    "no such file", info.file, f"correct {where}, or copy it here"
                )
            reader_for(store, info.file)
            own = "_own" in info.extra
            if own:
                info = _described(store, info, mapping)
        except FlatplankError as error:
            file = entry.get("file", where) if isinstance(entry, Mapping) else where
            self.problems.append(problem_from_error(error, str(file)))
            return
        # a bag opened by its own path is evaluated whatever its status
        if info.status not in USED and not store.exists(FILE_NAME):
            self.problems.append(_left_out(info.file, info.to_dict()))
            return
        for text in remarks:
            self.problems.append(Problem(info.file, text, where, "correct the spelling", False))
        if own and _is_bag(store, info.file):
            self.problems += missing_keys(info, FILE_NAME)
        given = () if own else frozenset(k for k, v in entry.items() if v not in (None, "", {}))
        self.runs.append(Run(turned_info(info, mapping), store, mapping, given))

    def _tell_unlisted(self, store: Store) -> None:
        """Report runs in the folder that campaign.yaml does not list."""
        if not store.exists(CAMPAIGN_FILE):
            return
        known = {run.info.file for run in self.runs} | {problem.file for problem in self.problems}
        for entry in _found(store):
            file = entry["file"]
            if file not in known and (_is_bag(store, file) or "tire" in entry):
                self.problems.append(_left_out(file, _facts_of(store, file)))

    def _drop_doubles(self) -> None:
        """Keep the first of runs with the same UUID or file: a copy, or a wrong record."""
        seen: dict[str, str] = {}
        kept = []
        for run in self.runs:
            file = run.info.file
            keys = [k for k in (run.info.uuid, file) if k]
            other = next((seen[k] for k in keys if k in seen), None)
            if other is not None:
                what = f"same UUID {run.info.uuid}" if run.info.uuid else "listed twice,"
                remedy = "leave one of them out, or give it its own UUID"
                self.problems.append(Problem(file, f"{what} as {other}", remedy=remedy))
                continue
            seen.update(dict.fromkeys(keys, file))
            kept.append(run)
        self.runs = kept

    def __len__(self) -> int:
        return len(self.runs)

    @property
    def infos(self) -> list[RunRecord]:
        """Run records in the order of campaign.yaml, without it by file name."""
        return [run.info for run in self.runs]

    def records(self) -> list[RunRecord]:
        """Run records in the same order, each completed by the run's own file: date, bench, seed
        and versions are there."""
        return [run.record() for run in self.runs]

    def where(self, keep: Callable[[RunRecord], bool]) -> Campaign:
        """The runs for which `keep(info)` is true; shares the list of problems."""
        return dataclasses.replace(self, runs=[run for run in self.runs if keep(run.info)])

    def merged(self, other: Campaign) -> Campaign:
        """Both campaigns as one."""
        path, tire = f"{self.path}+{other.path}", self.tire or other.tire
        out = Campaign(path, self.runs + other.runs, tire, self.problems + other.problems)
        if os.path.abspath(self.path) == os.path.abspath(other.path):
            out._drop_doubles()
        return out

    def conditions(self) -> dict[Condition, list[Run]]:
        """Runs by condition (tire, load, pressure, angles, slip), in a sorted order."""
        groups: dict[Condition, list[Run]] = {}
        for run in self.runs:
            groups.setdefault(run.info.condition, []).append(run)
        return dict(sorted(groups.items(), key=lambda item: item[0].sort_key))

    def tables(self, columns: Sequence[str] | None = None) -> Iterator[MeasurementTable]:
        """Yield one table after the other; a run that cannot be used is added to `problems`."""
        for run in self.runs:
            table = self.try_table(run, columns)
            if table is not None:
                yield table

    def try_table(
        self, run: Run, columns: Sequence[str] | None = None, further: bool = False
    ) -> MeasurementTable | None:
        """The samples of a run, or None with the reason in `problems`; see `Run.read`."""
        try:
            table, remarks, whole = run._read(columns, check=True, further=further)
        except FlatplankError as error:
            self.add_problem(problem_from_error(error, run.info.file))
            return None
        for problem in remarks:
            self.add_problem(problem)
        first = self._files.setdefault(table.info.uuid or run.info.file, run.info.file)
        if first != run.info.file:
            what = f"same UUID {table.info.uuid} as {first}"
            self.add_problem(Problem(run.info.file, what, remedy="leave one of them out"))
            return None
        copied = copy_of(whole, self._known)
        if copied is not None:
            self.add_problem(copied)
            return None
        return _selected(table, columns)

    def add_problem(self, problem: Problem) -> None:
        """Add a problem, unless it is in the list already."""
        if problem not in self.problems:
            self.problems.append(problem)


def _records(store: Store, problems: list[Problem]) -> dict[str, Any]:
    """Content of campaign.yaml, or the runs found in the folder by their names."""
    if not store.exists(CAMPAIGN_FILE):
        return {"runs": _found(store)}
    with store.open(CAMPAIGN_FILE) as stream:
        raw = load_yaml(stream.read(), CAMPAIGN_FILE)
    if not isinstance(raw, Mapping) or not isinstance(raw.get("runs"), list):
        raise FlatplankError("no list 'runs'", CAMPAIGN_FILE, f"write 'format: {FORMAT}' and runs")
    if raw.get("format") != FORMAT:
        what = f"format '{raw.get('format')}' is not {FORMAT}"
        problems.append(Problem(CAMPAIGN_FILE, what, "key 'format'", "check the file", False))
    return dict(raw)


def _found(store: Store) -> list[dict[str, Any]]:
    """Runs by their file names: in the folder itself, and in the folders of Appendix F."""
    out: list[dict[str, Any]] = []
    top = store.names()
    folders = [name for name in top if name in FOLDERS and store.is_dir(name)]
    below = [f"{folder}/{name}" for folder in folders for name in store.names(folder)]
    for name in [*top, *below]:
        known = name.lower().endswith(tuple(suffixes()))
        if known or _is_bag(store, name):
            facts = facts_of_name(stem_of(name))
            out.append({"file": name, "run_index": len(out)} | facts | {"_own": True})
    return out


def _facts_of(store: Store, file: str) -> Mapping[str, Any]:
    """Facts in an unlisted file; empty when it cannot be read."""
    try:
        return read_description(store, file)
    except FlatplankError:
        return {}


def _left_out(file: str, facts: Mapping[str, Any]) -> Problem:
    """Why a run is not evaluated: its status, or it is not in campaign.yaml."""
    status = str(facts.get("status") or "")
    if status in USED:
        what, remedy = f"left out: not in {CAMPAIGN_FILE}", "list it there if it counts"
    else:
        why = facts.get("stop_reason") or facts.get("notes")
        what = f"left out: it ended as '{status}'" + (f" ({why})" if why else "")
        remedy = "measure it again if it is missed"
    return Problem(file, what, remedy=remedy, fatal=False, left_out=True)


def _is_bag(store: Store, name: str) -> bool:
    """True for a folder with metadata.yaml, or with the bag file that a killed recorder left."""
    stem = name.rsplit("/", 1)[-1]
    files = (METADATA_FILE, f"{stem}_0.mcap", f"{stem}_0.db3")
    return store.is_dir(name) and any(store.exists(f"{name}/{file}") for file in files)


def _mapping(store: Store, raw: Mapping[str, Any]) -> Mapping[str, Any] | None:
    """Mapping of foreign names: from campaign.yaml, or from the file that it names."""
    mapping = raw.get("mapping")
    if isinstance(mapping, str):
        with store.open(mapping) as stream:
            mapping = load_yaml(stream.read(), str(raw["mapping"]))
    return mapping
