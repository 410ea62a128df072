"""Pages as they are seen: laid out as they were looked at, legible in light and dark, figures whole on paper.

A layout is kept as where each box stands, and not as a picture: fonts differ between machines, and a picture would say
that something differs, but not what. Boxes are compared over the window's width, heights among each other, within what
fonts change. Where a layout changes on purpose: look at the page, then UPDATE_LAYOUTS=1 writes the boxes anew.
"""

import json
import os
import re
import shutil
import subprocess
from pathlib import Path

import numpy as np
import pytest
from PIL import Image

from hybrid.config import Config
from hybrid.diagnosis.track_record import trust
from hybrid.identification.dataset_comparison import compare_dataset
from hybrid.report.comparison_page import comparison_page
from hybrid.report.diagnosis_page import diagnosis_page
from hybrid.report.rendering import rendered
from hybrid.report.seen import seen_in
from hybrid.report.training_page import training_page
from tests.browser import needs_browser, opened, printed
from tests.pages import SOURCE, answer_by_modes, chain_dataset, found_in
from tests.test_report_training import data_of_training, trained
from tests.test_track_record import KNOWN

LAYOUTS = Path(__file__).with_name("page_layouts.json")
ACROSS = 0.03  # of the window: how far a box may move sideways, or grow, where a font is wider
UPRIGHT = 0.3  # of its height: a line more or less in a paragraph of three or four
LEAST = 40.0  # px: how much any box may grow: a line or two of text
TEXT, LABEL = 4.5, 3.0  # contrast (WCAG 2.2, AA): of text, and of large text and what stands in drawings
ON_CELLS = ["rgb(254, 254, 254)", "rgb(51, 51, 51)"]  # of labels on the cells of a matrix
PROBE = (
    """
<script>
addEventListener("load", () => {
  const named = (box) => box.id || (box.className.baseVal ?? box.className);
  const every = document.querySelectorAll("header, h1, .facts, nav, section, h2, h3, figure, figure svg, .table");
  const boxes = [...every].map((box) => {
    const at = box.getBoundingClientRect();
    const name = [box.tagName.toLowerCase(), named(box)].filter(Boolean).join(" ");
    return [name, at.left / innerWidth, at.width / innerWidth, at.height];
  });
  const channels = (colour) => (colour.match(/[\\d.]+/g) || []).map(Number);
  const light = ([r, g, b]) => [r, g, b].map((own) => own / 255)
    .map((own) => (own <= 0.04045 ? own / 12.92 : ((own + 0.055) / 1.055) ** 2.4))
    .reduce((sum, own, k) => sum + own * [0.2126, 0.7152, 0.0722][k], 0);
  const behind = (element) => {
    for (let one = element; one; one = one.parentElement) {
      const colour = channels(getComputedStyle(one).backgroundColor);
      if (colour.length === 3 || colour[3] > 0) return colour;
    }
    return [255, 255, 255];
  };
  const cells = [...document.querySelectorAll("svg image[id^=mac]")].map((image) => image.getBoundingClientRect());
  const within = (at) => cells.some((box) => at.left >= box.left && at.right <= box.right && at.top >= box.top
    && at.bottom <= box.bottom); // an image, whose colours are not known here and stay in the dark
  const faint = [];
  for (const element of document.querySelectorAll("body *:not(script):not(style):not(option)")) {
    const own = [...element.childNodes].some((node) => node.nodeType === 3 && node.textContent.trim());
    if (!own || !element.getClientRects().length) continue;
    const drawn = element.closest("svg") !== null;
    const style = getComputedStyle(element);
    if (drawn && within(element.getBoundingClientRect())) {
      if (!ON_CELLS.includes(style.fill)) faint.push([element.textContent.trim(), style.fill]);
      continue;
    }
    const both = [light(channels(drawn ? style.fill : style.color)), light(behind(element))].sort((a, b) => b - a);
    const ratio = Math.round((10 * (both[0] + 0.05)) / (both[1] + 0.05)) / 10;
    if (ratio < (drawn ? LABEL : TEXT)) faint.push([element.textContent.trim().slice(0, 40), ratio]);
  }
  parent.postMessage(JSON.stringify({ boxes, faint }), "*");
});
</script>""".replace("LABEL", str(LABEL))
    .replace("TEXT", str(TEXT))
    .replace("ON_CELLS", json.dumps(ON_CELLS))
)
DARK = "prefers-color-scheme: dark"

pytestmark = [pytest.mark.slow, needs_browser]


@pytest.fixture(scope="module")
def pages() -> dict[str, str]:
    """A page of each kind; a diagnosis' badge is of numbers that stay."""
    data = chain_dataset()
    found = answer_by_modes(data, found_in(data))
    compared = compare_dataset(data)
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(trust, "certified", lambda: KNOWN)
        diagnosed = diagnosis_page(found, data, seen_in(data, found), SOURCE)
    return {
        "diagnosis": rendered(diagnosed),
        "comparison": rendered(comparison_page(compared, SOURCE)),
        "training": rendered(training_page(data_of_training(), Config(), trained(), SOURCE)),
    }


Boxes = list[tuple[str, float, float, float]]


