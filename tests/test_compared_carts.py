"""Comparisons of small structures: one mode is enough, and a mode whose frequency rises as it decays is one."""

import csv
import io
import re
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from scipy.linalg import eigh

from fe_models.arrays import FloatArray
from fe_models.assembly import linearise
from fe_models.errors import InputError
from fe_models.files.bridge_recordings import RECORDINGS, write_bridge_dataset
from fe_models.files.dataset_file import load_dataset
from fe_models.modes import natural_modes
from fe_models.recordings import Dataset, Recording, Sensor
from fe_models.structure import Damping, PointMass, Spring, Structure
from hybrid.identification.comparison_report import describe_compared
from hybrid.identification.comparison_tables import comparison_csv
from hybrid.identification.config import COMPARISON
from hybrid.identification.damped_cosines import amplitudes_of, columns_of, fit_roots
from hybrid.identification.dataset_comparison import DatasetComparison
from hybrid.identification.free_decay_modes import identify_modes
from hybrid.identification.recording_comparison import compare_recordings
from hybrid.identification.structure_states import Outcome, one_structure, structure_states
from hybrid.report.comparison_page import BEYOND_CHANCE, CHANGED, comparison_page
from hybrid.report.page import Tone
from tests.pages import SOURCE

RATE = 30.0  # Hz
CART = Structure(
    name="one cart",
    nodes=((0.0, 0.0),),
    directions=("x",),
    elements=(Spring((1,), "x", 6.2),),
    point_masses=(PointMass(1, 1.0),),
    damping=Damping(modal_ratios=(0.003,)),
)
CARTS = Structure(
    name="two carts",
    nodes=((0.0, 0.0), (1.0, 0.0)),
    directions=("x",),
    elements=(Spring((1,), "x", 3.12), Spring((1, 2), "x", 31.0), Spring((2,), "x", 3.12)),
    point_masses=(PointMass(1, 0.4), PointMass(2, 1.0)),
    damping=Damping(modal_ratios=(0.003, 0.0015)),
)
SQUARES, SHAPES = eigh([[34.12, -31.0], [-31.0, 34.12]], np.diag([0.4, 1.0]))
OMEGA = np.sqrt(SQUARES)
BRIDGE = Path(__file__).parents[2] / "shared" / "data" / "bridge"


def sensors(count: int) -> tuple[Sensor, ...]:
    return tuple(Sensor(f"x{node}", node, "x", "displacement", "m") for node in range(1, count + 1))


def rising(rise: float, seed: int) -> FloatArray:
    """Two carts (time, sensor) for 8 s, in whole millimetres: their first frequency rises evenly by ``rise``."""
    rng = np.random.default_rng(seed)
    time = np.arange(248) / RATE
    turned = OMEGA * time[:, None]
    turned[:, 0] *= 1 + 0.5 * rise * time / time[-1]  # its rate is 1 + rise at the end
    modes = [0.065, 0.007] * np.exp(-np.array([0.0028, 0.001]) * OMEGA * time[:, None])
    motion = modes * np.cos(turned + rng.uniform(0, 2 * np.pi, 2)) @ SHAPES.T
    noisy = motion + [3e-4, -4e-4] + 2e-4 * rng.standard_normal(motion.shape)
    return np.asarray(np.round(noisy, 3))


@pytest.mark.parametrize("rise", [0.0, 0.015, 0.06])
def test_a_mode_whose_frequency_rises_is_one_line_and_its_rise_in_the_table(rise: float) -> None:
    recordings = tuple(Recording(f"s{seed}", rising(rise, seed)[None]) for seed in range(4))
    compared = compare_recordings(Dataset(CARTS, RATE, sensors(2), recordings))
    for observed in compared.recordings:
        frequencies = observed.identified.frequencies
        # the mean over the recording; whole millimetres leave 0.1 % of a frequency seen for three periods
        assert frequencies[observed.chosen[0]] * 2 * np.pi == pytest.approx(OMEGA[0] * (1 + rise / 2), rel=3e-3)
        assert frequencies[observed.chosen[1]] * 2 * np.pi == pytest.approx(OMEGA[1], rel=2e-3)
        near_first = np.abs(frequencies / frequencies[observed.chosen[0]] - 1) < 0.5
        assert near_first.sum() == 1
        assert observed.identified.ratios[observed.chosen[0]] > 0.001  # 0.0028 is right, none where a pole is split
        curve = observed.backbones[0]
        # spans of one and a half of the three periods: their middles are half of the recording apart
        assert curve.frequency[-1] / curve.frequency[0] - 1 == pytest.approx(rise / 2, abs=2e-3 + 0.1 * rise)


