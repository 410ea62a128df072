"""How often answers like one were right: which simulated cases they are like, and what a report says of them."""

import json
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from pydantic import TypeAdapter

import fe_models as fe
from benchmarks.certificate.code import INSTALLED
from fe_models.assembly import linearise
from fe_models.base_motion import BaseMotion
from fe_models.recordings import Dataset, Load
from hybrid.diagnosis.outcome.verdict import Verdict
from hybrid.diagnosis.track_record import certified
from hybrid.diagnosis.track_record.certified import Bin, Certified, Column, Share, install, installed_of
from hybrid.diagnosis.track_record.likeness import Kind, column_like, kind_of
from hybrid.diagnosis.track_record.trust import LEAST, trust_in
from hybrid.identification.identification import Identification
from hybrid.report.badge import badge_of
from tests.pages import answer_by_modes, answer_by_series, chain_dataset, found_in
from tests.test_comparison_tables import IDENTIFIED, POLES

ROOT = Path(__file__).parents[1]
NONE = Share(0, 0, (0.0, 1.0))


def column(structure: str, tier: str, excitation: str = "free", acts: str = "all", count: int = 40) -> Column:
    """A column in which nine of ten are right of what is named at 0.9 to 0.97, and all that is named more surely."""
    named = (Bin(0.9, 0.97, Share(9 * count // 10, count, (0.77, 0.96))), Bin(0.97, 1.0, Share(count, count, (0.9, 1))))
    answers = {"nothing_wrong": Share(11, 12, (0.65, 0.99))}
    name = f"{structure}, {tier}, {excitation}, {acts}"
    return Column(name, structure, tier, excitation, acts, 300, 120, named, answers, Share(19, 20, (0.76, 0.99)))


KNOWN = Certified(
    "0123456789abcdef",
    "",
    ("2026-11-28", "2026-11-29"),
    (
        column("four_dof", "exact"),
        column("four_dof", "off"),
        column("four_dof", "exact", "measured"),
        column("bridge", "exact", "ambient", "one"),
        column("bridge", "far", "ambient", "one"),
        column("bridge", "far"),
        column("bridge", "exact", acts="one"),
        column("bridge", "far", acts="one"),
    ),
)


@pytest.fixture(scope="module")
def data() -> Dataset:
    return chain_dataset()


def moved(data: Dataset, **how: object) -> Dataset:
    return replace(data, recordings=tuple(replace(own, **how) for own in data.recordings))  # type: ignore[arg-type]


def test_a_kind_is_what_was_diagnosed_and_what_moved_it(data: Dataset) -> None:
    everywhere = answer_by_series(data, replace(found_in(data), recordings=("before", "after")))
    assert kind_of(data, everywhere) == Kind("four_dof", "off", "free", "all")
    found = answer_by_series(data, replace(found_in(data), recordings=("after",)))
    assert kind_of(data, found) == Kind("four_dof", "off", "free", "one")
    frame = replace(data, model=fe.bridge())
    assert kind_of(frame, found) == Kind("bridge", "off", "free", "one")
    samples = data.recordings[0].data.shape[1]
    loads = (Load(2, "x", np.zeros(samples)),)
    base = (BaseMotion("x", np.zeros(samples)),)
    for how, word in (({"loads": loads}, "measured"), ({"base": base}, "base"), ({"excitation": "ambient"}, "ambient")):
        kind = kind_of(moved(data, **how), found)
        assert isinstance(kind, Kind)
        assert kind.excitation == word


def test_what_the_recordings_show_of_their_forces_counts_before_what_is_stated(data: Dataset) -> None:
    known = {own.name: Identification(IDENTIFIED, POLES, is_ambient=True) for own in data.recordings}
    found = replace(answer_by_series(data, found_in(data)), identified=known)
    kind = kind_of(data, found)
    assert isinstance(kind, Kind)
    assert kind.excitation == "ambient"


def test_groups_that_are_off_make_a_drawing_a_far_one(data: Dataset) -> None:
    found = answer_by_modes(data, found_in(data))
    assert kind_of(data, replace(found, groups=0)) == Kind("four_dof", "off", "free", "all")
    assert kind_of(data, replace(found, groups=1)) == Kind("four_dof", "far", "free", "all")


def test_what_the_certificate_has_no_cases_of_is_said(data: Dataset) -> None:
    found = answer_by_series(data, found_in(data))
    matrices = replace(data, model=linearise(fe.four_dof()))
    mixed = replace(data, recordings=(*data.recordings, replace(data.recordings[0], name="wind", excitation="ambient")))
    listed = replace(data, recordings=())
    swept = moved(data, base=(BaseMotion("x", np.zeros(data.recordings[0].data.shape[1])),))
    for dataset, word in ((matrices, "matrices"), (mixed, "several ways"), (listed, "modes"), (swept, "moving base")):
        trust = trust_in(dataset, found, KNOWN)
        assert trust.right is None
        assert trust.sentence.startswith(
            "How often answers like this one are right is not known yet: the certificate has no "
        )
        assert word in trust.sentence


@pytest.mark.parametrize(
    ("kind", "name"),
    [
        (Kind("four_dof", "off", "free", "all"), "four_dof, off, free, all"),
        (Kind("four_dof", "far", "free", "one"), "four_dof, off, free, all"),  # there is none that is harder
        (Kind("four_dof", "off", "measured", "all"), "four_dof, exact, measured, all"),
        (Kind("bridge", "off", "ambient", "all"), "bridge, far, ambient, one"),  # rather a harder one than an easier
        (Kind("bridge", "off", "free", "one"), "bridge, far, free, one"),
        (Kind("bridge", "exact", "free", "one"), "bridge, exact, free, one"),
    ],
)
def test_the_nearest_column_is_one_that_is_as_hard_where_there_is_one(kind: Kind, name: str) -> None:
    own = column_like(kind, KNOWN)
    assert isinstance(own, Column)
    assert own.name == name


def test_a_cause_is_counted_with_those_named_as_surely(data: Dataset) -> None:
    sure = trust_in(data, answer_by_series(data, found_in(data, 0.995)), KNOWN)
    assert sure.right is not None
    assert (sure.right.hits, sure.right.count) == (40, 40)
    assert sure.sentence == (
        "What was named at 0.97 or more was right 40 of 40 times on simulated chains of four masses in free vibration,"
        " whose drawings were off by 1 %"
    )
    assert sure.line == ("Answers like this one were right in 40 of 40 simulated cases (90 to 100 %, 95 % interval).")
    assert sure.source == "certificate of commit 0123456789ab, 2026-11-29; 120 of 300 cases of this kind have run"
    less = trust_in(data, answer_by_series(data, found_in(data, 0.93)), KNOWN)
    assert less.right is not None
    assert (less.right.hits, less.right.count) == (36, 40)
    certain = trust_in(data, answer_by_series(data, found_in(data, 1.0)), KNOWN)
    assert certain.right == sure.right


def test_few_cases_say_nothing(data: Dataset) -> None:
    few = replace(KNOWN, columns=(column("four_dof", "off", count=LEAST - 1),))
    trust = trust_in(data, answer_by_series(data, found_in(data, 0.995)), few)
    assert trust.right is None
    assert trust.sentence.endswith("the certificate has 9 so far, too few to tell")
    assert trust.line == "How often answers like this one are right is not known yet (9 cases)."
    never = trust_in(data, answer_by_series(data, found_in(data, 0.3)), KNOWN)
    assert never.right is None
    assert never.sentence.endswith("the certificate has none so far")
    assert never.line.endswith("is not known yet (no cases).")


def test_answers_without_a_cause_are_counted_by_their_verdict(data: Dataset) -> None:
    fine = trust_in(data, answer_by_series(data, verdict=Verdict.NOTHING_WRONG), KNOWN)
    assert fine.right is not None
    assert (fine.right.hits, fine.right.count) == (11, 12)
    assert fine.sentence.startswith("The answer that nothing is wrong was right 11 of 12 times on ")
    groups = trust_in(data, replace(answer_by_modes(data, found_in(data)), groups=1), KNOWN)
    assert groups.right is not None
    assert (groups.right.hits, groups.right.count) == (19, 20)


def test_a_badge_says_the_interval_and_that_reality_is_harder(data: Dataset) -> None:
    badge = badge_of(trust_in(data, answer_by_series(data, found_in(data, 0.995)), KNOWN))
    assert (badge.rate, badge.interval) == ("40 of 40", "95 % interval: 90 to 100 %")
    assert badge.sentence.endswith("Simulated structures are simpler than a real one: expect rather less of yours.")
    unknown = badge_of(trust_in(data, answer_by_series(data, found_in(data, 0.3)), KNOWN))
    assert (unknown.rate, unknown.interval) == ("not known yet", "")


def test_what_is_installed_is_that_of_the_documentation(tmp_path: Path) -> None:
    """`python -m scripts.install_certificate` makes it so."""
    numbers = json.loads((ROOT / "docs" / "certificate.json").read_text(encoding="utf-8"))
    assert certified.certified() == installed_of(numbers)
    assert certified.FILE == ROOT / INSTALLED
    written = install(numbers, tmp_path / "certified.json")
    assert TypeAdapter(Certified).validate_json(written.read_bytes()) == certified.certified()
    assert written.read_bytes() == certified.FILE.read_bytes()
