"""Tables of modes without recordings: frequencies alone, a wrong digit, rows exchanged, lines that are no modes."""

from dataclasses import replace
from typing import Literal

import numpy as np
import pytest

import fe_models as fe
import hybrid
from fe_models.arrays import FloatArray
from hybrid.diagnosis.modal_report import VALUES_OFF
from hybrid.diagnosis.modes_and_motion.look import look_at
from hybrid.diagnosis.modes_and_motion.notes import notes_on_modes
from hybrid.diagnosis.modes_and_motion.unmatched_modes import UnmatchedModes, unmatched_modes
from hybrid.diagnosis.outcome.verdict import Verdict
from hybrid.notebook.report import Report
from tests.test_modal_evidence import SENSORS as SENSORS_OF_CHAIN
from tests.test_modal_evidence import chain

FRAME = """
schema = 1
name = "two storeys"
nodes = [[0.0, 0.0], [0.0, 3.0], [0.0, 6.0], [4.0, 6.0], [4.0, 3.0], [4.0, 0.0]]
divisions = 2
damping = { modal_ratios = 0.01 }
sections = [
    { name = "tube", youngs_modulus = 2.1e11, density = 7850.0, shape = "square_tube", side = 0.1, wall = 0.004 },
]
elements = [
    { kind = "beam", through = [1, 2, 3], section = "tube", group = "left columns" },
    { kind = "beam", through = [6, 5, 4], section = "tube", group = "right columns" },
    { kind = "beam", through = [2, 5], section = "tube", group = "first floor" },
    { kind = "beam", through = [3, 4], section = "tube", group = "roof" },
]
point_masses = [{ node = 2, mass = 200 }, { node = 3, mass = 150 }, { node = 4, mass = 150 }, { node = 5, mass = 200 }]
supports = [{ node = 1, directions = ["x", "y", "rz"] }, { node = 6, directions = ["x", "y"] }]
"""
PLACES: tuple[tuple[int, Literal["x", "y", "rz"]], ...] = ((2, "x"), (3, "x"), (2, "rz"), (3, "rz"), (2, "y"))
SENSORS = tuple(
    fe.Sensor(f"a{node}{way}", node, way, "acceleration", "rad/s^2" if way == "rz" else "m/s^2") for node, way in PLACES
)
ERROR = 1e-3  # of frequencies, as far as they are off
MODES = 6


@pytest.fixture(scope="module")
def frame(tmp_path_factory: pytest.TempPathFactory) -> fe.Structure:
    """Two storeys on a fixed and a hinged foot."""
    path = tmp_path_factory.mktemp("frame") / "frame.toml"
    path.write_text(FRAME)
    model = fe.load_model(str(path))
    assert isinstance(model, fe.Structure)
    return model


def table(structure: fe.Structure, *, shapes: bool = True, seed: int = 0) -> list[fe.ModeEstimate]:
    """Return the lowest modes of a structure as somebody lists them: frequencies to a thousandth, shapes to 1 %."""
    rng, linear = np.random.default_rng(seed), fe.linearise(structure)
    modal, dofs = fe.natural_modes(linear, MODES), linear.dofs
    rows = [np.flatnonzero((dofs.node == own.node) & (dofs.direction == own.direction))[0] for own in SENSORS]
    listed = []
    for frequency, shape in zip(modal.frequencies, modal.shapes[rows].T, strict=True):
        seen = shape / np.abs(shape).max() + 0.01 * rng.standard_normal(len(rows))
        listed.append(_listed(frequency * (1 + ERROR * rng.standard_normal()), seen if shapes else None))
    return listed


def _listed(frequency: float, shape: FloatArray | None = None) -> fe.ModeEstimate:
    error = None if shape is None else 0.01
    return fe.ModeEstimate("now", frequency, 2 * ERROR * frequency, 0.01, 0.001, shape, error)


def answer(drawn: fe.Structure, modes: list[fe.ModeEstimate]) -> Report:
    """Return what is said of a table."""
    return hybrid.diagnose(_dataset(drawn, modes))


def _dataset(drawn: fe.Structure, modes: list[fe.ModeEstimate]) -> fe.Dataset:
    return fe.Dataset(drawn, np.inf, SENSORS, (), modes=tuple(modes))