def test_one_mode_is_enough() -> None:
    time = np.arange(500) / RATE
    omega = np.sqrt(6.2)
    parts = [np.exp(-0.003 * omega * time) * np.cos(omega * time + phase) for phase in (0.0, 1.5)]
    noise = 1e-3 * np.random.default_rng(0).standard_normal((2, 500, 1))
    recordings = tuple(
        Recording(name, (part[:, None] + own)[None]) for name, part, own in zip("ab", parts, noise, strict=True)
    )
    compared = compare_recordings(Dataset(CART, RATE, sensors(1), recordings))
    assert compared.followed == (0,)
    for observed in compared.recordings:
        # seven periods, noise of a thousandth: Cramer and Rao allow 1e-4 of a frequency and 2 % of this damping
        assert observed.identified.frequencies[observed.chosen[0]] == pytest.approx(omega / (2 * np.pi), rel=5e-4)
        assert observed.identified.ratios[observed.chosen[0]] == pytest.approx(0.003, rel=0.1)
    assert compared.left.max() < 1e-3
    text = describe_compared(compared)
    assert "Multiples of f1" in text
    assert "| recording | 2 f1 | 3 f1 |" in text


def test_a_mode_is_found_by_its_shape_however_far_its_frequency_is_off() -> None:
    """The structure carries twice its mass: 29 % lower, and a weak line near the model's frequency is not taken."""
    nodes = 4
    chain = Structure(
        name="four carts",
        nodes=tuple((float(node), 0.0) for node in range(nodes)),
        directions=("x",),
        elements=(Spring((1,), "x", 900.0), *(Spring((node, node + 1), "x", 900.0) for node in range(1, nodes))),
        point_masses=tuple(PointMass(node + 1, 1.0) for node in range(nodes)),
    )
    modal = natural_modes(linearise(chain), nodes)
    shapes, time = modal.shapes / np.abs(modal.shapes).max(axis=0), np.arange(600) / RATE
    measured = np.append(modal.frequencies[:2] / np.sqrt(2), modal.frequencies[1])
    waves = np.exp(-0.05 * time[:, None]) * np.cos(2 * np.pi * measured * time[:, None])
    data = waves @ (shapes[:, [0, 1, 1]] * [1.0, 0.8, 0.01]).T
    noise = 1e-4 * np.random.default_rng(0).standard_normal(data.shape)
    compared = compare_recordings(Dataset(chain, RATE, sensors(nodes), (Recording("doubled", (data + noise)[None]),)))
    (observed,) = compared.recordings
    found = [observed.identified.frequencies[observed.chosen[mode]] for mode in (0, 1)]
    np.testing.assert_allclose(found, measured[:2], rtol=1e-3)  # noise of 1e-4 leaves far less
    assert observed.chosen[2:] == (-1, -1)
    assert "(-29.3%)" in describe_compared(compared)


def test_shapes_of_unlike_sensors_are_compared_as_displacements() -> None:
    """The second mode of a displacement and an acceleration, as sensed, has a MAC of about one with the first."""
    time = np.arange(600) / RATE
    waves = [0.05, 0.01] * np.exp(-0.05 * time[:, None]) * np.cos(OMEGA * time[:, None])
    shown = waves @ SHAPES.T
    shown[:, 1] = -(waves * OMEGA**2) @ SHAPES[1]
    mixed = (sensors(2)[0], Sensor("a2", 2, "x", "acceleration", "m/s^2"))
    compared = compare_recordings(Dataset(CARTS, RATE, mixed, (Recording("mixed", shown[None]),)))
    (observed,) = compared.recordings
    # light damping turns the acceleration by twice the damping ratio, 2 %: its square is what the MAC lacks
    assert min(observed.criterion[mode, observed.chosen[mode]] for mode in (0, 1)) > 0.999


