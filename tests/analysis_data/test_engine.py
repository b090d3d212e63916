# SPDX-License-Identifier: Apache-2.0
"""Independent work: in order, in chunks, bounded in flight, the same from everywhere, and done
again when a worker dies."""

from __future__ import annotations

import json
import os
from concurrent.futures import Future
from functools import partial
from pathlib import Path

import pytest
from diesonce import dies, dies_once, squared
from steptable import step_table

from flatplank_analysis import chunks
from flatplank_analysis.chunks import in_order
from flatplank_analysis.cli.diagnose import main as diagnose
from flatplank_analysis.parallel import open_executor
from flatplank_data.errors import FlatplankError
from flatplank_data.exporters import export_campaign


class LostError(Exception):
    """What the result of a dead worker raises."""


class Hand:
    """A crew of one that works when it is asked, and whose deaths are given beforehand."""

    lost = (LostError,)

    def __init__(self, deaths: tuple[int, ...] = (), seconds: float = 0.0) -> None:
        self.deaths, self.seconds = set(deaths), seconds
        self.sizes: list[int] = []
        self.renewed = 0

    def workers(self) -> int:
        return 1

    def submit(self, work, function, chunk) -> Future:
        done: Future = Future()
        if len(self.sizes) in self.deaths:
            done.set_exception(LostError())
        else:
            _, results = work(function, chunk)
            done.set_result((self.seconds * len(chunk), results))
        self.sizes.append(len(chunk))
        return done

    def renew(self) -> None:
        self.renewed += 1


@pytest.mark.parametrize("deaths", [(), (1, 5), (3, 4, 6), *((k,) for k in range(24))])
def test_results_have_the_order_of_the_items(deaths: tuple[int, ...]) -> None:
    crew = Hand(deaths, 0.4)
    assert list(in_order(crew, squared, range(100))) == [k * k for k in range(100)]
    assert len(crew.sizes) > 0 and bool(crew.renewed) == any(k < len(crew.sizes) for k in deaths)


def test_a_chunk_takes_two_seconds_and_the_last_ones_are_shared() -> None:
    crew = Hand(seconds=0.1)
    list(in_order(crew, squared, range(1000)))
    assert max(crew.sizes) == round(chunks.CHUNK / 0.1)
    assert crew.sizes[-1] == 1
    empty = Hand(seconds=1e-9)
    list(in_order(empty, squared, range(100_000)))
    assert len(empty.sizes) < 60


def test_as_much_is_in_flight_as_the_workers_need() -> None:
    crew = Hand(seconds=10.0)
    results = in_order(crew, squared, range(1000))
    for done in range(1, 5):
        next(results)
        assert len(crew.sizes) <= done - 1 + chunks.AHEAD


def test_work_that_kills_every_worker_is_given_up_in_a_line() -> None:
    with pytest.raises(FlatplankError, match="workers died 4 times at the same work"):
        list(in_order(Hand(tuple(range(99))), squared, range(3)))


@pytest.mark.parametrize("jobs", [1, 2])
def test_the_error_of_an_item_is_raised(jobs: int) -> None:
    with open_executor(jobs) as executor, pytest.raises(ValueError, match="no 7"):
        list(executor.map(partial(squared, refused=7), range(20)))


def test_no_items_start_no_worker() -> None:
    with open_executor(2) as executor:
        assert list(executor.map(squared, [])) == []


def test_the_same_from_one_process_and_from_two_of_which_one_dies(tmp_path: Path) -> None:
    items = [str(tmp_path / str(k)) for k in range(40)]
    with open_executor(2) as executor:
        assert list(executor.map(dies_once, items)) == list(map(dies_once, items))


def test_a_process_that_always_dies_is_told(tmp_path: Path) -> None:
    with open_executor(2) as executor, pytest.raises(FlatplankError, match="fewer --jobs"):
        list(executor.map(dies, range(3)))


@pytest.mark.filterwarnings("default")
@pytest.mark.parametrize("found_by", ["address", "scheduler file"])
def test_the_same_from_a_cluster_of_which_a_worker_dies(found_by: str, tmp_path: Path) -> None:
    distributed = pytest.importorskip("distributed")
    items = [str(tmp_path / str(k)) for k in range(40)]
    with distributed.LocalCluster(
        n_workers=2, threads_per_worker=1, processes=True, dashboard_address=None,
        local_directory=str(tmp_path / "own"),
    ) as cluster:  # fmt: skip
        where = cluster.scheduler_address
        if found_by == "scheduler file":
            where = str(tmp_path / "scheduler.json")
            with distributed.Client(cluster) as client:
                client.write_scheduler_file(where)
        with open_executor(scheduler=where) as executor:
            assert list(executor.map(dies_once, items)) == list(range(40))
    assert os.path.exists(items[2])


def test_many_campaigns_are_diagnosed_each_beside_its_runs(tmp_path: Path, capsys) -> None:
    for name in ("a", "b"):
        tables = [
            step_table(kappa, 1, 5.0, repeat=repeat, file=f"TOY_{100 * kappa:g}_{repeat}.parquet")
            for kappa in (0.01, -0.01)
            for repeat in (1, 2)
        ]
        export_campaign(tables, tmp_path / name)
    folders = [str(tmp_path / name) for name in ("a", "b", "missing")]
    assert diagnose([*folders, "--json", "--jobs", "1"]) == 0
    one, two, three = json.loads(capsys.readouterr().out)["campaigns"]
    assert one["verdict"] == two["verdict"] and "no such folder" in three["error"]
    kept = json.loads((tmp_path / "a" / "diagnosis.json").read_text())
    assert kept["verdict"] == one["verdict"]
    with pytest.raises(FlatplankError, match="belongs to one campaign"):
        diagnose([*folders, "--report", str(tmp_path / "page")])
