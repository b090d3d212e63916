# SPDX-License-Identifier: Apache-2.0
"""The FMU of a tire, opened and simulated by FMPy: it gives the forces of our own model."""

from __future__ import annotations

import ctypes
import json
import re
import subprocess
import zipfile
from collections.abc import Mapping
from pathlib import Path

import fmpy
import numpy as np
import pytest
from fmpy.fmi3 import FMU3Slave
from fmpy.validation import validate_fmu

from flatplank_analysis.cli.fmu import main as fmu
from flatplank_analysis.fmu.build import compiler_here, this_platform, write_fmu
from flatplank_analysis.fmu.files import IDENTIFIER
from flatplank_analysis.fmu.trace import Trace
from flatplank_analysis.models.base import SPEED, RunInputs
from flatplank_analysis.models.mf_tyre import ContactPointMF, MFTyre
from flatplank_analysis.report.models import MF_MODELS
from flatplank_data.errors import FlatplankError
from flatplank_tire.magic_formula import Coefficients, operating_point
from flatplank_tire.magic_formula import structure as shape
from flatplank_tire.tir import TirFile, parse_tir, shipped_tir, write_tir

MODELS = {"mf": MFTyre, "mf_contact_point": ContactPointMF}
DT = 0.05
"""communication step [s]: 1.5 mm of road"""
TIME = DT * np.arange(401)
FULL = {
    "LATERAL_STIFFNESS": 1e5, "PKY6": -0.9, "PDX3": 2.0, "RBX1": 9.0, "RCX1": 1.0, "RBY1": 9.0,
    "RCY1": 1.0, "RVY1": 0.05, "RVY5": 1.9, "RVY6": 9.0, "QDZ1": 0.1, "QBZ1": 9.0, "QCZ1": 1.1,
    "QDZ6": 0.004, "QBZ9": 12.0, "SSZ1": 0.02, "Q_V1": 7e-4, "PHX1": 1e-3, "RHX1": 0.01,
}  # fmt: skip
OLD = {
    "FITTYP": 6, "PTX1": 1.9, "PTX2": 0.1, "PTX3": -0.2, "PTY1": 2.1, "PTY2": 1.8, "PHY3": 0.02,
}  # fmt: skip
Inputs = Mapping[str, np.ndarray]


def tire(more: Mapping[str, float] = FULL) -> TirFile:
    return shipped_tir().replaced(more)


def old_tire() -> TirFile:
    """Magic Formula 5.2, whose relaxation lengths have coefficients of their own."""
    return tire(FULL | OLD).of_version("5.2")


def inputs(c: Coefficients, **changed: np.ndarray | float) -> Inputs:
    """Signals over TIME; `kappa` becomes the velocity of the wheel."""
    usual = {"fz": 3700.0, "vx": SPEED, "kappa": 0.0, "alpha": 0.0, "gamma": 0.0}
    all_of = {
        name: np.broadcast_to(np.asarray(value, float), TIME.shape)
        for name, value in (usual | {"pressure": c.NOMPRES} | changed).items()
    }
    kappa = all_of.pop("kappa")
    still = radius(c, all_of | {"omega": np.zeros_like(TIME)})
    return all_of | {"omega": (1.0 + kappa) * all_of["vx"] / still}


def radius(c: Coefficients, u: Inputs) -> np.ndarray:
    point = operating_point(c, u["fz"], 0.0, u["alpha"], u["gamma"], u["pressure"], SPEED)
    return shape.effective_radius(c, point, u["omega"])


STEP = np.where(TIME >= 2.0, 1.0, 0.0)
SINE = np.sin(0.8 * TIME)
CASES = {
    "slip step": {"kappa": 0.08 * STEP},
    "braking step, turned": {"kappa": -0.2 * STEP, "alpha": 0.05, "gamma": 0.03},
    "sine of slip": {"kappa": 0.15 * SINE},
    "sine of side slip": {"alpha": 0.1 * SINE, "fz": 3700.0 + 500.0 * np.cos(TIME)},
    "everything": {
        "kappa": 0.05 * SINE, "alpha": 0.05 * np.cos(0.7 * TIME), "gamma": 0.04 * SINE,
        "fz": 3700.0 - 900.0 * SINE, "pressure": 250e3 + 30e3 * SINE,
    },
    "to rest and back": {"vx": SPEED * np.cos(0.3 * TIME), "kappa": 0.02},
    "rest": {"vx": 0.0},
}  # fmt: skip


