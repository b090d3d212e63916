# SPDX-License-Identifier: Apache-2.0
"""The main job on the simulated bench, from end to end.

Measure, fit, report, find a hidden effect.
"""

from __future__ import annotations

import argparse
import json
import os
from pathlib import Path

from flatplank_analysis.contact_patch.session import Session
from flatplank_analysis.discovery.modelfile import ModelFile, save_model
from flatplank_analysis.discovery.report.page import BEFORE_AND_AFTER, write_report
from flatplank_analysis.discovery.report.text import to_do_lines
from flatplank_analysis.discovery.verdict import Diagnosis
from flatplank_analysis.report.analysis import analyse
from flatplank_analysis.report.results import CampaignResult
from flatplank_analysis.report_files.build import write
from flatplank_analysis.steady.rolling_radius import radius_of_run
from flatplank_control.bench.fast_dds import loopback_environment
from flatplank_control.bench.processes import BenchProcesses
from flatplank_control.bench.results import write_campaign, write_tire
from flatplank_control.bench.setup import BenchSetup
from flatplank_control.runner.campaign.tires import known_tires
from flatplank_control.runner.measurement import Measurement
from flatplank_data.arguments import Parser
from flatplank_data.campaign import Campaign
from flatplank_data.files import write_atomic
from flatplank_data.wording import quantity
from flatplank_sim.cli.beside import Beside, Steps
from flatplank_sim.cli.step_printer import StepPrinter
from flatplank_sim.sealed.generate import make_challenge, measure_next
from flatplank_sim.sealed.score import DIAGNOSIS, score, text_of
from flatplank_sim.sealed.seal import unseal
from flatplank_sim.twin.campaign import SLIPS, simulate_many, slips_by_starts

FREE_ROLLING = Measurement(measurement="free_rolling", end_position=2.2, run_index=0)
SLIP_ON_GRAPH = (0.05, 1)
"""slip and start of the run that is made on the graph"""
ONE_THREAD = ("OPENBLAS_NUM_THREADS", "1")
"""of linear algebra, in each process: the threads of one wait for each other on cores that the
others need"""
CLOSE = "shaft_force"
"""what the demo hides: the first campaign cannot tell it from a look-alike"""
STARTS = (1, 2)
"""two repeats of every slip: enough for the fits and their floor"""


def measure(folder: Path, seed: int, jobs: int | None, printer: StepPrinter) -> float:
    """Make one free-rolling run and 18 slip steps, a bag each; returns the effective rolling
    radius [m]."""
    from flatplank_control.nodes.client import BenchClient

    setup = BenchSetup(pace="hold", seed=seed, data=str(folder))
    printer.step("a free-rolling run on the twin: the effective rolling radius")
    (path,) = simulate_many([FREE_ROLLING], setup, folder, bags=True, jobs=1)
    (run,) = [r for r in Campaign.load(folder).runs if r.info.name == path.name]
    radius = radius_of_run(run.table()).radius
    printer.print_progress(f"effective rolling radius by (5.22): {radius:.4f} m")
    base = Measurement(effective_rolling_radius=radius, r_e_source="controller")
    runs = slips_by_starts(base, SLIPS, STARTS)
    (on_graph,) = [m for m in runs if (m.kappa, m.start) == SLIP_ON_GRAPH]
    others = [m for m in runs if m is not on_graph]
    printer.step("one slip step on the ROS graph, recorded in a bag")
    for key, value in loopback_environment().items():
        os.environ.setdefault(key, value)
    with BenchProcesses(setup, log=folder.parent / "nodes.log") as bench, BenchClient() as client:
        client.wait_connected(bench, say=printer.print_progress)
        plan = {k: v for k, v in vars(on_graph).items() if v not in ("", {})}
        bags = client.measure(plan, simulated=True, folder=str(folder), say=printer.print_progress)
    printer.step(f"the other {len(others)} slip steps on the twin, a bag each")
    simulate_many(others, setup, folder, bags=True, jobs=jobs, progress=printer.count)
    write_campaign(folder, base.tire, [(on_graph.record(), Path(bags[-1]).name)])
    write_tire(folder, known_tires()[base.tire].record)
    return radius


def fit_and_report(
    folder: Path, out: Path, jobs: int | None, printer: StepPrinter
) -> tuple[Path, list[str]]:
    """Write the report page; returns it and the results of the fits as text."""
    printer.step("models fitted to the bags, figures and report")
    campaign = Campaign.load(folder)
    result = analyse(campaign, jobs=jobs)
    page = write(result, out)
    return page, [*_found(result), *(str(problem) for problem in campaign.problems)]


def _found(result: CampaignResult) -> list[str]:
    """Slip stiffness, relaxation length and errors of the models, as text."""
    point = result.nominal()
    if point is None:
        return []
    lines = []
    small = min(
        (c for c in point.conditions if c.condition.kappa > 0), key=lambda c: c.condition.kappa
    )
    fit = small.linear
    lines.append(
        f"linear model at {100 * small.condition.kappa:+g} %: relaxation length "
        f"{fit.sigma.value:.3f} m, slip stiffness {fit.slip_stiffness.value / 1000:.1f} kN"
    )
    for model in point.models.values():
        mean = sum(model.rmse.values()) / max(len(model.rmse), 1)
        lines.append(
            f"{model.title}: RMSE in the transient part {mean:.0f} N (mean over the slips)"
        )
    return lines