def test_a_linear_structure_does_not_look_nonlinear() -> None:
    """Spans in the noise are left out; a difference of two frequencies that is a third's is no combination."""
    rng = np.random.default_rng(0)
    chain = Structure(
        name="three carts",
        nodes=tuple((float(node), 0.0) for node in range(3)),
        directions=("x",),
        elements=(Spring((1,), "x", 430.0), Spring((1, 2), "x", 390.0), Spring((2, 3), "x", 260.0)),
        point_masses=tuple(PointMass(node, 1.0) for node in (1, 2, 3)),
    )
    modal = natural_modes(linearise(chain), 3)
    frequencies = np.array([modal.frequencies[2] - modal.frequencies[1] + 0.05, *modal.frequencies[1:]])
    time = np.arange(1000) / 50.0
    omega = 2 * np.pi * frequencies
    waves = np.exp(-0.02 * omega * time[:, None]) * np.cos(omega * time[:, None])
    clean = (waves * [0.2, 0.6, 0.8]) @ modal.shapes.T
    noisy = clean + 0.02 * clean.std() * rng.standard_normal(clean.shape)
    compared = compare_recordings(Dataset(chain, 50.0, sensors(3), (Recording("linear", noisy[None]),)))
    (observed,) = compared.recordings
    for curve in observed.backbones:
        assert len(curve.frequency) > 2
        assert curve.deviation.max() < 0.005 * curve.frequency[0]
        # linear: no span is further from the first than chance, one in a million at five deviations
        assert np.all(np.abs(curve.frequency - curve.frequency[0]) < 5 * curve.deviation + 1e-3)
    difference = observed.combinations[0]
    assert (difference.first, difference.second, difference.natural, difference.is_peak) == (-1, 1, 0, False)
    text = describe_compared(compared)
    assert "where mode 1 has its own peak" in text
    assert " +- " in text


def test_of_a_mode_that_takes_longer_than_the_recording_nothing_is_said() -> None:
    """Two thirds of a period of the first mode, six of the second."""
    time = np.arange(60) / RATE
    waves = [0.05, 0.05] * np.cos(OMEGA * time[:, None])
    noise = 1e-4 * np.random.default_rng(0).standard_normal((60, 2))
    compared = compare_recordings(
        Dataset(CARTS, RATE, sensors(2), (Recording("short", (waves @ SHAPES.T + noise)[None]),))
    )
    (observed,) = compared.recordings
    assert observed.chosen[0] == -1
    assert observed.chosen[1] >= 0
    assert re.search(r"\| 1 \| [0-9.]+ \| too short \|", describe_compared(compared))
    slow = COMPARISON.min_periods / observed.lasts
    assert all(float(row["frequency_hz"]) > slow for row in csv.DictReader(io.StringIO(comparison_csv(compared))))


@pytest.mark.parametrize(
    ("left", "sentence"),
    [
        (
            [[0.01, 0.1], [0.2, 0.01]],
            "The recordings are of one structure: the modes of each explain 80.0% of",
        ),
        ([[0.01, 0.9], [0.2, 0.01]], "The recordings are not all of one structure: no two agree"),
        ([[0.01, 0.1, 0.9], [0.1, 0.01, 0.8], [0.9, 0.9, 0.01]], "r1, r2 agree, r3 does not"),
        ([[0.01, 0.1], [0.2, 0.7]], "cannot be told: the modes found in r2 leave more than 50%"),
        ([[0.01]], "There is one recording"),
    ],
)
def test_whether_recordings_are_of_one_structure_is_a_sentence(left: list[list[float]], sentence: str) -> None:
    names = [f"r{number + 1}" for number in range(len(left))]
    assert sentence in one_structure(names, np.array(left)).sentence


