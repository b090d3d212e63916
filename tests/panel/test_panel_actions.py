# SPDX-License-Identifier: Apache-2.0
"""What an action of a page asks of the bench, of the nodes it starts, of the analysis: word for
word."""

from __future__ import annotations

import asyncio
import math
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import pytest
import yaml
from own_loop import finished
from test_panel_investigate import WISH
from test_panel_operator import Answers

from flatplank_control.calibration.book import book_for
from flatplank_data.errors import FlatplankError
from flatplank_data.waveforms import WAVEFORMS
from flatplank_panel import host as hosts
from flatplank_panel import service as services
from flatplank_panel.host import Host, interfaces, presets, read_parameters, simulated_tires
from flatplank_panel.investigation import Investigation
from flatplank_panel.next_plan import block_of, plans_of, write_next
from flatplank_panel.operator import Operator, waveform_of
from flatplank_panel.service import AnalysisService, PageAnalysis


@pytest.fixture
def bench(tmp_path) -> Operator:
    link: Any = Answers()
    operator = Operator(link, Host(tmp_path, tmp_path / "log"), tmp_path)
    operator.take_charge("me", "My name")
    return operator


def claims(bench: Operator) -> int:
    return sum(request == "claim" for request, _ in bench.link.asked)


CLAIMED = [
    (lambda o: o.release_emergency_stop("me"), "emergency_stop", {"data": False},
     "emergency stop released"),
    (lambda o: o.enable("me", True), "enable", {"data": True}, "enabled"),
    (lambda o: o.reset_fault("me"), "reset_fault", {}, "fault reset"),
    (lambda o: o.set_mode("me", "slip", 5.0), "mode", {"mode": "slip", "value": 0.0},
     "mode slip"),
    (lambda o: o.set_mode("me", "velocity", "0.5"), "mode", {"mode": "velocity", "value": 0.5},
     "mode velocity 0.5 rad/s"),
    (lambda o: o.set_mode("me", "torque", -2), "mode", {"mode": "torque", "value": -2.0},
     "mode torque -2 N m"),
    (lambda o: o.set_mode("me", "position", 180), "mode",
     {"mode": "position", "value": pytest.approx(math.pi)}, "mode position 180 deg"),
    (lambda o: o.move_to("me", "120"), "move_to", {"angle_deg": 120.0}, "turn to 120 deg"),
    (lambda o: o.tare("me"), "tare", {}, "zero is being taken"),
    (lambda o: o.set_filter("me", True), "filter", {"data": True}, "parasitic filter on"),
    (lambda o: o.set_filter("me", 0), "filter", {"data": False}, "parasitic filter off"),
    (lambda o: o.save_recording("me"), "stop_record", {"status": "complete", "notes": ""},
     "recording saved"),
    (lambda o: o.discard_recording("me"), "discard", {}, "recording discarded"),
    (lambda o: o.confirm_prompt("me"), "confirm", {}, "confirmed"),
    (lambda o: o.set_by_hand("me", "load_to", "3700"), "load_to", {"value": 3700.0},
     "Load 3700 N"),
    (lambda o: o.set_by_hand("me", "steer", -5), "steer", {"value": -5.0}, "Steering -5 deg"),
    (lambda o: o.unload("me"), "unload", {}, "wheel lifted"),
    (lambda o: o.move_plank("me", 1, False, "1.5"), "plank",
     {"direction": 1, "fast": False, "stop_at": 1.5}, "plank forward"),
]  # fmt: skip
FREE = [
    (lambda o: o.enable("me", False), "enable", {"data": False}, "disabled"),
    (lambda o: o.quick_stop("me"), "quick_stop", {}, "quick stop"),
]  # fmt: skip


@pytest.mark.parametrize(("act", "request_", "fields", "said"), [*CLAIMED, *FREE])
def test_what_is_asked_and_what_the_log_says(bench, act, request_, fields, said):
    assert finished(act(bench)) == said == bench.link.state.log[0][1]
    assert bench.link.done() == [(request_, fields)]
    assert claims(bench) == (said not in ("disabled", "quick stop"))
    assert len(bench.link.state.log) == 1


