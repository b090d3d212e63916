# SPDX-License-Identifier: Apache-2.0
"""The page in a real browser under its content policy, with the token out of the address."""

from __future__ import annotations

from urllib.error import HTTPError
from urllib.parse import urlsplit
from urllib.request import urlopen

import pytest
from panel_rig import wait_for

from flatplank_panel.views.shell import STOP

DRAWN = """() => [...document.querySelectorAll("canvas")].some(c => {
  const data = c.getContext("2d").getImageData(0, 0, c.width, c.height).data;
  return data.some(v => v !== 0);
})"""
"""a chart has drawn something"""


@pytest.mark.browser
def test_the_page_works_under_its_policy(chromium, address: str) -> None:
    context = chromium.new_context()
    page = context.new_page()
    said: list[str] = []
    page.on("console", lambda m: said.append(m.text) if m.type == "error" else None)
    page.on("pageerror", lambda e: said.append(str(e)))
    page.goto(address)
    page.get_by_role("button", name=STOP, exact=True).wait_for()
    assert "token" not in page.url
    (cookie,) = context.cookies()
    assert (cookie["httpOnly"], cookie["sameSite"]) == (True, "Strict")
    for tab in ("Runs", "Catalogue", "Discover", "Investigate", "Bench"):
        page.get_by_role("tab", name=tab, exact=True).click()
    wait_for(lambda: page.evaluate(DRAWN), 30.0, "a chart is drawn")
    page.reload()
    page.get_by_role("button", name=STOP, exact=True).wait_for()
    assert said == []
    context.close()


@pytest.mark.browser
def test_without_the_token_nobody_gets_the_page(address: str) -> None:
    where = urlsplit(address)
    for path in ("/", "/assets/panel.js", "/?token=wrong"):
        with pytest.raises(HTTPError) as refused:
            urlopen(f"{where.scheme}://{where.netloc}{path}")
        refused.value.close()
        assert refused.value.code == 401
        assert refused.value.headers["X-Frame-Options"] == "DENY"
