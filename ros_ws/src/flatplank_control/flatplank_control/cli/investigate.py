# SPDX-License-Identifier: Apache-2.0
"""Measure until the missing effect is decided.

Diagnose, choose the next run, measure, repeat.
"""

from __future__ import annotations

import argparse
import json
import sys
from collections.abc import Callable, Iterator
from contextlib import contextmanager, redirect_stdout
from pathlib import Path
from typing import Any

from flatplank_analysis.cli import common, loop
from flatplank_analysis.investigation.notebook import summary, text_of
from flatplank_control.cli.operator import Keys
from flatplank_control.cli.run import KEYS, act_on_key
from flatplank_control.investigate.bench import Execute
from flatplank_control.investigate.opening import (
    NAME,
    NOTEBOOK,
    executor_on_twin,
    open_loop,
    save_notebook,
)
from flatplank_control.runner.campaign import CampaignPlan
from flatplank_data.arguments import Parser, add_json, add_namespace
from flatplank_data.errors import FlatplankError
from flatplank_data.journals import SUFFIX

STOPPED = 130


def parser() -> argparse.ArgumentParser:
    p = Parser(prog="flatplank investigate", description=__doc__)
    p.add_argument("folder", type=Path, metavar="DIR", help="campaign folder; may be new")
    p.add_argument("--minutes", type=float, default=60.0, help="of bench time; default: 60")
    p.add_argument("--tire", default="", help="of config/tires.yaml; default: as the runs say")
    common.effect_arguments(p)
    p.add_argument("--lab", action="store_true", help="manual steps are asked for")
    add_namespace(p)
    p.add_argument("--sim", action="store_true", help="on the twin, in this process")
    p.add_argument("--preset", default="", help="with --sim: defects of the machine")
    p.add_argument("--plant", default="", help="with --sim: YAML file laid over the plant")
    p.add_argument("--seed", type=int, default=1, help="with --sim: of the plant")
    p.add_argument("--jobs", type=int, help="with --sim: processes; default: all cores")
    add_json(p)
    return p


def main(argv: list[str]) -> int:
    """Exit code 0: finished, whatever the verdict; 1: stopped by the bench; 130: Ctrl-C."""
    o = parser().parse_args(argv)
    return common.run_or_report_nothing_usable("investigate", lambda: _run(o))


def _run(o: argparse.Namespace) -> int:
    if not 0.0 < o.minutes < 1e5:
        raise FlatplankError(f"--minutes {o.minutes:g}", "investigate", "give 1 to 99999")
    loop.require_folder(o.folder)
    folder = o.folder.resolve()

    def say(text: str) -> None:
        print(text, file=sys.stderr if o.json else sys.stdout, flush=True)

    execute = _executor(o, folder)
    flow = open_loop(folder, o.minutes, execute, o.tire, tuple(common.effect_files(o)), say)
    events = flow.log.events
    if events:
        print(f"going on after {len(events)} events of {folder / NAME}", file=sys.stderr)
    try:
        flow.run()
    except ValueError as error:
        print(f"flatplank investigate: {error}", file=sys.stderr)
        return 1
    except KeyboardInterrupt as end:
        why = f" ({end})" if str(end) else ""
        print(
            f"flatplank investigate: stopped{why}; the same command continues it",
            file=sys.stderr,
        )
        return STOPPED
    page = save_notebook(flow, folder)
    if o.json:
        print(json.dumps(summary(events), indent=1))
    else:
        print(text_of(events))
        print(f"notebook: {folder / NOTEBOOK}, as a page: {page}")
    return 0


def _executor(o: argparse.Namespace, folder: Path) -> Execute:
    if o.sim:
        return executor_on_twin(folder, o.preset, o.plant, o.seed, o.jobs, print_to_stderr)
    if o.preset or o.plant:
        raise FlatplankError("--preset and --plant", "investigate", "go with --sim only")
    if sys.stdin.isatty():
        print_to_stderr("keys: " + ", ".join(f"{k} {what}" for k, what in KEYS.items()))
    return executor_on_graph(folder, not o.lab, o.namespace)


@contextmanager
def offer_keys(client: Any, journal: Path) -> Iterator[Callable[[], None]]:
    """Offer the keys of `flatplank run` during a batch; their output goes to stderr."""
    with redirect_stdout(sys.stderr), Keys() as keys:
        yield lambda: act_on_key(keys, client, journal)


def executor_on_graph(folder: Path, simulated: bool, namespace: str) -> Execute:
    """Let the runner of the running bench make the batches; the operator may press keys."""

    def execute(plan: CampaignPlan, text: str, left: float) -> None:
        from flatplank_control.nodes.client import BenchClient

        journal = folder / f"{plan.name}{SUFFIX}"

        last_line = [""]

        def hear(f) -> None:
            line = f.prompt or f.step
            if line != last_line[0] or f.prompt:  # a repeated prompt is printed again
                last_line[0] = line
                print_to_stderr(f"{line}; {left + f.time_left / 60.0:.0f} min left")

        with BenchClient(namespace=namespace) as client, offer_keys(client, journal) as idle:
            client.measure(
                text, simulated=simulated, folder=str(folder), resume=True, hear=hear,
                idle=idle,
            )  # fmt: skip

    return execute


def print_to_stderr(line: str) -> None:
    """Print progress to stderr; stdout is for programs."""
    print(line, file=sys.stderr, flush=True)
