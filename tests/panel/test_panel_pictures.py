# SPDX-License-Identifier: Apache-2.0
"""Pictures of every page, kept as build products; keyboard and accessibility on the way.

`FLATPLANK_PICTURES=docs/images ./flatplank test -k pictures` makes those of the documents.
"""

from __future__ import annotations

import os
import shutil
from pathlib import Path

import numpy as np
import pytest
from axe_playwright_python.sync_playwright import Axe
from panel_rig import wait_for

pytestmark = [pytest.mark.browser, pytest.mark.graph, pytest.mark.timeout(300)]

NOT_OURS = {"exclude": [[".q-loading-bar"]]}
"""the framework's bar while something loads"""
RULES = {
    "runOnly": ["wcag2a", "wcag2aa", "wcag21a", "wcag21aa"],
    # it looks past the ground of the framework's buttons; CONTRAST does not
    "rules": {"color-contrast": {"enabled": False}},
}
CONTRAST = """() => {
  const parse = c => c.match(/[\\d.]+/g).map(Number);
  const lum = c => { const [r, g, b] = parse(c).slice(0, 3).map(v => { v /= 255;
    return v <= 0.03928 ? v / 12.92 : ((v + 0.055) / 1.055) ** 2.4; });
    return 0.2126 * r + 0.7152 * g + 0.0722 * b; };
  const ground = e => { for (; e; e = e.parentElement) {
    const c = getComputedStyle(e).backgroundColor;
    const p = parse(c); if (p.length < 4 || p[3] > 0.99) return c; } return 'rgb(255,255,255)'; };
  const bad = [];
  const texts = '.nicegui-label, .q-btn__content, .q-tab__label, .fp-quiet, .fp-value, th, td';
  for (const e of document.querySelectorAll(texts)) {
    if (!e.offsetParent || !e.textContent.trim() || e.closest('[disabled], .disabled')) continue;
    const a = lum(getComputedStyle(e).color), b = lum(ground(e));
    const ratio = (Math.max(a, b) + 0.05) / (Math.min(a, b) + 0.05);
    if (ratio < 4.5) bad.push([e.textContent.trim().slice(0, 40), ratio.toFixed(2)]);
  }
  return bad;
}"""


@pytest.fixture
def pictures(tmp_path) -> Path:
    folder = Path(os.environ.get("FLATPLANK_PICTURES", tmp_path))
    folder.mkdir(parents=True, exist_ok=True)
    return folder


def take(who, path: Path) -> None:
    who.page.mouse.move(5, 5)
    who.page.wait_for_timeout(600)
    who.page.screenshot(path=str(path))
    assert path.stat().st_size > 20_000


def violations(who) -> str:
    """What the accessibility checker finds, as text."""
    found = Axe().run(who.page, NOT_OURS, RULES).response["violations"]
    lines = [
        f"{v['id']}: {n['html'][:150]}: {n['failureSummary']}" for v in found for n in v["nodes"]
    ]
    lines += [f"contrast: {text} {ratio}" for text, ratio in who.page.evaluate(CONTRAST)]
    return "\n".join(lines)


def looked_after(who) -> None:
    """The rules of WCAG 2 A and AA that a program can check: names, roles, contrast, order."""
    found = ""

    def none() -> bool:
        nonlocal found
        found = violations(who)
        return not found

    try:  # what fades in or slides has its contrast when it is there
        wait_for(none, 20.0)
    except AssertionError:
        pytest.fail(found)


def test_bench_by_keyboard(visitor):
    """Charge is taken and given back without a mouse."""
    who = visitor()
    button = who.button("Take charge")
    for _ in range(12):
        who.page.keyboard.press("Tab")
        if button.evaluate("e => e === document.activeElement"):
            break
    who.page.keyboard.press("Enter")
    who.button("Hand back").wait_for()
    who.page.keyboard.press("Enter")
    who.button("Take charge").wait_for()
    looked_after(who)


def test_pictures_of_bench_and_runs(operator, observer, pictures):
    operator.fill("Load [N]", 3700)
    operator.click("Set Load")
    observer.wait(
        lambda: abs(observer.latest["contact"].wrench.force.z - 3700.0) < 100.0, 60.0, "loaded"
    )
    operator.tab("Drive")
    operator.page.wait_for_timeout(1500)
    looked_after(operator)
    take(operator, pictures / "panel-bench.png")
    for tab in ("Measure", "Set-up", "Bus"):
        operator.tab(tab)
        operator.page.wait_for_timeout(300)
        looked_after(operator)
    operator.tab("Machine")
    operator.click("Lift the wheel")
    observer.wait(lambda: observer.latest["hub"].loaded_radius > 0.326, 60.0, "lifted")


def campaign(folder: Path) -> Path:
    """A small made-up campaign: relaxation of first order, three slips, three repeats."""
    import pyarrow as pa
    import pyarrow.parquet as pq
    import yaml

    folder.mkdir(parents=True)
    rng, runs = np.random.default_rng(3), []
    t = np.arange(0.0, 4.1 / 0.03092, 0.02)
    x = 0.03092 * t
    for kappa in (-0.05, 0.02, 0.05):
        for start in (1, 2, 3):
            fx = 40_000 * kappa * (1 - np.exp(-np.clip(x - 1.5, 0, None) / 0.4)) * (x > 1.5)
            name = f"TOY_REL_LNG_{100 * kappa:g}perc_T_p25_Fz3700_{start}.parquet"
            columns = {
                "time": t, "plank_position": x, "plank_velocity": np.full_like(t, 0.03092),
                "wheel_angle": x / 0.31, "wheel_velocity": np.full_like(t, 0.03092 / 0.31),
                "fx": fx + rng.normal(0, 15, len(t)), "fz": np.full_like(t, 3700.0),
            }  # fmt: skip
            pq.write_table(pa.table(columns), folder / name)
            runs.append(
                {"file": name, "tire": "TOY", "kappa": kappa, "fz": 3700.0, "pressure": 2.5,
                 "start": start, "run_index": len(runs), "step_position": 1.5,
                 "effective_rolling_radius": 0.31, "notes": "<b>made up</b>"}
            )  # fmt: skip
    head = {"format": "flatplank-measurement-table/1", "tire": "TOY", "runs": runs}
    (folder / "campaign.yaml").write_text(yaml.safe_dump(head))
    return folder


def test_runs_are_listed_filtered_and_drawn(visitor, data, pictures):
    campaign(data / "made_up")
    try:
        who = visitor()
        who.tab("Runs")
        who.page.get_by_role("button", name="Look for campaigns again").wait_for()
        who.page.wait_for_timeout(1000)
        who.choose("Campaign", "made_up (9 runs)")
        who.said("1-9 of 9")
        who.said("Scatter between repeats")
        drawn = "() => Object.values(window).length && document.querySelectorAll('canvas').length"
        wait_for(lambda: who.page.evaluate(drawn) >= 1, what="a chart")
        assert who.page.locator("td", has_text="<b>made up</b>").count() == 9
        who.page.get_by_label("Filter runs").fill("-5perc")
        who.said("1-3 of 3")
        looked_after(who)
        take(who, pictures / "panel-runs.png")
        assert not who.errors
    finally:
        shutil.rmtree(data / "made_up")