def ours(law: str, c: Coefficients, u: Inputs, **start: float) -> dict[str, np.ndarray]:
    """Our own model: what the inputs were over the step before a sample has led to it."""
    before = {name: np.concatenate([values[:1], values[:-1]]) for name, values in u.items()}
    dt = np.diff(TIME, prepend=TIME[0])
    travel = np.abs(before["vx"]) * dt
    run = RunInputs(
        travel=travel[None],
        slip_x=((radius(c, before) * before["omega"] - before["vx"]) * dt)[None],
        slip_y=(np.tan(before["alpha"]) * travel)[None],
        **{name: before[name][None] for name in ("fz", "alpha", "gamma", "pressure")},
        start_fx=np.array([start.get("start_fx", 0.0)]),
        start_fy=np.array([start.get("start_fy", 0.0)]),
    )
    found = MODELS[law](c).simulate_all(run)
    return {name: values[0] for name, values in found.items()} | {"re": radius(c, before)}


def theirs(file: Path, u: Inputs, **start: float) -> np.ndarray:
    """FMPy's simulation of the file."""
    signals = np.rec.fromarrays([TIME, *u.values()], names=["time", *u])
    return fmpy.simulate_fmu(
        str(file), input=signals, stop_time=TIME[-1], step_size=DT, output_interval=DT,
        start_values=start, validate=True,
    )  # fmt: skip


def compare(law: str, tir: TirFile, u: Inputs, file: Path, **start: float) -> None:
    own = tir.replaced({k: v for k, v in start.items() if k.startswith("LMU")}).coefficients
    wanted, found = ours(law, own, u, **start), theirs(file, u, **start)
    np.testing.assert_allclose(found["time"], TIME, rtol=1e-12, atol=1e-12)
    for name, values in wanted.items():
        most = np.max(np.abs(values))
        np.testing.assert_allclose(found[name], values, rtol=1e-9, atol=1e-9 * most, err_msg=name)


@pytest.fixture(scope="module")
def files(tmp_path_factory: pytest.TempPathFactory) -> dict[str, Path]:
    folder = tmp_path_factory.mktemp("fmu")
    made = {law: folder / f"{law}.fmu" for law in MODELS}
    for law, path in made.items():
        assert not write_fmu(tire(), law, path).lack
    return made


@pytest.mark.parametrize("case", CASES)
@pytest.mark.parametrize("law", MODELS)
def test_fmpy_computes_the_forces_of_our_model(law: str, case: str, files) -> None:
    tir = tire()
    compare(law, tir, inputs(tir.coefficients, **CASES[case]), files[law])


@pytest.mark.parametrize("law", MODELS)
def test_parameters_start_forces_and_friction(law: str, files) -> None:
    tir = tire()
    u = inputs(tir.coefficients, kappa=0.1 * SINE, alpha=0.02)
    compare(law, tir, u, files[law], start_fx=-60.0, start_fy=150.0)
    compare(law, tir, u, files[law], LMUX=0.6, LMUY=0.7)


@pytest.mark.parametrize("law", MODELS)
def test_a_file_of_5_2_and_one_without_side_force(law: str, tmp_path: Path) -> None:
    bare = shipped_tir().replaced({"PCY1": 0.0, "PDY1": 0.0, "PKY1": 0.0})
    for tir in (old_tire(), shipped_tir(), bare):
        file = tmp_path / "t.fmu"
        write_fmu(tir, law, file)
        u = inputs(tir.coefficients, kappa=0.05 * SINE, gamma=0.02)
        found = theirs(file, u)
        wanted = ours(law, tir.coefficients, u)
        for name in set(found.dtype.names) - {"time"}:
            most = np.max(np.abs(wanted[name]))
            np.testing.assert_allclose(found[name], wanted[name], rtol=1e-9, atol=1e-9 * most)
    assert set(found.dtype.names) == {"time", "fx", "re"}


