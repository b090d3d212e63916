# SPDX-License-Identifier: Apache-2.0
"""Pictures of a page, and what an accessibility checker says of it."""

from __future__ import annotations

from pathlib import Path

import pytest
from axe_playwright_python.sync_playwright import Axe
from panel_rig import wait_for

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
