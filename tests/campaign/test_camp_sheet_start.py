# SPDX-License-Identifier: Apache-2.0
"""What the pre-flight sheet says is where the search of missing effects starts its fits."""

from __future__ import annotations

import pytest
import yaml

from flatplank_analysis.cli.diagnose import starting_values
from flatplank_analysis.discovery.fit import Term
from flatplank_analysis.discovery.state import term_with
from flatplank_analysis.effects.registry import find
from flatplank_control.calibration.sheet import LINES
from flatplank_control.cli.calibrate import main
from flatplank_data.errors import FlatplankError


def test_the_sheet_reaches_the_search(tmp_path, capsys):
    sheet = tmp_path / "sheet.yaml"
    sheet.write_text("format: flatplank-preflight/1\nreadings: {road_play: 1.15, run_out: null}\n")
    assert main(["sheet", str(sheet)]) == 0
    start = tmp_path / "start.yaml"
    start.write_text(capsys.readouterr().out)
    values = starting_values(str(start))
    assert values == {"road_play": {"gap": pytest.approx(1.15e-3)}}
    effect = find("road_play")
    term = term_with(Term(effect, effect.vector({}), effect.held()), values["road_play"])
    assert term.named()["gap"] == pytest.approx(1.15e-3)


@pytest.mark.parametrize("name", LINES)
def test_every_line_of_the_sheet_is_a_parameter_of_the_library(name):
    line = LINES[name]
    assert line.parameter in [p.name for p in find(line.effect).parameters()]


def test_a_file_without_effects_is_refused(tmp_path):
    path = tmp_path / "no.yaml"
    path.write_text(yaml.safe_dump({"readings": 1}))
    with pytest.raises(FlatplankError, match="no starting values"):
        starting_values(str(path))
