"""The pages of fleets and watches in a real browser: nothing goes wrong, nothing is asked for, tables sort."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from hybrid.fleet.table import page
from hybrid.monitoring.control_chart import judged
from hybrid.monitoring.observation import Kept, Standing
from hybrid.monitoring.page import watch_page
from hybrid.report.rendering import rendered
from tests.browser import needs_browser, opened
from tests.test_control_chart import FREQUENCIES, history, observed
from tests.test_fleet import rows

# What a reader does: sort the first table by its first column; then what became of it, told to the frame.
PROBE = """
<script>
const wrong = [];
addEventListener("error", (event) => wrong.push(event.message));
addEventListener("securitypolicyviolation", (event) => wrong.push(event.violatedDirective + " was refused"));
addEventListener("load", () => {
  const table = document.querySelector("table");
  table.tHead.rows[0].cells[0].querySelector("button").click();
  parent.postMessage(JSON.stringify({
    wrong,
    names: [...table.tBodies[0].rows].map((row) => row.cells[0].textContent.trim()),
    links: [...document.querySelectorAll("main a")].map((link) => link.getAttribute("href")),
    sizes: [...document.querySelectorAll("figure svg")].map((svg) => svg.getBoundingClientRect().width),
    width: document.documentElement.scrollWidth, window: innerWidth,
    requests: performance.getEntriesByType("resource").map((entry) => entry.name),
  }), "*");
});
</script>"""

pytestmark = [pytest.mark.slow, needs_browser]


@pytest.mark.parametrize("width", [1440, 390])
def test_the_table_of_a_fleet(width: int, tmp_path: Path) -> None:
    seen, console = opened(tmp_path, rendered(page(rows())), width, PROBE)
    assert (seen["wrong"], console, seen["requests"]) == ([], "", [])
    assert seen["names"] == ["bad", "fine", "later", "soft & <b>"]
    assert sorted(seen["links"]) == ["fine/report.html", "soft%20%26%20%3Cb%3E/report.html"]
    assert seen["width"] <= seen["window"] == width


@pytest.mark.parametrize("width", [1440, 390])
def test_the_page_of_a_watch(width: int, tmp_path: Path) -> None:
    usual = history(np.random.default_rng(1), 8)
    found = judged(usual, observed("now", FREQUENCIES * [1, 0.97, 1]))
    now = observed("now", FREQUENCIES * [1, 0.97, 1], Standing.ALARM)
    kept = Kept({}, (*usual, replace(now, limits=found.limits, distance=found.distance, words=found.words)))
    seen, console = opened(tmp_path, rendered(watch_page(kept, "carts", 5)), width, PROBE)
    assert (seen["wrong"], console, seen["requests"]) == ([], "", [])
    assert seen["names"] == ["1", "2", "3"]
    assert len(seen["sizes"]) == 1 and seen["sizes"][0] > 300
    assert seen["width"] <= seen["window"] == width