@pytest.mark.parametrize(
    ("direction", "stop_at", "word", "claimed"),
    [(0, None, "stop", 0), (-1, "", "reverse", 1), (1, None, "forward", 1)],
)
def test_the_plank_stops_without_a_claim_and_moves_with_one(
    bench, direction, stop_at, word, claimed
):
    assert finished(bench.move_plank("me", direction, stop_at=stop_at)) == f"plank {word}"
    ((request_, fields),) = bench.link.done()
    assert (request_, fields["direction"], fields["fast"]) == ("plank", direction, True)
    assert math.isnan(fields["stop_at"]) and claims(bench) == claimed


@pytest.mark.parametrize(
    ("act", "said"),
    [
        (lambda o: o.set_mode("me", "fly"), "mode 'fly' is not known"),
        (lambda o: o.set_mode("me", "velocity", 101), "velocity is 101 rad/s, must be within"),
        (lambda o: o.set_mode("me", "position", -100_001), "position is -100001 deg, must be"),
        (lambda o: o.move_to("me", 100_001), "position is 100001 deg, must be within -100000"),
        (lambda o: o.set_by_hand("me", "fly", 1), "quantity 'fly' is not known"),
        (lambda o: o.set_by_hand("me", "load_to", 8001), "fz is 8001 N, must be within"),
        (lambda o: o.move_plank("me", 1, True, -1.1), "stop position is -1.1 m, must be within"),
        (lambda o: o.move_plank("me", 1, True, 4.23), "stop position is 4.23 m, must be within"),
        (lambda o: o.load_fit("me", "../x.yaml"), "file '../x.yaml' is outside"),
        (lambda o: o.set_constants("me", {"et_value": 9.0}), "is 9 m, must be within"),
    ],
)  # fmt: skip
def test_what_is_out_of_range_is_not_asked(bench, act, said):
    with pytest.raises(ValueError) as raised:
        finished(act(bench))
    assert said in str(raised.value) and bench.link.done() == []


def test_a_waveform_is_set_and_slip_is_selected(bench):
    values = {"kappa": "0.05"} if "kappa" in vars(WAVEFORMS["step"]()) else {}
    finished(bench.set_waveform("me", "step", values, "1.5", 0.31))
    (first, about), second = bench.link.done()
    assert first == "waveform" and second == ("mode", {"mode": "slip", "value": 0.0})
    assert about == {
        "name": "step", "parameters": list(values), "values": [0.05] * len(values),
        "start_position": 1.5, "effective_rolling_radius": 0.31,
    }  # fmt: skip
    texts = [text for _, text in bench.link.state.log]
    assert texts == ["mode slip", "step from 1.5 m with r_e 0.31 m"]
    with pytest.raises(ValueError, match="effective_rolling_radius"):
        finished(bench.set_waveform("me", "step", values, 1.5, 3.1))
    with pytest.raises(ValueError, match="waveform 'stp' is not known"):
        waveform_of("stp", {})
    with pytest.raises(ValueError, match="kappa"):
        waveform_of("step", {"kappa": "1e7"})


def test_a_recording_has_its_facts_and_its_operator(bench, tmp_path):
    facts = {"tire": "TOY", "fz": 3700.0, "notes": "from the facts"}
    finished(bench.record("me", "run_1", "day", "a note", 1, facts))
    ((request_, fields),) = bench.link.done()
    record = yaml.safe_load(fields.pop("record"))
    assert request_ == "record"
    assert fields == {"name": "run_1", "folder": str(tmp_path / "day"), "at_once": True}
    assert record == {"tire": "TOY", "fz": 3700.0, "name": "run_1", "notes": "a note",
                      "operator": "My name"}  # fmt: skip
    assert (tmp_path / "day").is_dir() and bench.link.state.log[0][1] == "recording run_1"
    finished(bench.record("me", "run_2", "day", "", False, {}))
    assert yaml.safe_load(bench.link.done()[-1][1]["record"])["tire"]


