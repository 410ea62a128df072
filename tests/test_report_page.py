"""The page of a diagnosis: whole in itself, escaped, in order; and what it says of answers of every kind."""

import re
from dataclasses import replace
from pathlib import Path

import pytest
from markupsafe import Markup

import fe_models as fe
import hybrid
from fe_models.files.result_set import ResultSet
from fe_models.recordings import Dataset
from hybrid.diagnosis.answer import Answer
from hybrid.diagnosis.outcome.verdict import Verdict
from hybrid.diagnosis.probability import per_cent
from hybrid.notebook.report import Report
from hybrid.report import rendering
from hybrid.report.answer import SEVERAL, WORSE, facts_of, next_steps, sentence_of, summary_of, verdict_of
from hybrid.report.diagnosis_page import diagnosis_page
from hybrid.report.page import Figure, Page, Section, Tone
from hybrid.report.page_files import save_page
from hybrid.report.provenance import provenance_of
from hybrid.report.rendering import MAX_BYTES, rendered
from hybrid.report.seen import nothing_seen
from hybrid.report.values import measured, percentage, sentence
from hybrid.result_sets import diagnosis_in
from tests.pages import HOSTILE, SOURCE, Reader, answer_by_modes, answer_by_series, chain_dataset, found_in

SECTIONS = ["Where", "How much better", "Why believe it", "What is not known", "What was assumed"]


def page_of(found: Answer, dataset: Dataset) -> str:
    """Return the page without what recordings show by themselves, which takes seconds."""
    return rendered(diagnosis_page(found, dataset, nothing_seen(dataset), SOURCE))


@pytest.fixture(scope="module")
def by_modes() -> str:
    """The page of an answer by modes, of a chain whose names would do harm."""
    dataset = chain_dataset((HOSTILE, "after"), sensor='"><img src=x onerror=alert(1)>', title="<b>chain</b>")
    return page_of(answer_by_modes(dataset, found_in(dataset)), dataset)


@pytest.fixture(scope="module")
def by_series() -> str:
    dataset = chain_dataset()
    return page_of(answer_by_series(dataset, found_in(dataset, 0.6)), dataset)


def headings(html: str, level: str) -> list[str]:
    return list(re.findall(rf"<{level}[^>]*>(.*?)</{level}>", html, re.DOTALL))


@pytest.mark.parametrize("kind", ["by_modes", "by_series"])
def test_a_page_is_whole_in_itself(kind: str, request: pytest.FixtureRequest) -> None:
    """No address of anything outside it, and nothing that the browser would load."""
    html = request.getfixturevalue(kind)
    page = Reader(html)
    assert not re.search(r"https?:|@import|url\((?!#)", html)
    assert not page.named("link")
    for _, attributes in page.elements:
        for name in ("src", "href"):
            value = attributes.get(name) or "#"
            assert value.startswith(("#", "data:image/png;base64,")), (name, value[:40])
    policy = next(own for own in page.named("meta") if own.get("http-equiv") == "Content-Security-Policy")
    assert "default-src 'none'" in (policy["content"] or "")
    assert len(html.encode()) < MAX_BYTES


@pytest.mark.parametrize("kind", ["by_modes", "by_series"])
def test_every_part_is_there_in_order(kind: str, request: pytest.FixtureRequest) -> None:
    html = request.getfixturevalue(kind)
    assert headings(html, "h2") == ["What to do next", *SECTIONS]
    page = Reader(html)
    names = [own.get("id") for own in page.named("section")]
    assert names == ["where", "better", "why", "unknown", "assumed"]
    assert [own.get("href") for own in page.named("a")][1:] == [f"#{name}" for name in names]
    for word in (
        "noise floor",
        "MAC",
        "Mode shapes",
        "What was rejected",
        "States",
        "What may be so instead",
        "SHA-256",
    ):
        assert word in html, word
    ids = [value for _, attributes in page.elements if (value := attributes.get("id"))]
    assert len(ids) == len(set(ids))
    targets = set(re.findall(r"url\(#([^)]*)\)", html)) | {own["href"][1:] for own in page.named("use") if own["href"]}
    assert targets <= set(ids)


def test_figures_and_tables_can_be_heard(by_series: str) -> None:
    """Each drawing has words in its place, each table a caption and headings of columns and rows."""
    page = Reader(by_series)
    assert all(own.get("aria-hidden") == "true" or own.get("aria-label") for own in page.named("svg"))
    drawings = [own for own in page.named("div") if own.get("class") == "drawing"]
    assert len(drawings) >= 2
    assert all(own.get("role") == "img" and len(own.get("aria-label") or "") > 20 for own in drawings)
    assert len(page.named("caption")) == len(page.named("table")) > 8
    assert {own.get("scope") for own in page.named("th")} == {"col", "row"}
    (root,) = page.named("html")
    assert root["lang"] == "en"