def test_free_decays_of_different_rates_and_lengths_are_of_one_structure() -> None:
    slow, fast = rising(0.0, 1), rising(0.0, 2)
    assert len(slow) % 2 == 0
    own = Recording("slow", slow[: len(slow) // 2 : 2][None], excitation="free", sampling_rate=RATE / 2)
    data = Dataset(CARTS, RATE, sensors(2), (own, Recording("fast", fast[None], excitation="free")))
    compared = compare_recordings(data)
    assert structure_states(compared).outcome is Outcome.ONE
    assert compared.left.max() < 0.05


@pytest.mark.slow
def test_the_page_of_free_decays_says_one_thing() -> None:
    """What the sentence says, colour, summary and next step say, too: chance does not decide of free decays."""
    recordings = tuple(Recording(f"r{seed}", rising(0.0, seed)[None], excitation="free") for seed in (1, 2))
    data = Dataset(CARTS, RATE, sensors(2), recordings)
    one = compare_recordings(data)
    one = replace(one, changes=tuple(replace(change, chance=0.0) for change in one.changes))
    assert all(change.is_plain for change in one.changes)
    page = comparison_page(DatasetComparison(data, data, one), SOURCE)
    assert page.sentence.startswith("The recordings are of one structure")
    assert (page.tone, page.summary) == (Tone.GOOD, BEYOND_CHANCE)
    assert CHANGED not in page.next
    several = replace(one, left=np.array([[0.0, 0.9], [0.9, 0.0]]))
    page = comparison_page(DatasetComparison(data, data, several), SOURCE)
    assert page.sentence.startswith("The recordings are not all of one structure")
    assert page.tone is Tone.FOUND
    assert CHANGED in page.next


def test_no_mode_of_the_model_is_said() -> None:
    noise = np.random.default_rng(0).standard_normal((500, 2))
    slow = Structure(
        **{**vars(CARTS), "point_masses": (PointMass(1, 40.0), PointMass(2, 100.0))},
    )
    with pytest.raises(InputError, match="none of the model's modes is seen in all recordings"):
        compare_recordings(Dataset(slow, RATE, sensors(2), (Recording("noise", noise[None]),)))


def test_fitted_roots_are_the_least_squares_beside_those_held() -> None:
    """Gradients of the reduced problem against those of the whole, by differences."""
    true, held = np.array([-0.05 + 6.0j, -0.2 + 15.0j]), np.array([-0.1 + 9.0j])
    rng = np.random.default_rng(1)
    weights = rng.standard_normal((6, 3))
    data = columns_of(np.concatenate([true, held]), 300, RATE) @ weights + [1.0, -2.0, 0.5]
    found = fit_roots(data, true * (1 + 0.01j) + 0.02, RATE, held)
    np.testing.assert_allclose(found, true, atol=1e-6)  # exact data: only the solver's own tolerance is left
    noisy = data + 0.1 * rng.standard_normal(data.shape)
    found = fit_roots(noisy, true, RATE, held)

    def error(roots: np.ndarray) -> float:
        both = np.concatenate([roots, held])
        amplitudes, offset = amplitudes_of(noisy, both, RATE)
        fitted = columns_of(both, 300, RATE) @ np.vstack([amplitudes.real, amplitudes.imag]) + offset
        return float(np.sum((noisy - fitted) ** 2))

    least = error(found)
    for step in (1e-2, -1e-2, 1e-2j, -1e-2j):
        for line in range(2):
            assert error(found + step * np.eye(2)[line]) > least


@pytest.mark.skipif(not BRIDGE.is_dir(), reason="the recordings of the laboratory bridge are not here")
def test_the_bridge_s_recordings_show_its_modes(tmp_path: Path) -> None:
    dataset = load_dataset(write_bridge_dataset(BRIDGE, tmp_path, RECORDINGS[1], held_out=None))
    first = next(recording for recording in dataset.recordings if recording.name == "r1")
    modes = identify_modes(first.data[0], dataset.sampling_rate, 1.639, 30.0, 12)
    # as an eigensystem realisation of the first 12 s and eight channels has them; they fall by 0.2-1.6 % with size
    for expected in (3.866, 6.291, 11.51, 12.49, 13.634, 15.05, 17.70):
        assert np.min(np.abs(modes.frequencies / expected - 1)) < 5e-3
    assert modes.left < 0.07
