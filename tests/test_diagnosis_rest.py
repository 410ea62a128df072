"""What the rest looks like, where nothing explains it: channels, frequencies, time and recordings."""

from dataclasses import replace

import numpy as np
import pytest

from benchmarks.blind_cases import BlindConfig, blind_case
from fe_models.arrays import FloatArray
from fe_models.causes import StiffnessChange
from fe_models.recordings import Sensor
from hybrid.diagnosis.contest.setting import Setting, setting_of
from hybrid.diagnosis.fitting.least_squares import Fit, fit
from hybrid.diagnosis.outcome.rest import rest_of
from hybrid.diagnosis.outcome.verdict import Verdict
from hybrid.diagnosis.series_diagnosis import diagnose_series as diagnose
from tests.frames import beam, vibrations

RATE = 10.0


@pytest.fixture(scope="module")
def setting() -> Setting:
    """Four recordings of a chain as drawn."""
    return setting_of(blind_case(3, BlindConfig((), train=4, test=1, duration=40.0)).dataset)


def with_rest(setting: Setting, rest: FloatArray) -> Fit:
    """Return the fit of the nominal model to recordings that have a ``rest`` (recording, time, sensor) besides, in
    standard deviations of the noise.
    """
    (batch,) = setting.lengths.whole
    spoilt = replace(batch, data=batch.data + rest * setting.noise_model.sigma)
    found = fit(setting.nominal_hypothesis, setting.nominal_hypothesis.centre, (spoilt,), setting.noise_model)
    assert found is not None
    return found


@pytest.mark.parametrize(
    ("begins", "words"), [(0.0, "early and late as the motion is"), (0.5, "more of it late than early")]
)
def test_rest_is_reported_where_and_when_it_is(setting: Setting, begins: float, words: str) -> None:
    """A knocking at 1.9 Hz, far above all modes, that the second sensor alone shows."""
    (batch,) = setting.lengths.whole
    time = np.arange(batch.samples) / RATE
    motion = np.sqrt(np.mean(np.square(batch.data / setting.noise_model.sigma), axis=(0, 2)))
    rest = np.zeros_like(batch.data)
    rest[..., 1] = motion * np.sin(2 * np.pi * 1.9 * time) * (time >= begins * time[-1])
    description = rest_of(with_rest(setting, rest), np.array([0.2, 1.9]), setting.noise_model)
    assert f"is in {setting.noise_model.sensors[1].name} (" in description
    assert ", near 1.9 Hz (mode 2) (" in description
    assert f", {words}" in description
    assert "most of it in" not in description


def test_a_recording_that_stands_out_is_named(setting: Setting) -> None:
    (batch,) = setting.lengths.whole
    rest = np.zeros_like(batch.data)
    rest[2] = 20 * np.sin(2 * np.pi * 1.9 * np.arange(batch.samples) / RATE)[:, None]
    assert rest_of(with_rest(setting, rest), np.zeros(0), setting.noise_model).endswith(
        f"most of it in {batch.names[2]}"
    )


@pytest.mark.slow
def test_stiffness_of_a_whole_beam_may_be_its_mass() -> None:
    """All of it, as what is not known of free vibrations but their frequencies and shapes."""
    sensors = tuple(Sensor(f"a{node}", node, "y", "acceleration", "m/s^2") for node in (2, 4, 5))
    model = replace(beam(), elements=tuple(replace(e, group="girder") for e in beam().elements))
    softer = model.with_effects(StiffnessChange(tuple(range(1, 7)), 0.8))
    found = diagnose(vibrations(model, softer, sensors, 3))
    assert found.findings[0].cause.location == {"elements": [1, 2, 3, 4, 5, 6]}
    (note,) = (note for note in found.notes if "from their mass" in note)
    times = float(note.split("from their mass: ")[1].split()[0])
    assert times == pytest.approx(1.25, rel=0.05)


@pytest.mark.slow
def test_unexplained_says_what_the_rest_looks_like_and_nothing_of_guesses() -> None:
    found = diagnose(blind_case(122, BlindConfig(("drifting_stiffness",), duration=30.0)).dataset)
    assert found.verdict in (Verdict.UNEXPLAINED, Verdict.PARTLY_EXPLAINED)
    assert found.alike is None
    assert [note for note in found.notes if note.startswith("what is left of the recordings beyond noise is in")]
    assert found.verdict is not Verdict.UNEXPLAINED or not any("too weak to matter" in note for note in found.notes)
