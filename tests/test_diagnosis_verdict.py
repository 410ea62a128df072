"""When forecasts count as being at the noise floor, and when as near it; what only they show."""

from dataclasses import replace

import pytest

from fe_models.blind import BlindConfig, blind_case
from hybrid.diagnosis.diagnosis import diagnose
from hybrid.diagnosis.outcome.verdict import Errors


@pytest.mark.parametrize(
    ("calibrated", "extended", "nothing", "reached"),
    [
        (1.04, 1.0, True, True),  # both within 5 % of the floor, and less than that apart
        (1.04, 0.98, False, True),  # a cause improves on it by more
        (1.20, 1.04, False, True),
        (1.20, 1.10, False, False),
    ],
)
def test_floor_is_reached_within_five_per_cent(
    calibrated: float, extended: float, nothing: bool, reached: bool
) -> None:
    errors = Errors(calibrated, extended, 1.0, 0.0)
    assert (errors.nothing_to_gain, errors.reached) == (nothing, reached)


@pytest.mark.parametrize(("extended", "near"), [(1.1, True), (1.2, False)])
def test_near_the_floor_is_within_fifteen_per_cent(extended: float, near: bool) -> None:
    assert Errors(3.0, extended, 1.0, 0.01).near is near


@pytest.mark.parametrize(
    ("kinds", "words"), [((), "show nothing wrong"), (("sensor_gain",), "show nothing more wrong")]
)
def test_what_only_test_recordings_feel_is_told(kinds: tuple[str, ...], words: str) -> None:
    config = BlindConfig(kinds, size=0.8, train=4, test=2, duration=25.0)
    trained = blind_case(31, config).dataset
    tested = blind_case(31, replace(config, kinds=(*kinds, "cubic_spring"))).dataset
    recordings = [
        two if one.role == "test" else one for one, two in zip(trained.recordings, tested.recordings, strict=True)
    ]
    found = diagnose(replace(trained, recordings=tuple(recordings)))
    assert tuple(finding.cause.kind for finding in found.findings) == kinds
    assert [words in note for note in found.notes].count(True) == 1