def test_a_measurement_is_a_plan_for_a_folder(bench, tmp_path):
    assert finished(bench.measure("me", {"name": "x"}, "day")) == "measurement begun"
    finished(bench.measure("me", "name: y", "day"))
    assert finished(bench.cancel_measurement("me")) == "measurement is being stopped"
    first, second, third = bench.link.done()
    about = {"folder": str(tmp_path / "day"), "simulated": False}
    assert first == ("measure", {"plan": "name: x\n", **about})
    assert second == ("measure", {"plan": "name: y", **about}) and third == ("cancel", {})


def test_a_fit_is_loaded_by_its_path(bench, tmp_path):
    assert finished(bench.load_fit("me", "fits/a.yaml")) == "parasitic fit a.yaml loaded"
    assert bench.link.done() == [("load_fit", {"file": str((tmp_path / "fits/a.yaml").resolve())})]


def test_the_constants_of_both_nodes_are_shown_and_what_was_set_is_said(bench):
    found = finished(bench.constants())
    assert set(found) == {"et_value", "adapter_thickness", "wheel_camber_deg",
                          "road_camber_offset_deg", "slip_angle_offset_deg"}  # fmt: skip
    said = finished(bench.set_constants("me", {"et_value": 0.05, "slip_angle_offset_deg": 1}))
    assert said == "constants: et_value = 0.05, slip_angle_offset_deg = 1"


def test_a_refusal_is_in_the_log(bench):
    bench.link.reason = "the tire stands"
    with pytest.raises(ValueError, match="the tire stands"):
        finished(bench.quick_stop("me"))
    assert [text for _, text in bench.link.state.log] == ["refused: the tire stands"]


def test_the_log_is_short_and_the_latest_comes_first(bench):
    for number in range(60):
        bench.add_to_log(str(number))
    assert [text for _, text in bench.link.state.log] == [str(n) for n in range(59, 9, -1)]


def test_names_of_pages_are_short(bench):
    bench.charge.release_page("me")
    bench.take_charge("me", "x" * 50)
    assert bench.charge.name == "x" * 40
    bench.take_charge("me", "")
    assert bench.charge.name == "another page"


def test_a_page_gives_charge_back_and_only_its_own(bench):
    finished(bench.release_page("other"))
    assert bench.charge.holder == "me"
    finished(bench.release_page("me"))
    assert bench.charge.holder == "" and bench.link.asked == []


# the nodes of a bench


class Nodes:
    """Processes that start and end when they are told to."""

    made: list[Nodes]

    def __init__(self, setup, log) -> None:
        self.setup, self.log, self.said = setup, log, []
        self.gone: dict[str, int] = {}
        Nodes.made.append(self)

    def start(self) -> None:
        self.said.append("start")

    def stop(self) -> None:
        self.said.append("stop")

    def ended(self) -> dict[str, int]:
        return dict(self.gone)


@pytest.fixture
def host(monkeypatch, tmp_path) -> Host:
    Nodes.made = []
    monkeypatch.setattr(hosts, "BenchProcesses", Nodes)
    monkeypatch.setattr(hosts, "interfaces", lambda: ["eth7"])
    return Host(tmp_path, tmp_path / "log", {"hub": {"a": 1}}, "/bench2")


def test_a_bench_is_started_once_and_ended(host, tmp_path):
    assert not host.running and host.newly_ended() == {}
    tire = simulated_tires()[-1]
    setup = host.start("sim", tire, "", "7", "500", interface="eth9", bus_file="../x")
    (nodes,) = Nodes.made
    assert nodes.setup is setup is host.setup and nodes.log == tmp_path / "log"
    assert (setup.kind, setup.tire, setup.preset, setup.seed) == ("sim", tire, "", 7)
    assert (setup.rate_hz, setup.interface, setup.bus_file) == (500, "", "")
    assert (setup.data, setup.namespace) == (str(tmp_path), "/bench2")
    assert setup.parameters == {"hub": {"a": 1}} and setup.calibration == str(
        book_for(tmp_path).path
    )
    with pytest.raises(ValueError, match="running already"):
        host.start("sim")
    nodes.gone = {"hub": -9}
    assert host.newly_ended() == {"hub": -9} and host.newly_ended() == {}
    nodes.gone = {"hub": -9, "drive": 1}
    assert host.newly_ended() == {"drive": 1}
    assert host.running
    host.stop()
    host.stop()
    assert nodes.said == ["start", "stop"] and not host.running and host.setup is None


