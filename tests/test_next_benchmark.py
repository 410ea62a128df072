"""Cases measured again: what is added comes beside what was there, and shares count what they say."""

from dataclasses import replace

import numpy as np
import pytest

from benchmarks.blind.judging import key_of
from benchmarks.next_measurement.cases import CONFIG, COUNT, OpenCase
from benchmarks.next_measurement.run import shares, text
from benchmarks.next_measurement.trial import Added, Trial, compared, tried
from hybrid.diagnosis.next_measurement.measurements import Measurement

SEED = 1_899_001  # below the benchmark's own


@pytest.fixture(scope="module")
def case() -> OpenCase:
    """A case, without its cause's being looked at."""
    return OpenCase.of(SEED)


def test_an_added_sensor_leaves_the_others_as_they_were(case: OpenCase) -> None:
    node = next(node for node in range(1, COUNT + 1) if node != case.sensors[0].node)
    before, after = case.dataset(), case.dataset(Measurement("sensor", node, "x", "acceleration"))
    assert len(after.sensors) == len(before.sensors) + 1
    for one, other in zip(before.recordings, after.recordings, strict=True):
        np.testing.assert_array_equal(other.data[..., :-1], one.data)
        assert other.data[..., -1].std() > 0


@pytest.mark.parametrize("kind", ["pull", "hammer"])
def test_an_excitation_is_one_recording_more_of_about_the_same_size(case: OpenCase, kind: str) -> None:
    added = Measurement("pull" if kind == "pull" else "hammer", 3, "x")
    before, after = case.dataset(), case.dataset(added)
    np.testing.assert_array_equal(after.recordings[0].data, before.recordings[0].data)
    assert after.sensors == before.sensors
    extra = after.recordings[-1]
    assert extra.role == "train"
    size = extra.data.std() / before.recordings[0].data.std()
    assert 0.05 < size < 5  # starts are random, and a pull wakes slow modes, of which accelerometers show little
    if kind == "hammer":
        (load,) = extra.loads
        assert (load.node, len(load.values)) == (3, CONFIG.campaign.samples)
        quiet = extra.data[0, : int(0.08 * CONFIG.campaign.samples)]
        noise = CONFIG.noise * before.recordings[0].data.std()
        assert quiet.std() < 1.5 * noise  # at rest, but for noise, until it is struck; of 16 values
        assert extra.data.std() > 1.2 * noise
    else:
        assert not extra.loads


def test_shares_count_open_cases_alone() -> None:
    yes, no = Added("a", 0.95, True), Added("b", 0.5, True)
    one = Trial(1, "t", ("a1",), 0.5, True, 0.97, yes, no, 1.0)
    useless = replace(one, promised=None, advised=None, random=None)
    sure = replace(useless, probability=0.95)
    found = shares([one, replace(one, random=yes), useless, sure])
    assert (found["cases left open"].hits, found["cases left open"].count) == (3, 4)
    assert found["of these: nothing said to be of use"].hits == 1
    assert (found["resolved by what was advised"].hits, found["resolved by what was advised"].count) == (2, 2)
    assert (found["resolved by a random addition"].hits, found["named first with a random addition"].hits) == (1, 2)
    assert "| resolved by what was advised | 100 % (2/2) | 34-100 % |" in text([one, replace(one, random=yes)])


def test_a_wrong_name_resolves_nothing_however_sure() -> None:
    assert not Added("a", 0.95, first=False).resolves
    assert not Added("a", 0.85, first=True).resolves


@pytest.mark.slow
def test_a_trial_runs_from_end_to_end() -> None:
    found = tried(SEED)
    assert 0 <= found.probability <= 1
    assert (found.advised is None) == (found.random is None)


def test_all_sensors_together_tell_the_truth(case: OpenCase) -> None:
    """The contest is blind: it sees the dataset alone, and names what was hidden where it is sure to be seen."""
    sensors = tuple(replace(case.sensors[0], name=f"a{node}", node=node) for node in range(1, COUNT + 1))
    posterior, _ = compared(replace(case, sensors=sensors).dataset())
    assert [candidate.key for candidate in posterior.fits[0].hypothesis.candidates] == [key_of(case.cause)]
    assert posterior.probability[0] > 0.99