def test_the_models_are_those_of_a_report() -> None:
    assert MF_MODELS.keys() == MODELS.keys()
    assert all(MF_MODELS[name][1] is model for name, model in MODELS.items())


@pytest.mark.parametrize("law", MODELS)
def test_fmpy_finds_no_fault_in_the_description(law: str, files) -> None:
    assert validate_fmu(str(files[law])) == []
    description = fmpy.read_model_description(str(files[law]), validate=True)
    assert description.fmiVersion == "3.0" and description.coSimulation is not None
    units = {v.name: v.unit for v in description.modelVariables}
    assert units["fz"] == "N" and units["omega"] == "rad/s" and units["mz"] == "N.m"
    assert all(v.description for v in description.modelVariables)


def opened(file: Path, folder: Path) -> FMU3Slave:
    description = fmpy.read_model_description(str(file))
    fmpy.extract(str(file), str(folder))
    return FMU3Slave(
        instanceName="one", guid=description.guid, unzipDirectory=str(folder),
        modelIdentifier=description.coSimulation.modelIdentifier,
    )  # fmt: skip


def stepped(slave: FMU3Slave, begin: float, steps: int) -> list[float]:
    for i in range(steps):
        slave.doStep(begin + i * DT, DT)
    return slave.getFloat64([11, 12, 13, 14])


def test_a_state_is_kept_restored_and_serialized(files, tmp_path: Path) -> None:
    slave = opened(files["mf_contact_point"], tmp_path)
    slave.instantiate()
    slave.enterInitializationMode()
    slave.setFloat64([2, 3, 4], [0.03, 0.11, 0.02])
    slave.exitInitializationMode()
    stepped(slave, 0.0, 20)
    state = slave.getFMUState()
    packed = slave.serializeFMUState(state)
    later = stepped(slave, 1.0, 20)
    slave.setFMUState(state)
    assert stepped(slave, 1.0, 20) == later
    slave.setFMUState(slave.deserializeFMUState(packed))
    assert stepped(slave, 1.0, 20) == later and abs(later[0]) > 100.0
    slave.reset()
    slave.enterInitializationMode()
    slave.exitInitializationMode()
    assert stepped(slave, 0.0, 1)[0] == pytest.approx(0.0, abs=20.0)
    slave.terminate()
    slave.freeInstance()


@pytest.mark.parametrize(
    ("act", "said"),
    [
        (lambda s: s.setFloat64([11], [1.0]), "only inputs and parameters can be set"),
        (lambda s: s.setFloat64([7], [1.0]), "a fixed parameter can be set before"),
        (lambda s: s.setFloat64([1], [float("nan")]), "finite numbers"),
        (lambda s: s.getFloat64([99]), "no variable has this value reference"),
        (lambda s: s.doStep(0.0, -1.0), "step size is negative"),
        (lambda s: s.enterEventMode(), "fmi3EnterEventMode is not supported"),
    ],
)
def test_a_wrong_call_is_refused_with_its_reason(act, said: str, files, tmp_path: Path) -> None:
    slave = opened(files["mf"], tmp_path)
    told: list[str] = []
    slave.instantiate(logMessage=lambda _env, _status, _category, text: told.append(text.decode()))
    slave.enterInitializationMode()
    slave.exitInitializationMode()
    with pytest.raises(Exception, match="fmi3"):
        act(slave)
    assert said in " ".join(told)
    slave.freeInstance()


def test_the_binary_has_every_function_of_the_standard(files, tmp_path: Path) -> None:
    header = Path(fmpy.__file__).parent / "c-code" / "fmi3FunctionTypes.h"
    names = set(re.findall(r"\b(fmi3\w+)TYPE\b", header.read_text()))
    assert len(names) > 70
    platform_name, suffix = this_platform()
    fmpy.extract(str(files["mf"]), str(tmp_path))
    library = ctypes.CDLL(str(tmp_path / "binaries" / platform_name / f"{IDENTIFIER}{suffix}"))
    assert [n for n in sorted(names) if not hasattr(library, n)] == []