@pytest.mark.parametrize(
    ("given", "said"),
    [({"kind": "moon"}, "bench 'moon' is not known"), ({"tire": "x"}, "tire 'x' is not known"),
     ({"preset": "x"}, "preset 'x' is not known"), ({"seed": -1}, "seed is -1, must be"),
     ({"seed": 2**31}, "seed is 2"), ({"rate": 49}, "bus rate is 49 Hz"),
     ({"rate": 1001}, "bus rate is 1001 Hz, must be within 50 .. 1000")],
)  # fmt: skip
def test_a_bench_of_other_values_is_not_started(host, given, said):
    with pytest.raises(ValueError, match=f"^{said}"):
        host.start(**{"kind": "sim", **given})
    assert not host.running and host.setup is None


def test_the_wiring_of_the_lab(host, tmp_path):
    packaged = hosts.config_file("flatplank_hw", "bus/bench.yaml")
    (tmp_path / "own.yaml").write_bytes(Path(packaged).read_bytes())
    found = []
    for given in ("", " bench ", "own.yaml"):
        setup = host.start("lab", interface="eth7", bus_file=given)
        found.append((setup.interface, setup.bus_file))
        host.stop()
    assert found == [("eth7", ""), ("eth7", "bench"),
                     ("eth7", str((tmp_path / "own.yaml").resolve()))]  # fmt: skip
    with pytest.raises(ValueError, match="network interface 'eth9' is not known"):
        host.start("lab", interface="eth9")


def test_without_a_simulator_there_are_the_usual_tire_and_no_presets(monkeypatch):
    assert len(simulated_tires()) == len(set(simulated_tires())) > 1
    assert next(iter(presets().items())) == ("", "none") and len(presets()) > 1

    def none() -> None:
        raise FlatplankError("not installed")

    monkeypatch.setattr(hosts, "simulator", none)
    assert simulated_tires() == ["toyo"] and presets() == {"": "none"}


def test_interfaces_that_can_carry_a_bus(monkeypatch):
    monkeypatch.setattr(hosts.socket, "if_nameindex", lambda: [(1, "lo"), (2, "eth7"), (3, "b")])
    assert interfaces() == ["eth7", "b"]


def test_parameters_in_a_file(tmp_path):
    path = tmp_path / "p.yaml"
    path.write_text("hub:\n  ros__parameters: {a: 1}\ndrive:\n  ros__parameters: {b: x}\n")
    assert read_parameters(path) == {"hub": {"a": 1}, "drive": {"b": "x"}}
    path.write_text("")
    assert read_parameters(path) == {}
    path.write_text("- 1")
    with pytest.raises(ValueError, match="expected node names"):
        read_parameters(path)
    with pytest.raises(ValueError, match=r"gone.yaml: cannot be read \(No such file"):
        read_parameters(tmp_path / "gone.yaml")


# the next run as a plan

RUN = {"kappa": 0.05, "fz": "3700", "step_position": 1.5}


@pytest.mark.parametrize(
    ("more", "block"),
    [
        ({}, {}), ({"start": 2}, {"start": 2}), ({"start": 1.5}, {"start_angle_deg": 60.0}),
        ({"speed": 0.0015}, {"speed": 0.0015}), ({"alpha_deg": 1, "gamma_deg": -2},
         {"alpha_deg": 1.0, "gamma_deg": -2.0}),
        ({"preload": -0.02}, {"step_position": 0.0, "waveform": "double_step",
         "waveform_parameters": {"kappa_1": -0.02, "kappa_2": 0.05, "length": 1.5}}),
    ],
)  # fmt: skip
def test_settings_of_a_proposal_as_a_run_of_a_plan(more, block):
    usual = {"measurement": "slip", "kappa": 0.05, "fz": 3700.0, "step_position": 1.5}
    assert block_of({**more, **RUN}) == {**usual, **block}