def sealed_challenge(folder: Path, seed: int, close: str, printer: Steps) -> list[str]:
    """Go once through the loop of diagnosis: a group, the run that separates it, the cause;
    returns the result as text. seed, close: see `make_challenge`."""
    printer.step("a sealed challenge: a campaign with something hidden")
    make_challenge(folder, seed, printer.count, close=close)
    printer.step("diagnose: where the model fails, and which effect is missing")
    session, result, *lines = _diagnosed(folder, printer)
    printer.step("the run that separates the group, made on the same machine; diagnose again")
    proposal = result.next_run
    lines.append(f"next run: {proposal.get('what', 'none is needed, there is no group')}")
    printer.print_progress(lines[-1])
    if proposal.get("settings"):
        measure_next(folder, proposal["settings"], proposal["repeats"], printer.count)
        session, result, *again = _diagnosed(folder, printer)
        lines += again
    printer.step("add what was found, watch the error fall, open the answer")
    return [*lines, *_named(session, result, folder, printer)]


def _diagnosed(folder: Path, printer: Steps) -> tuple[Session, Diagnosis, str]:
    """Diagnose the runs of the challenge; returns the verdict as text, too."""
    session = Session.open(str(folder))
    result = session.diagnose(
        None, lambda text, share: printer.print_progress(f"{share:4.0%} {text}")
    )
    data = result.to_dict()
    named = ", ".join(e["text"]["name"] for e in data["effects"])
    text = (
        f"{data['runs']} runs: verdict {data['verdict']}{': ' if named else ''}{named}; error "
        f"{data['rmse_before']:.1f} N, floor {data['floor_rmse']:.1f} N"
    )
    printer.print_progress(text)
    return session, result, text


def _named(session: Session, result: Diagnosis, folder: Path, printer: Steps) -> list[str]:
    """Add what a diagnosis named, write its page and open the answer; returns the result as
    text."""
    data, model, lines = result.to_dict(), ModelFile(campaign=str(folder)), []
    write_atomic(folder / DIAGNOSIS, json.dumps(data, indent=1) + "\n")
    search = result.search
    # the diagnosis has fitted the model without effects, of these runs or of parts of them
    before = search.steps[0] if search and search.model is session.model else None
    for effect in data["effects"]:
        printer.print_progress(f"{effect['name']} is added, and everything is fitted again")
        model, before, n = session.add(model, effect["name"], before)
        save_model(model, folder / "model.yaml")
        lines.append(
            f"  + {effect['name']} {quantity(n['size'], n['unit'])}: error "
            f"{n['rmse_before']:.1f} -> {n['rmse']:.1f} N (held out {n['held_out']:.1f} N)"
        )
        printer.print_progress(lines[-1].strip())
    lines += [f"  {line}" for line in to_do_lines(result, str(folder))]
    printer.print_progress("page and figures")
    where = session.campaign.path
    page = write_report(result, folder / "report", where, model.history, session.about)
    answer = unseal(folder)
    lines += [f"  {line}" for line in text_of(answer, score(data, answer))]
    if result.found:
        lines.append(f"before and after: {page.with_name(f'{BEFORE_AND_AFTER}.png')}")
    return [*lines, f"diagnosis: {page}"]


def parser() -> argparse.ArgumentParser:
    p = Parser(prog="flatplank demo", description=__doc__)
    p.add_argument("--out", type=Path, default=Path("demo"), help="folder for everything it makes")
    p.add_argument("--seed", type=int, default=1, help="of the simulated bench")
    p.add_argument(
        "--hidden", type=int, metavar="SEED",
        help="hide what this seed draws, in 27 runs; default: a force of the shaft, in eight runs "
        "that cannot tell it from an uneven tire",
    )  # fmt: skip
    p.add_argument("--jobs", type=int, help="processes; default: all cores")
    return p


def main(argv: list[str]) -> int:
    """Make everything and return 0; the last lines state the results and where they are.

    The challenge needs nothing of the bench, and has a process of its own beside it.
    """
    o = parser().parse_args(argv)
    out = o.out.resolve()
    campaign = out / "campaign"
    os.environ.setdefault(*ONE_THREAD)
    hidden = (o.seed, CLOSE) if o.hidden is None else (o.hidden, "")
    beside = Beside(sealed_challenge, out / "challenge", *hidden)
    with StepPrinter(steps=8) as printer, beside:
        radius = measure(campaign, o.seed, o.jobs, printer)
        page, found = fit_and_report(campaign, out / "report", o.jobs, printer)
        challenge = beside.print_steps(printer)
        printer.close(
            [
                f"effective rolling radius (free rolling, Toyo, 3700 N): {radius:.4f} m",
                *found,
                *challenge,
                f"report:   {page}",
                f"bags:     {campaign}",
            ]
        )
    return 0