def test_the_sources_compile_without_a_warning(files, tmp_path: Path) -> None:
    fmpy.extract(str(files["mf_contact_point"]), str(tmp_path))
    sources = sorted((tmp_path / "sources").glob("*.c"))
    assert [s.name for s in sources] == ["fmi3.c", "tire.c"]
    strict = ["-Wall", "-Wextra", "-Wno-unused-parameter", "-Werror", "-std=c99", "-pedantic"]
    subprocess.run([compiler_here(), *strict, "-fsyntax-only", *map(str, sources)], check=True)


def test_the_same_tire_gives_the_same_file(files, tmp_path: Path) -> None:
    write_fmu(tire(), "mf", tmp_path / "again.fmu")
    assert (tmp_path / "again.fmu").read_bytes() == files["mf"].read_bytes()


def test_the_command_without_a_compiler_writes_the_sources_and_says_so(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    write_tir(tire(), tmp_path / "mine.tir")
    words = [str(tmp_path / "mine.tir"), str(tmp_path / "mine.fmu"), "--json"]
    assert fmu(words) == 0
    told = capsys.readouterr()
    assert json.loads(told.out)["binary"] == this_platform()[0]
    assert "no C compiler" not in told.err
    monkeypatch.setenv("PATH", str(tmp_path))
    monkeypatch.delenv("CC", raising=False)
    assert fmu(words) == 0
    told = capsys.readouterr()
    said = json.loads(told.out)
    assert said["binary"] == "" and "sources/tire.c" in said["files"]
    lines = [line for line in told.err.splitlines() if "no C compiler" in line]
    assert len(lines) == 1 and "apt-get install gcc" in lines[0]
    with zipfile.ZipFile(tmp_path / "mine.fmu") as archive:
        assert archive.read("resources/mine.tir").decode().count("PKX1") == 1
        assert not any(name.startswith("binaries") for name in archive.namelist())


@pytest.mark.parametrize(
    ("without", "law", "said"),
    [
        ("LONGITUDINAL_STIFFNESS", "mf_contact_point", "missing LONGITUDINAL_STIFFNESS.*model mf"),
        ("LONGITUDINAL_STIFFNESS", "mf", "missing LONGITUDINAL_STIFFNESS or PTX1"),
        ("VERTICAL_STIFFNESS", "mf", "missing VERTICAL_STIFFNESS"),
    ],
)
def test_a_tire_that_lacks_a_coefficient_is_refused(
    without: str, law: str, said: str, tmp_path: Path
) -> None:
    text = "[MODEL]\nFITTYP = 61\n[DIMENSION]\nUNLOADED_RADIUS = 0.3\n"
    text += "[OPERATING_CONDITIONS]\nNOMPRES = 2.5e5\n[VERTICAL]\nFNOMIN = 3700\n"
    text += "".join(
        f"{k} = 2e5\n" for k in ("VERTICAL_STIFFNESS", "LONGITUDINAL_STIFFNESS") if k != without
    )
    text += "[LONGITUDINAL_COEFFICIENTS]\nPCX1 = 1.6\nPDX1 = 1\nPKX1 = 25\n"
    with pytest.raises(FlatplankError, match=said):
        write_fmu(parse_tir(text, "bare.tir"), law, tmp_path / "x.fmu")


def test_a_compiler_that_fails_is_told(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    broken = tmp_path / "mycc"
    broken.write_text("#!/bin/sh\necho no such option >&2\nexit 1\n")
    broken.chmod(0o755)
    monkeypatch.setenv("CC", str(broken))
    with pytest.raises(FlatplankError, match="mycc: no such option; name another compiler"):
        write_fmu(tire(), "mf", tmp_path / "x.fmu")


def test_a_choice_that_numpy_cannot_record_is_an_error() -> None:
    x = Trace().variable("in[0]")
    with pytest.raises(TypeError, match=re.escape("np.where")):
        max(x, 0.0)
    with pytest.raises(TypeError):
        np.cumsum(x)
