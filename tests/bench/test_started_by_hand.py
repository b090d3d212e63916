# SPDX-License-Identifier: Apache-2.0
"""A node started by hand (`ros2 run`) has the parameters that a launched bench gives it."""

from importlib import import_module

import pytest

from flatplank_control.bench.setup import DRIVEN, BenchSetup
from flatplank_data.params import parameter_infos
from flatplank_hw.share import packaged_parameters

ONLY_THE_LAUNCH_KNOWS = {
    "interface": "the bus node refuses to start without it",
    "bus_file": "the wiring of the machine",
    "constants_from": "trouble not_calibrated",
    "fifo_priority": "real time is for a bus of frames alone",
    "axes": "which axes have a drive",
    "driven_axes": "which axes have a drive",
    "driven_plank": "which axes have a drive",
}
"""parameter -> why a node by hand has another value"""


@pytest.mark.parametrize("kind", ["sim", "lab"])
def test_defaults_are_those_of_a_launched_bench(kind):
    setup = BenchSetup(kind=kind, axes=tuple(DRIVEN), interface="eth7")
    differ = {}
    for node in setup.nodes():
        infos = parameter_infos(import_module(node.module).NODE.PARAMETERS)
        by_hand = {info.name: info.default for info in infos}
        by_hand |= packaged_parameters(node.package, node.name)
        for name, value in setup.of(node).items():
            same = by_hand.get(name) in (value, tuple(value) if isinstance(value, list) else value)
            if not same and name not in ONLY_THE_LAUNCH_KNOWS:
                differ[node.name, name] = by_hand.get(name), value
    assert differ == {}


def test_constants_have_an_origin_where_somebody_knows_it(tmp_path):
    def origin(**setup):
        bench = BenchSetup(**setup)
        (hub,) = (bench.of(n) for n in bench.nodes() if n.name == "measurement_hub")
        return hub.get("constants_from", "")

    assert origin(kind="lab", calibration=str(tmp_path / "none.yaml")) == ""
    assert origin(kind="sim") == origin(kind="emulated") == "the simulated machine"