def test_names_from_files_are_texts(by_modes: str) -> None:
    """A name that is a program, or closes an attribute, is shown as it is spelt."""
    page = Reader(by_modes)
    assert "alert(" not in "".join(re.findall(r"<script(?: [^>]*)?>(.*?)</script>", by_modes, re.DOTALL))
    assert not page.named("img")
    assert not any(name.startswith("on") for _, attributes in page.elements for name in attributes)
    texts = " ".join(page.texts)
    assert HOSTILE in texts
    assert '"><img src=x onerror=alert(1)>' in texts
    assert "a note of <b>weight</b>".capitalize() in texts


def test_the_answer_is_a_sentence_with_its_probability_and_what_to_do() -> None:
    dataset = chain_dataset()
    sure, unsure = (answer_by_series(dataset, found_in(dataset, own)) for own in (0.97, 0.6))
    said = sentence_of(sure, dataset).replace("\u00a0", " ")
    assert said == "Element 3 has 0.7012 ± 0.0034 times its nominal stiffness (probability: 97 %)."
    assert verdict_of(sure)[1] is Tone.FOUND
    assert "extended_model.toml" in next_steps(sure)[0]
    assert sentence_of(unsure, dataset).startswith("Probably element 3")
    assert verdict_of(unsure)[1] is Tone.OPEN
    assert "accelerometer at node 2 in x would tell" in next_steps(unsure)[1]
    assert dict(facts_of(sure))["forecast error, before → after"] == "0.2000 → 0.0120"
    none = answer_by_modes(dataset, verdict=Verdict.NOTHING_WRONG)
    assert sentence_of(none, dataset).startswith("Nothing is wrong")
    assert verdict_of(none)[1] is Tone.GOOD
    lost = answer_by_modes(dataset, verdict=Verdict.UNEXPLAINED)
    assert verdict_of(lost)[1] is Tone.BAD
    assert "units" in next_steps(lost)[0]


def test_what_acts_in_some_recordings_alone_says_so() -> None:
    dataset = chain_dataset()
    more = fe.Recording("new", dataset.recordings[0].data)
    both = replace(dataset, recordings=(*dataset.recordings, more))
    assert ", in before alone" in sentence_of(answer_by_modes(both, found_in(dataset)), both)
    assert "alone" not in sentence_of(answer_by_modes(dataset, found_in(dataset)), dataset)


@pytest.mark.parametrize(
    ("value", "error", "unit", "words"),
    [
        (0.49987, 0.00171, "N/m^3", "0.4999 ± 0.0017 N/m³"),
        (2.5043e6, 12_300.0, "N/m", "(2.504 ± 0.012) × 10⁶ N/m"),
        (3.4e-5, 9.96e-7, "m", "(34.0 ± 1.0) × 10⁻⁶ m"),
        (0.5, 23.0, "1", "0 ± 23"),
        (12.0, 0.0, "kg", "12 kg"),
    ],
)
def test_uncertainties_have_two_digits(value: float, error: float, unit: str, words: str) -> None:
    assert measured(value, error, unit).replace("\u00a0", " ") == words


def test_nothing_is_said_to_be_certain() -> None:
    assert [per_cent(own) for own in (1.0, 0.997, 0.5, 0.004, 0.0)] == [
        "more than 99.9 %",
        "99.7 %",
        "50 %",
        "0.4 %",
        "less than 0.1 %",
    ]
    assert percentage(0.0) == "less than 0.1 %"


def page_with(sections: tuple[Section, ...]) -> Page:
    return Page("title", "verdict", Tone.GOOD, "sentence", "", (), (), sections, "footer")


def test_a_page_too_large_for_mail_loses_its_largest_figures(monkeypatch: pytest.MonkeyPatch) -> None:
    small, large = (
        Figure(f"{words} figure.", "of nothing", Markup(f"<svg>{'<g></g>' * count}</svg>"), 100.0)
        for words, count in (("The small", 10), ("The large", 1000))
    )
    page = page_with((Section("s", "S", (small, large)),))
    monkeypatch.setattr(rendering, "MAX_BYTES", len(rendered(page).encode()) - 1)
    smaller = rendered(page)
    assert "left out, so that it stays small enough for mail: The large figure." in smaller
    assert "Figure 1.</b> The small figure." in smaller
    monkeypatch.setattr(rendering, "MAX_BYTES", 10)
    with pytest.raises(ValueError, match="no figure to leave out"):
        rendered(page)


