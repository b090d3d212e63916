# SPDX-License-Identifier: Apache-2.0
"""The same results from a Dask cluster of two workers of which one is killed, and from a store.

Needs the optional packages distributed and fsspec (`requirements/test.in`).
"""

from __future__ import annotations

import os
import signal
import threading

import numpy as np
import pytest
from steptable import step_table

from flatplank_analysis.parallel import open_executor
from flatplank_analysis.report.analysis import analyse
from flatplank_data.campaign import Campaign
from flatplank_data.errors import FlatplankError
from flatplank_data.exporters import export_campaign

pytestmark = pytest.mark.long


def _campaign(folder):
    tables = []
    for fz in (1850.0, 2800.0, 3700.0, 4600.0, 5550.0, 6000.0):
        for kappa in (-0.02, -0.01, 0.01, 0.02):
            name = f"TOY_REL_LNG_{100 * kappa:g}perc_T_p25_Fz{fz:g}_1.parquet"
            table = step_table(kappa, 1, 10.0, fz=fz, file=name)
            tables.append(table.with_columns(fz=np.full(len(table), fz)))
    return export_campaign(tables, folder)


@pytest.mark.filterwarnings("default")
def test_a_worker_is_killed_in_the_middle(tmp_path):
    from distributed import LocalCluster

    folder = _campaign(tmp_path / "c")
    here = analyse(Campaign.load(folder), magic=False)
    with LocalCluster(
        n_workers=2, threads_per_worker=1, processes=True, dashboard_address=None
    ) as cluster:
        victim = next(iter(cluster.workers.values())).process.pid
        seen = threading.Event()

        def progress(done: int, total: int, what: str) -> None:
            if done == 1:
                os.kill(victim, signal.SIGKILL)
                seen.set()

        there = analyse(
            Campaign.load(folder),
            scheduler=cluster.scheduler_address,
            magic=False,
            progress=progress,
        )
    assert seen.is_set()
    for one, two in zip(here.conditions, there.conditions, strict=True):
        assert one.condition == two.condition
        assert one.linear.sigma.value == pytest.approx(two.linear.sigma.value, rel=1e-12)


def test_no_scheduler_at_the_address():
    with (
        pytest.raises(FlatplankError, match="no scheduler"),
        open_executor(scheduler="tcp://127.0.0.1:9") as executor,
    ):
        list(executor.map(abs, [1]))


def test_a_campaign_in_a_store_that_fsspec_knows(tmp_path):
    import fsspec

    folder = _campaign(tmp_path / "c")
    memory = fsspec.filesystem("memory")
    for path in folder.iterdir():
        memory.pipe(f"/bench/c/{path.name}", path.read_bytes())
    campaign = Campaign.load("memory://bench/c")
    tables = list(campaign.tables(["fx"]))
    assert len(tables) == 24 and not campaign.problems
    local = list(Campaign.load(folder).tables(["fx"]))
    np.testing.assert_array_equal(tables[5]["fx"], local[5]["fx"])
