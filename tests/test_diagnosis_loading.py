"""Known loads whose size is not what the dataset says: no cause of the list, but reported."""

from dataclasses import replace

import pytest

from fe_models.causes import StiffnessChange
from fe_models.recordings import Dataset
from hybrid.diagnosis.contest.growing import reference_fits_of
from hybrid.diagnosis.contest.setting import setting_of
from hybrid.diagnosis.outcome.loading import loading_of
from tests.masts import masts
from tests.masts import recorded as released
from tests.shaken_mast import recorded


def loading_note(dataset: Dataset, factor: float) -> str | None:
    """What is said where the loads that acted were ``factor`` times those of the dataset."""
    recordings = tuple(
        replace(r, loads=tuple(replace(load, values=load.values / factor) for load in r.loads))
        for r in dataset.recordings
    )
    setting = setting_of(replace(dataset, recordings=recordings))
    ground = reference_fits_of(
        setting.nominal_hypothesis, setting.nominal_hypothesis.centre, setting.lengths, setting.noise_model
    )
    assert ground is not None
    return loading_of(ground.whole, setting.noise_model)


@pytest.mark.slow
@pytest.mark.parametrize("factor", [2.0, 0.5, -1.0, 1000.0])
def test_loads_of_another_size_are_reported(factor: float) -> None:
    sentence = loading_note(recorded(), factor)
    assert sentence is not None
    size = float(sentence.removeprefix("all loads times ").split()[0])
    # which 3 % noise tells to a thousandth, and the words to three digits
    assert size == pytest.approx(factor, rel=0.01)


def test_loads_that_are_right_are_not_reported() -> None:
    assert loading_note(recorded(), 1.0) is None


@pytest.mark.slow
def test_a_soft_element_is_no_load() -> None:
    assert loading_note(recorded(StiffnessChange((2,), 0.85)), 1.0) is None


def test_without_loads_nothing_is_reported() -> None:
    assert loading_note(released(masts()), 1.0) is None