def moved(now: Boxes, before: Boxes) -> list[str]:
    """Return what differs between two layouts, in words."""
    names = [[box[0] for box in boxes] for boxes in (now, before)]
    if names[0] != names[1]:
        first = next((k for k, (a, b) in enumerate(zip(*names, strict=False)) if a != b), min(map(len, names)))
        return [f"box {first} is {names[0][first : first + 2]}, was {names[1][first : first + 2]}"]
    found = []
    for (name, left, width, height), (_, left_before, width_before, height_before) in zip(now, before, strict=True):
        if abs(left - left_before) > ACROSS or abs(width - width_before) > ACROSS:
            found.append(f"{name} stands at {left:.3f}, {width:.3f} wide; was at {left_before:.3f}, {width_before:.3f}")
        if abs(height - height_before) > max(UPRIGHT * height_before, LEAST):
            found.append(f"{name} is {height:.0f} px high, was {height_before:.0f}")
    return found


@pytest.mark.parametrize("width", [1440, 390])
@pytest.mark.parametrize("kind", ["diagnosis", "comparison", "training"])
def test_a_page_is_laid_out_as_it_was_looked_at(pages: dict[str, str], kind: str, width: int, tmp_path: Path) -> None:
    known = json.loads(LAYOUTS.read_text()) if LAYOUTS.exists() else {}
    seen, _ = opened(tmp_path, pages[kind], width, PROBE)
    boxes = [(name, round(left, 3), round(wide, 3), round(high)) for name, left, wide, high in seen["boxes"]]
    if os.environ.get("UPDATE_LAYOUTS"):
        known[f"{kind} {width}"] = boxes
        lines = (f"{json.dumps(name)}: [\n{rows}\n]" for name, own in sorted(known.items()) if (rows := _rows(own)))
        LAYOUTS.write_text("{\n" + ",\n".join(lines) + "\n}\n")
    assert moved(boxes, [tuple(box) for box in known[f"{kind} {width}"]]) == []
    assert seen["faint"] == []


def _rows(boxes: Boxes) -> str:
    return ",\n".join(json.dumps(box) for box in boxes)


@pytest.mark.parametrize("kind", ["diagnosis", "comparison", "training"])
def test_a_page_is_legible_in_the_dark(pages: dict[str, str], kind: str, tmp_path: Path) -> None:
    """The colours of the dark, taken for those of the light: a browser without a screen has no dark of its own."""
    assert DARK in pages[kind]
    html = (
        pages[kind]
        .replace(DARK, "prefers-color-scheme: light")
        .replace("color-scheme: light dark", "color-scheme: dark")
    )
    seen, _ = opened(tmp_path, html, 1440, PROBE)
    assert seen["faint"] == []


def test_what_is_faint_or_moved_is_seen(pages: dict[str, str], tmp_path: Path) -> None:
    html = pages["training"].replace("</style>", "h1 { color: #999; } nav { margin-left: 20%; }</style>", 1)
    seen, _ = opened(tmp_path, html, 1440, PROBE)
    assert [ratio for _, ratio in seen["faint"]] == [2.6]  # of #999 on #f4f5f7
    before = [tuple(box) for box in json.loads(LAYOUTS.read_text())["training 1440"]]
    assert [words.split(" ")[0] for words in moved([tuple(box) for box in seen["boxes"]], before)] == ["nav"]


@pytest.mark.skipif(shutil.which("pdftoppm") is None, reason="needs pdftoppm: apt-get install poppler-utils")
@pytest.mark.parametrize("kind", ["diagnosis", "comparison", "training"])
def test_figures_and_the_answer_are_whole_on_paper(pages: dict[str, str], kind: str, tmp_path: Path) -> None:
    """Each has a background of its own colour, which shows on one sheet of A4."""
    html = pages[kind]
    count = html.count("<figure")
    colours = [f"rgb({200 + number}, 255, {255 - number})" for number in range(count + 1)]  # the last: the answer
    names = [f"figure[data-own='{number}']" for number in range(count)] + ["header"]
    rules = "".join(f"{name} {{ background: {own} !important; }}" for name, own in zip(names, colours, strict=True))
    numbers = iter(range(count))
    html = re.sub("<figure", lambda _: f"<figure data-own='{next(numbers)}'", html)
    html = html.replace("</style>", f"* {{ print-color-adjust: exact; }} {rules}</style>", 1)
    subprocess.run(["pdftoppm", "-r", "40", "-png", printed(tmp_path, html), tmp_path / "sheet"], check=True)
    sheets = [np.asarray(Image.open(path).convert("RGB")) for path in sorted(tmp_path.glob("sheet*.png"))]
    for sheet in sheets:
        high, wide = sheet.shape[:2]
        assert high / wide == pytest.approx(np.sqrt(2), rel=0.01)
    for number, colour in enumerate(colours):
        wanted = np.array([int(part) for part in re.findall(r"\d+", colour)])
        on = [k for k, sheet in enumerate(sheets) if np.sum((sheet == wanted).all(axis=2)) > 20]
        assert len(on) == 1, f"{names[number]} is on sheets {on} of {len(sheets)}"
