"""Pages in a real browser, Chromium without a screen: nothing goes wrong, nothing is asked for, all is seen."""

from pathlib import Path

import pytest

from fe_models.recordings import Dataset
from hybrid.config import Config
from hybrid.diagnosis.answer import Answer
from hybrid.identification.dataset_comparison import compare_dataset
from hybrid.report.comparison_page import comparison_page
from hybrid.report.diagnosis_page import diagnosis_page
from hybrid.report.rendering import MAX_BYTES, rendered
from hybrid.report.seen import seen_in
from hybrid.report.training_page import training_page
from tests.browser import needs_browser, opened
from tests.pages import SOURCE, answer_by_modes, answer_by_series, chain_dataset, found_in
from tests.test_report_training import data_of_training, trained

# What a reader does: sort, play; then what became of it, told to the frame.
PROBE = """
<script>
requestAnimationFrame = (draw) => setTimeout(() => draw(performance.now()), 16); // which a busy machine keeps waiting
const wrong = [];
addEventListener("error", (event) => wrong.push(event.message));
addEventListener("securitypolicyviolation", (event) => wrong.push(event.violatedDirective + " was refused"));
addEventListener("load", async () => {
  const table = [...document.querySelectorAll("table")].find((one) => one.caption.textContent.includes("Sensors"));
  const first = () => [...table.tBodies[0].rows].map((row) => row.cells[0].textContent);
  const before = first();
  const node = [...table.tHead.rows[0].cells].find((cell) => cell.textContent === "node").querySelector("button");
  node.click();
  node.click();
  const sorted = first();
  const path = document.querySelector(".motion .layer");
  const still = path ? path.getAttribute("d") : "";
  if (path) document.querySelector(".motion button").click();
  let moved = still;
  for (let i = 0; path && i < 100 && moved === still; i += 1) {
    await new Promise((done) => setTimeout(done, 30));
    moved = path.getAttribute("d");
  }
  if (path) document.querySelector(".motion button").click();
  const enlarge = [...document.querySelectorAll("figure button")].find((one) => one.textContent === "Enlarge");
  enlarge.click();
  const dialog = document.querySelector("dialog");
  const large = dialog.open && dialog.querySelector("svg").getBoundingClientRect().height > 200;
  const whole = dialog.querySelector("svg").getAttribute("viewBox");
  [...dialog.querySelectorAll("button")].find((one) => one.textContent === "Closer").click();
  const near = dialog.querySelector("svg").getAttribute("viewBox").split(" ").map(Number);
  dialog.querySelector(".stage").dispatchEvent(new KeyboardEvent("keydown", { key: "0" }));
  const restored = dialog.querySelector("svg").getAttribute("viewBox").split(" ").map(Number).join(" ");
  const back = restored === whole.split(/[ ,]+/).map(Number).join(" ");
  dialog.close();
  const sizes = [...document.querySelectorAll("figure svg")].map((svg) => {
    const box = svg.getBoundingClientRect();
    return [Math.round(box.width), Math.round(box.height)];
  });
  parent.postMessage(JSON.stringify({
    wrong, before, sorted, moves: still !== moved, sizes, large, back,
    closer: Number(whole.split(/[ ,]+/)[2]) / near[2],
    figures: document.querySelectorAll("figure").length,
    width: document.documentElement.scrollWidth, window: innerWidth,
    requests: performance.getEntriesByType("resource").map((entry) => entry.name),
    controls: [...document.querySelectorAll(".motion label")].map((label) => label.textContent.slice(0, 12)),
  }), "*");
});
</script>"""

pytestmark = [
    pytest.mark.slow,
    needs_browser,
]


@pytest.fixture(scope="module")
def data() -> Dataset:
    return chain_dataset()


def page_of(found: Answer, dataset: Dataset) -> str:
    html = rendered(diagnosis_page(found, dataset, seen_in(dataset, found), SOURCE))
    assert len(html.encode()) < MAX_BYTES
    return html


@pytest.mark.parametrize("width", [1440, 390])
@pytest.mark.parametrize("kind", ["modes", "series", "nothing"])
def test_a_page_opens_without_fault_or_request_and_all_is_seen(
    kind: str, width: int, data: Dataset, tmp_path: Path
) -> None:
    found: Answer = answer_by_modes(data, found_in(data))
    if kind != "modes":
        found = answer_by_series(data, *([found_in(data, 0.6)] if kind == "series" else []))
    html = page_of(found, data)
    for word in ("MAC", "CoMAC", "Stabilisation", "backbone", "Power of all channels", "Mode shapes"):
        assert word in html, word
    seen, console = opened(tmp_path, html, width, PROBE)
    assert seen["wrong"] == []
    assert console == ""
    assert seen["requests"] == []
    assert len(seen["sizes"]) == seen["figures"] > 7
    assert all(wide > 200 and high > 60 for wide, high in seen["sizes"])
    assert seen["width"] <= seen["window"] == width  # what is wider scrolls within its own box
    assert seen["sorted"] == seen["before"][::-1]
    assert seen["moves"]
    assert (seen["large"], seen["back"]) == (True, True)
    assert seen["closer"] == pytest.approx(1.5)
    assert seen["controls"] == ["MotionMode 1", "Slow to fast", "Scale"]


def test_the_page_of_a_comparison(data: Dataset, tmp_path: Path) -> None:
    found = comparison_page(compare_dataset(data), SOURCE)
    assert [own.name for own in found.sections] == ["where", "why", "unknown", "assumed"]
    assert found.sentence.startswith("The recordings are of one structure")  # as both are
    html = rendered(found)
    assert all(word in html for word in ("Stabilisation", "Coordinate MAC", "backbone", "Changes of modes"))
    seen, console = opened(tmp_path, html, 390, PROBE)
    assert (seen["wrong"], console, seen["requests"]) == ([], "", [])
    assert len(seen["sizes"]) == seen["figures"] > 5
    assert seen["width"] <= seen["window"] == 390
    assert seen["moves"]


def test_the_page_of_a_training(tmp_path: Path) -> None:
    html = rendered(training_page(data_of_training(), Config(), trained(), SOURCE))
    seen, console = opened(tmp_path, html, 390, PROBE)
    assert (seen["wrong"], console, seen["requests"]) == ([], "", [])
    assert len(seen["sizes"]) == seen["figures"] == 3
    assert seen["width"] <= seen["window"] == 390
    assert seen["moves"]
    assert seen["controls"] == ["Slow to fast", "Scale", "Time"]


def test_a_fault_in_a_page_is_seen(data: Dataset, tmp_path: Path) -> None:
    """The probe tells an error of a program, and a picture from elsewhere."""
    bad = '<img src="picture.png"><script>nowhere();</script></body>'
    html = page_of(answer_by_modes(data), data).replace("</body>", bad)
    seen, console = opened(tmp_path, html, 800, PROBE)
    assert any("nowhere" in line for line in seen["wrong"])
    assert any("img-src" in line for line in seen["wrong"])
    assert "nowhere" in console