def wrong_digit(modes: list[fe.ModeEstimate]) -> list[fe.ModeEstimate]:
    """Write 5.28 for 6.28 Hz."""
    return [modes[0], replace(modes[1], frequency=modes[1].frequency - 1.0), *modes[2:]]


def exchanged(modes: list[fe.ModeEstimate]) -> list[fe.ModeEstimate]:
    """Give the second mode the third's shape, and the reverse."""
    return [modes[0], replace(modes[1], shape=modes[2].shape), replace(modes[2], shape=modes[1].shape), *modes[3:]]


def with_sums(modes: list[fe.ModeEstimate]) -> list[fe.ModeEstimate]:
    """Return the first two modes, and lines at sums of their frequencies."""
    first, second = (own.frequency for own in modes[:2])
    up_and_down = np.array([0.1, 0.2, -0.5, 1.0, 1.0])
    return [*modes[:2], *(_listed(line, up_and_down) for line in (2 * first, first + second, second - first))]


def unmatched(drawn: fe.Structure, modes: list[fe.ModeEstimate]) -> tuple[tuple[UnmatchedModes, ...], tuple[str, ...]]:
    """Return the modes of a table that the drawn structure does not have, and what is said of them."""
    look = look_at(_dataset(drawn, modes), lambda stage: None)
    found = unmatched_modes(look.measured, look.drawn)
    return found, notes_on_modes(look.measured, look.drawn, found)


@pytest.mark.parametrize("shapes", [False, pytest.param(True, marks=pytest.mark.slow)])
def test_one_wrong_digit_is_no_cause(frame: fe.Structure, shapes: bool) -> None:
    """All other modes say that it is; of frequencies alone two elements could be found that explain it as well."""
    found = answer(frame, wrong_digit(table(frame, shapes=shapes)))
    assert found.verdict is Verdict.NOTHING_WRONG
    assert any("at 5.27" in note and "little weight" in note for note in found.diagnosis.notes), found.diagnosis.notes


@pytest.mark.slow
def test_a_foot_that_gives_is_told_by_frequencies_alone(frame: fe.Structure) -> None:
    """It lowers the first by a fifth: groups of stiffnesses that are all far off explain that, too, less simply."""
    foot = fe.SupportSpring(1, "rz", 2.3e5)
    (first, *others) = answer(frame, table(frame.with_effects(foot), shapes=False)).findings
    assert (first.cause.kind, first.cause.location) == ("support_spring", foot.location)
    assert first.parameters["stiffness"].value == pytest.approx(foot.stiffness, rel=0.1)
    assert first.probability > 0.9
    assert not others


@pytest.mark.slow
def test_what_frequencies_do_not_tell_is_not_called_right() -> None:
    """All are up by a tenth: stiffnesses, or masses, and which of them nobody knows."""
    stiff = [_listed(1.1 * frequency) for frequency in fe.natural_modes(chain()).frequencies]
    found = hybrid.diagnose(fe.Dataset(chain(), np.inf, SENSORS_OF_CHAIN, (), modes=tuple(stiff)))
    assert found.verdict is Verdict.UNEXPLAINED
    assert not found.findings
    assert VALUES_OFF in str(found)


def test_shapes_of_two_modes_that_were_exchanged_are_noticed(frame: fe.Structure) -> None:
    (own,), notes = unmatched(frame, exchanged(table(frame)))
    assert len(own.exchanged) == 2
    assert not own.combinations + own.others
    (note,) = notes
    assert "at 6.27" in note
    assert "26.9" in note
    assert "exchanged" in note


@pytest.mark.slow
def test_a_table_with_exchanged_shapes_says_nothing_of_the_structure(frame: fe.Structure) -> None:
    found = answer(frame, exchanged(table(frame)))
    assert found.verdict is Verdict.UNEXPLAINED
    assert not found.findings


def test_lines_at_sums_of_frequencies_are_no_modes(frame: fe.Structure) -> None:
    """Twice the first, the sum and the difference of the first two, as swaying columns make them move up and down."""
    (own,), (note,) = unmatched(frame, with_sums(table(frame)))
    assert own.combinations == (2, 3, 4)
    assert not own.exchanged + own.others
    assert "no modes" in note


@pytest.mark.slow
def test_a_table_of_few_modes_and_many_sums_says_nothing_against_the_structure(frame: fe.Structure) -> None:
    assert answer(frame, with_sums(table(frame))).verdict is Verdict.NOTHING_WRONG