def test_a_proposal_is_written_as_a_plan(tmp_path):
    proposal = {"what": "two\n  words", "tire": "TOY", "repeats": "2",
                "runs": [{**RUN, "pressure": 2.5}, {**RUN, "kappa": -0.05}]}  # fmt: skip
    path = write_next(proposal, "camp", tmp_path)
    again = write_next({**proposal, "repeats": None, "what": ""}, "camp2", tmp_path)
    assert path == tmp_path / "plans/next_run_camp.yaml"
    text = path.read_text()
    assert text.startswith("# two words\n")
    plan, second = yaml.safe_load(text), yaml.safe_load(again.read_text())
    assert (plan["name"], plan["tire"]) == ("next_run_camp", "TOY")
    assert [(r["kappa"], r["repeats"]) for r in plan["runs"]] == [(0.05, 2), (-0.05, 2)]
    assert [r["repeats"] for r in second["runs"]] == [3, 3]
    own = {title: p for title, p in plans_of(tmp_path).items() if title.startswith("plans/")}
    assert own == {"plans/next_run_camp.yaml": path, "plans/next_run_camp2.yaml": again}
    with pytest.raises(ValueError, match="names no run"):
        write_next({}, "camp", tmp_path)


# the analysis


class Worker:
    """Answers of an analysis; what it is asked is kept."""

    def __init__(self, **answers: Any) -> None:
        self.asked: list[tuple[str, dict[str, Any]]] = []
        self.answers = answers

    async def ask(self, job: str, progress=None, **about: Any) -> Any:
        self.asked.append((job, about))
        if progress:
            progress(f"{job} goes on", 0.25)
        return self.answers.get(job, {})

    def close(self) -> None:
        self.asked.append(("close", {}))


@pytest.fixture
def service(tmp_path) -> AnalysisService:
    for name in ("x", "y"):
        (tmp_path / name).mkdir()
    made = AnalysisService(tmp_path)
    made.browse_jobs = Worker(identify={"left": {"Fx": [2.0, 0.1]}})
    made.fit_jobs = Worker(
        report={"page": str(tmp_path / "reports/x/index.html")},
        diagnose={"next_run": {"runs": [dict(RUN)], "tire": "TOY"}},
    )
    made.investigating = Worker()
    return made


def test_what_is_asked_about_the_folders(service, tmp_path, monkeypatch):
    day = SimpleNamespace(today=lambda: SimpleNamespace(isoformat=lambda: "2026-11-29"))
    monkeypatch.setattr(services, "date", day)

    async def work() -> Any:
        await service.campaigns()
        await service.runs("x")
        await service.curves("x", ("a.csv", "b.csv"), "fx", "time")
        await service.unloaded_turns()
        return await service.identify("x/turn", "hub_2")

    file = "parasitic/parasitic_hub_2_2026-11-29.yaml"
    assert finished(work()) == (file, {"Fx": [2.0, 0.1]})
    root, x = str(tmp_path), str(tmp_path.resolve() / "x")
    assert service.browse_jobs.asked == [
        ("campaigns", {"root": root}), ("runs", {"folder": x}),
        ("curves", {"folder": x, "files": ["a.csv", "b.csv"], "channel": "fx", "over": "time"}),
        ("turns", {"root": root}),
        ("identify", {"root": root, "bag": "x/turn", "mounting": "hub_2", "date": "2026-11-29",
                      "target": str(tmp_path.resolve() / file)}),
    ]  # fmt: skip


