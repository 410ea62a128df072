"""What a report says of a cause, in a sentence with its place, its units and what an engineer must know to act."""

from dataclasses import replace
from types import SimpleNamespace
from typing import Any

import pytest

from fe_models.built_in.four_dof import four_dof
from fe_models.causes import (
    AddedMass,
    Cause,
    CoulombFriction,
    GapStop,
    QuadraticDamper,
    SensorDrift,
    SupportSpring,
    TimeIntegration,
)
from fe_models.causes.wording import at_place, place_words
from fe_models.structure import Support
from hybrid.diagnosis.outcome import named
from hybrid.diagnosis.outcome.findings import Parameter, sentence_of


@pytest.mark.parametrize(
    ("cause", "words"),
    [
        (AddedMass(3, 2.5), "Node 3 carries 2.5 kg more than the model has."),
        (AddedMass(3, -2.5), "Node 3 carries 2.5 kg less than the model has."),
        (CoulombFriction((3,), "x", 2.5), "Dry friction of 2.5 N acts at node 3 in x."),
        (CoulombFriction((3, 4), "x", 2.5), "Dry friction of 2.5 N acts between nodes 3 and 4 in x."),
        (QuadraticDamper((3,), "rz", 2.5), "Drag of 2.5 N m s^2/rad^2 acts at node 3 in rz."),
        (SensorDrift("a1", 2.5), "Sensor a1 drifts by 2.5 of its units a second."),
        (
            SupportSpring(3, "x", 2.5),
            "Node 3 in x is held by 2.5 N/m that the model lacks.",
        ),
        (
            SupportSpring(3, "rz", 2.5),
            "Node 3 in rz is held by 2.5 N m/rad that the model lacks.",
        ),
        (
            GapStop((3,), "y", 0.01, 2.5, -1),
            "A stop of 2.5 N/m acts at node 3 in y beyond a gap of 0.01 m that closes as node 3 moves in -y.",
        ),
        (
            GapStop((3, 4), "x", 0.01, 2.5, 1),
            "A stop of 2.5 N/m acts between nodes 3 and 4 in x beyond a gap of 0.01 m that closes as node 4 moves in +x"
            " against node 3.",
        ),
        (
            TimeIntegration(0.01),
            "The simulation's own step of 0.01 s makes the error: choose a smaller one.",
        ),
    ],
    ids=lambda item: item.kind if isinstance(item, Cause) else "",
)
def test_sentence_names_place_unit_and_side(cause: Cause, words: str) -> None:
    parameters = {
        word: Parameter(float(value), 0.0, cause.units[word])
        for word, value in cause.parameters.items()
        if not isinstance(value, list)
    }
    assert sentence_of(cause, parameters, four_dof()) == words


def test_uncertainty_stands_before_the_unit() -> None:
    sentence = sentence_of(AddedMass(3, 2.5), {"mass": Parameter(2.5, 0.125, "kg")}, four_dof())
    assert "2.5 +- 0.12 kg more" in sentence


def test_the_whole_model_is_no_point() -> None:
    assert at_place({}) == "in the whole model"


def test_a_support_too_soft_is_not_reported_as_stiffness_that_the_model_lacks() -> None:
    design = replace(four_dof(), supports=(Support(1, ("x", "rz")), Support(2, ("y",))))
    spring = {"stiffness": Parameter(5e6, 0.0, "N m/rad")}
    for cause, held in ((SupportSpring(1, "rz", 5e6), True), (SupportSpring(1, "y", 5e6), False)):
        assert ("where the model holds it rigidly" in sentence_of(cause, spring, design)) == held


@pytest.mark.parametrize(
    ("elements", "words"),
    [
        ([4], "element 4"),
        ([1, 2, 3], "each of elements 1 to 3"),
        ([3, 1, 7], "each of elements 1, 3 and 7"),
        ([1, 2, 3, 5, 7, 8], "each of elements 1 to 3, 5 and 7 to 8"),
    ],
)
def test_elements_between_which_there_are_others_are_not_written_as_one_run(elements: list[int], words: str) -> None:
    assert place_words({"elements": elements}) == words


def ruling_of(energies: dict[str, float]) -> Any:
    """Return what a ruling has of fits with the causes in each word, and the energies of their forecasts' errors."""
    fits = {
        word: SimpleNamespace(hypothesis=SimpleNamespace(candidates=tuple(SimpleNamespace(key=key) for key in word)))
        for word in energies
    }
    forecasts = {id(item): SimpleNamespace(energy=energies[word]) for word, item in fits.items()}
    best = max(fits, key=len)
    return SimpleNamespace(
        best=fits[best],
        posterior=SimpleNamespace(fits=tuple(fits.values())),
        found=SimpleNamespace(drawn=forecasts[id(fits[""])], extended=forecasts[id(fits[best])]),
        scorer=SimpleNamespace(forecast=lambda item: forecasts[id(item)]),
    )


def test_what_two_causes_take_away_is_shared_by_shapleys_values() -> None:
    """Without the second one the first makes up for most of it, and the other way round."""
    assert named._taken_away(ruling_of({"": 100.0, "a": 10.0})).tolist() == [90.0]
    alike = named._taken_away(ruling_of({"": 100.0, "a": 12.0, "b": 12.0, "ab": 10.0}))
    assert alike == pytest.approx([45.0, 45.0])
    apart = named._taken_away(ruling_of({"": 100.0, "a": 40.0, "b": 50.0, "ab": 10.0}))
    assert apart == pytest.approx([50.0, 40.0])