def test_inputs_are_named_with_their_hashes(tmp_path: Path) -> None:
    (tmp_path / "data.csv").write_text("1\n")
    (tmp_path / "dataset.toml").write_text('file = "data.csv"\n')
    source = provenance_of(["hybrid-modal", "diagnose", "a b.toml"], tmp_path / "dataset.toml", "seed", 1.0)
    assert source.command == "hybrid-modal diagnose 'a b.toml'"
    assert [own.name for own in source.inputs] == ["dataset.toml", "data.csv"]
    assert source.inputs[1].sha256 == "4355a46b19d348dc2f57c046f8ef63d4538ebb936000f3c9ee954a27460dd865"


def test_a_page_that_fails_costs_nothing_else(tmp_path: Path) -> None:
    results: ResultSet = diagnosis_in(tmp_path)
    with results.replacing() as new:
        (new / "report.json").write_text("{}")

    def fail() -> Page:
        raise ZeroDivisionError("no way")

    (note,) = save_page(results, fail)
    assert (
        note == f"{tmp_path / 'report.html'} could not be made (ZeroDivisionError: no way); the other results are whole"
    )
    assert (tmp_path / "report.json").read_text() == "{}"
    assert save_page(results, lambda: page_with(())) == []
    assert (tmp_path / "report.html").read_text().startswith("<!DOCTYPE html>")
    assert (tmp_path / "report.json").exists()


def test_a_notebook_writes_the_same_page(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    dataset = chain_dataset()
    monkeypatch.setattr("hybrid.report.seen.seen_in", lambda dataset, found: nothing_seen(dataset))
    path = Report(answer_by_modes(dataset, found_in(dataset)), dataset).to_html(tmp_path / "page.html")
    html = path.read_text()
    assert headings(html, "h2") == ["What to do next", *SECTIONS]
    assert "hybrid.diagnose(design, data)" in html
    assert "Files that were read" not in html


def test_a_notebook_asks_for_the_search_by_modes(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    dataset = chain_dataset()
    by_modes, by_look = answer_by_modes(dataset), answer_by_series(dataset)
    home = "hybrid.diagnosis"
    monkeypatch.setattr(f"{home}.modes_and_motion.modal_diagnosis.diagnose_modes", lambda *_: by_modes)
    monkeypatch.setattr(f"{home}.diagnosis.diagnose", lambda *_: by_look)
    monkeypatch.setattr("hybrid.report.seen.seen_in", lambda dataset, found: nothing_seen(dataset))
    assert hybrid.diagnose(dataset, progress=False).diagnosis is by_look
    report = hybrid.diagnose(dataset, by_modes=True, progress=False)
    assert report.diagnosis is by_modes
    assert "hybrid.diagnose(design, data, by_modes=True)" in report.to_html(tmp_path / "page.html").read_text()


def test_kinds_stand_in_words() -> None:
    """A note of the search names kinds as files do."""
    note = "no added sensor tells stiffness_change at element 3 and coulomb_friction at node 1 apart"
    assert sentence(note) == "No added sensor tells stiffness change at element 3 and Coulomb friction at node 1 apart."


def test_the_answer_is_no_surer_than_its_probability() -> None:
    dataset = chain_dataset()
    sure, open_ = (answer_by_series(dataset, found_in(dataset, value)) for value in (0.97, 0.6))
    assert summary_of(sure) == "The simulation is wrong, and the cause is named above."
    assert summary_of(open_) == SEVERAL


def test_causes_and_groups_that_are_off_are_counted_apart() -> None:
    dataset = chain_dataset()
    found = answer_by_modes(dataset, found_in(dataset), found_in(dataset))
    counted = {
        0: "Two things are wrong. First: ",
        1: "One thing is wrong, and one group is off by more than was stated. First: ",
        2: "Two groups are off by more than was stated. First: ",
    }
    for groups, words in counted.items():
        assert sentence_of(replace(found, groups=groups), dataset).startswith(words)
    assert facts_of(found)[0] == ("probability of the first", "97 %")


def test_forecasts_that_get_worse_are_said() -> None:
    dataset = chain_dataset()
    found = answer_by_series(dataset, found_in(dataset))
    worse = replace(found, scores={**found.scores, "extended": found.scores["baseline"]})
    assert WORSE not in next_steps(found) and WORSE not in next_steps(worse)
    worse.scores["baseline"] = {"measured": 0.01, "held_out": None}
    assert WORSE in next_steps(worse)