@pytest.mark.parametrize(
    ("ask", "said"),
    [(lambda s: s.runs("z"), "'z': no such folder below the data folder"),
     (lambda s: s.curves("x", ["../y/a"], "fx", "time"), "file '../y/a' is outside"),
     (lambda s: s.identify("../x", "m"), "run '../x' is outside"),
     (lambda s: s.identify("x", "a/b"), "not a name")],
)  # fmt: skip
def test_what_lies_outside_is_not_asked_about(service, ask, said):
    with pytest.raises(ValueError, match=said):
        finished(ask(service))
    assert service.browse_jobs.asked == []


def test_the_end_of_the_service_ends_its_workers(service):
    service.close()
    for worker in (service.browse_jobs, service.fit_jobs, service.investigating):
        assert worker.asked == [("close", {})]


def test_a_search_is_kept_until_the_model_changes(service, tmp_path):
    async def work() -> Path:
        page, other = PageAnalysis(service), PageAnalysis(service)
        await page.open("x")
        await other.open("x")
        assert not page.searched and page.progress == ("", 0.0) and not page.busy
        found = await page.diagnose()
        assert found["next_run"]["tire"] == "TOY" == page.next_run["tire"]
        assert page.searched and other.searched and not page.busy
        assert await other.diagnose() == found
        await page.compare()
        assert page.searched
        path = page.plan_next()
        await other.undo()
        assert not page.searched
        await page.diagnose()
        return path

    assert finished(work()) == tmp_path / "plans/next_run_x.yaml"
    jobs = [job for job, _ in service.fit_jobs.asked]
    assert jobs == ["open", "open", "diagnose", "compare", "undo", "diagnose"]
    model = str(tmp_path.resolve() / "x/model.yaml")
    assert service.fit_jobs.asked[2][1] == {
        "folder": str(tmp_path.resolve() / "x"),
        "model": model,
    }


def test_a_job_tells_how_far_it_is(service):
    async def work() -> None:
        page = PageAnalysis(service)
        going = asyncio.Event()

        async def ask(job: str, progress, **about: Any) -> dict[str, Any]:
            progress("reading", 0.5)
            await going.wait()
            return {}

        service.fit_jobs.ask = ask
        opening = asyncio.create_task(page.open("x"))
        await asyncio.sleep(0)
        await asyncio.sleep(0)
        assert page.busy and page.progress == ("reading", 0.5) and page.campaign == ""
        going.set()
        await opening
        assert not page.busy and page.progress == ("", 0.0)

    finished(work())


# an investigation


def test_a_twin_is_told_its_machine(service, tmp_path):
    (tmp_path / "plant.yaml").write_text("{}")
    seen = []

    class Steps(Worker):
        async def ask(self, job: str, progress=None, **about: Any) -> Any:
            seen.append((job, about))
            progress(job, 0.5)
            waiting = {"plan": "p", "minutes": 6.0} if len(seen) == 1 else None
            return {"entries": [], "waiting": waiting, "left": 5.0, "ended": "e", "reason": "r"}

    service.investigating = Steps()
    charge = SimpleNamespace(require_charge=lambda page: None)
    operator: Any = SimpleNamespace(charge=charge)

    async def scene() -> Investigation:
        of = Investigation(service, operator)
        assert of.progress == ("", 0.0) and not of.asking
        wish = {**WISH, "plant": " plant.yaml ", "seed": "7", "tire": "TOY", "minutes": "30"}
        of.begin("page", wish, each=False)
        while of.busy:
            await asyncio.sleep(0)
        return of

    of = finished(scene())
    folder = str(tmp_path.resolve() / WISH["folder"])
    about = {"folder": folder, "minutes": 30.0, "tire": "TOY"}
    twin = {"preset": "", "plant": str((tmp_path / "plant.yaml").resolve()), "seed": 7}
    assert seen == [
        ("choose_batch", about), ("measure_batch", {**about, "twin": twin}),
        ("choose_batch", about),
    ]  # fmt: skip
    assert of.last_message == "ended: e (r)" and of.folder == WISH["folder"] and not of.each
