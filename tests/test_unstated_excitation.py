"""Recordings of which nobody says what moved them, in training and prediction: taken as they are, with a note."""

from dataclasses import replace
from functools import cache
from pathlib import Path

import numpy as np
import pytest
from typer.testing import CliRunner

import hybrid
from fe_models.errors import InputError
from fe_models.files.dataset_file import save_dataset
from fe_models.recordings import Dataset, Recording
from hybrid.commands.app import app
from hybrid.identification.unstated_excitation import unstated_course
from hybrid.training.trainable import as_moved, trainable
from tests.driven_problems import ambient_motion, shown
from tests.hybrid_problems import SENSORS, chain_dataset, off_chain

SAMPLES = 1200  # 23 periods of the lowest mode, which would have died away long before
OPTIONS = ("--window", "80", "--batch", "8", "--first-horizon", "20", "--threads", "1", "--epochs", "1")
TOLD = "nothing is said of what moved it, and it does not die away, so something drives it; where it is a free decay"


@cache
def wind() -> Recording:
    clean = shown(ambient_motion(off_chain(), SAMPLES, 4), SENSORS)
    noise = 0.03 * clean.std(axis=0) * np.random.default_rng(0).standard_normal(clean.shape)
    return Recording("wind", (clean + noise)[None], "test")


def windy(**changes: str) -> Dataset:
    """Return free decays and the wind, of none of which anything is said."""
    free = chain_dataset(realisations=6)
    return replace(free, recordings=(*free.recordings, replace(wind(), **changes)))  # type: ignore[arg-type]


def test_what_does_not_die_away_is_taken_as_ambient_with_a_note() -> None:
    taken = trainable(windy())
    assert [recording.excitation for recording in taken.recordings] == ["free", "free", "free", "ambient"]
    (note,) = taken.notes
    assert note.startswith(f"recording 'wind' is taken as ambient vibration: {TOLD}")
    again = trainable(taken)
    assert again.notes == taken.notes
    assert [recording.excitation for recording in again.recordings] == ["free", "free", "free", "ambient"]


def test_what_is_said_stands() -> None:
    for said in ("free", "ambient"):
        taken = trainable(windy(excitation=said))
        assert taken.recordings[-1].excitation == said
        assert taken.notes == ()


def test_a_record_to_predict_from_is_asked_alone() -> None:
    alone = replace(windy(), recordings=(wind(),))
    taken = as_moved(alone, 0.0392)
    assert taken.recordings[0].excitation == "ambient"
    assert len(taken.notes) == 1
    decay = replace(alone, recordings=(chain_dataset(realisations=6).recordings[0],))
    assert as_moved(decay, 0.0392).notes == ()


def test_of_many_motions_some_are_asked() -> None:
    """The paper's thousand would take minutes."""
    many = replace(wind(), data=np.repeat(wind().data, 300, axis=0))
    assert unstated_course(many, SENSORS, 2.0, None, 0.0392) is not None


def test_nothing_is_learned_from_it_and_the_fault_says_why_and_what_to_do() -> None:
    named = replace(wind(), name="gusts", role="train", excitation="ambient")
    both = windy(role="train")
    with pytest.raises(InputError) as caught:
        trainable(replace(both, recordings=(*both.recordings, named)))
    unsaid, said = caught.value.faults
    assert unsaid.startswith(f"recording 'wind' is ambient vibration ({TOLD} all the same, say excitation = ")
    assert said.startswith("recording 'gusts' is ambient vibration, whose forces nobody knows")
    assert unsaid.endswith('give it role = "test": the motion at all nodes is then estimated from it')
    assert unsaid.split("), ")[1] == said.split("vibration, ")[1]


@pytest.mark.slow
def test_the_commands_estimate_its_motion_as_of_a_stated_one(tmp_path: Path) -> None:
    file = save_dataset(windy(), tmp_path / "data", "four_dof")

    def called(*words: object) -> str:
        answer = CliRunner().invoke(app, [str(word) for word in words])
        assert answer.exit_code == 0, answer.output
        return answer.output

    output = called("train", file, "--out", tmp_path / "run", *OPTIONS)
    assert f"Note: recording 'wind' is taken as ambient vibration: {TOLD}" in output
    assert "Ambient, wind: the motion at all nodes from all samples of the recording" in output
    record = ("--recording", "wind", "--start", "50", "--duration", "20")
    output = called("predict", tmp_path / "run", "--out", tmp_path / "next", "--dataset", file, *record)
    assert f"Note: recording 'wind' is taken as ambient vibration: {TOLD}" in output
    assert "Ambient, wind" in output


@pytest.mark.slow
def test_python_estimates_its_motion_as_of_a_stated_one(tmp_path: Path) -> None:
    trained = hybrid.train(windy(), epochs=1, window=80, batch=8, first_horizon=20)
    unsaid = hybrid.predict(trained, wind(), start=50.0, duration=20.0)
    said = hybrid.predict(trained, replace(wind(), excitation="ambient"), start=50.0, duration=20.0)
    free = hybrid.predict(trained, replace(wind(), excitation="free"), start=50.0, duration=20.0)
    np.testing.assert_array_equal(unsaid.displacement, said.displacement)
    assert np.abs(free.displacement - said.displacement).max() > 0.1  # m: carried on from the first samples alone
    assert unsaid.warnings[0].startswith("recording 'wind' is taken as ambient vibration")
    assert unsaid.warnings[1:] == said.warnings
