# SPDX-License-Identifier: Apache-2.0
"""The machine of a challenge on the simulated bench: `--plant CHALLENGE/plant.yaml`."""

from __future__ import annotations

import pytest
from inv_fresh import fresh_challenge, investigated

from flatplank_data.params import ParameterError
from flatplank_sim.plant import PlantConfig
from flatplank_sim.sealed.menu import MENU
from flatplank_sim.sealed.seal import PLANT, seal_plant


@pytest.mark.parametrize("name", sorted(MENU))
def test_what_is_hidden_is_on_the_bench_and_not_in_the_text(name, tmp_path):
    defects = MENU[name].defects(MENU[name].low)
    path = seal_plant({"defects": defects}, tmp_path)
    assert path == tmp_path / PLANT
    assert PlantConfig.load("toyo", file=path) == PlantConfig.load(
        "toyo", overrides={"defects": defects}
    )
    assert not any(word in path.read_text() for word in defects)


def test_a_damaged_one_is_told_in_a_line(tmp_path):
    path = tmp_path / PLANT
    for text in ("sealed: abc\n", "sealed: 7\n"):
        path.write_text(text)
        with pytest.raises(ParameterError, match=r"plant.yaml: sealed: is damaged; make the"):
            PlantConfig.load("toyo", file=path)


@pytest.mark.long
@pytest.mark.timeout(7200)
def test_what_a_fresh_seed_hides_is_found_and_confirmed_on_the_twin(tmp_path):
    challenge = fresh_challenge(tmp_path / "challenge")
    investigated(tmp_path / "data", challenge, "--sim", "--plant", str(challenge / PLANT))
