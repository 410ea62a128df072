"""What recordings show by themselves: modes, backbones, combinations, and whether they are of one structure."""

import csv
import json
import re
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from typer.testing import CliRunner

from fe_models.arrays import FloatArray
from fe_models.assembly import linearise
from fe_models.built_in.bridge import bridge
from fe_models.errors import InputError
from fe_models.files.bridge_recordings import bridge_sensors
from fe_models.files.dataset_file import save_dataset
from fe_models.modes import natural_modes
from fe_models.recordings import Dataset, Recording
from hybrid.identification import recording_comparison
from hybrid.identification.agreement import shares_unexplained, window_of
from hybrid.identification.backbone import backbone_of, standard_deviations
from hybrid.identification.combinations import combinations_of
from hybrid.identification.damped_cosines import fit_roots
from hybrid.identification.free_decay_modes import identify_modes
from hybrid.identification.recording_comparison import compare_recordings
from scripts.compare_recordings import app
from tests.blank_sheets import blank_sheets

RATE, SAMPLES = 100.0, 2000
TIME = np.arange(SAMPLES) / RATE
SHAPES = np.array([[1.0, 0.5, -0.2], [-0.3, 1.0, -0.4], [0.1, 0.6, 1.0]])


def decay(frequencies: list[float], ratios: list[float], sizes: list[float], shapes: FloatArray) -> FloatArray:
    """Return damped cosines (time, sensor) with ``shapes`` (mode, sensor) and a little noise."""
    omega = 2 * np.pi * np.array(frequencies)
    waves = np.exp(-np.array(ratios) * omega * TIME[:, None]) * np.cos(omega * TIME[:, None] + 0.3)
    noise = 1e-3 * np.random.default_rng(0).standard_normal((SAMPLES, shapes.shape[1]))
    return np.asarray((waves * sizes) @ shapes + noise)


def test_lines_come_back_with_frequency_damping_and_shape() -> None:
    identified = identify_modes(
        decay([3.9, 6.3, 7.1], [0.004, 0.003, 0.01], [1.0, 0.6, 0.2], SHAPES), RATE, 3.9, 30.0, count=3
    )
    # 2000 samples of noise a thousandth as large as the strongest mode leave errors near 1e-5 (Cramer and Rao)
    np.testing.assert_allclose(identified.frequencies, [3.9, 6.3, 7.1], rtol=1e-4)
    np.testing.assert_allclose(identified.ratios, [0.004, 0.003, 0.01], rtol=0.02)
    np.testing.assert_allclose(identified.shapes.T, SHAPES, atol=0.02)
    assert identified.left < 1e-3


@pytest.mark.parametrize("seed", range(4))
def test_modes_that_nothing_tells_apart_do_not_spoil_the_others(seed: int) -> None:
    """Three lie within a thousandth: the pole that stands for them moves in no phase, and holds much of the energy."""
    rng = np.random.default_rng(seed)
    frequencies, phases = np.array([3.9, 4.0, 6.3, 6.302, 6.304, 7.4]), np.array([0.3, 1.0, 0.0, 2.1, 4.2, 0.5])
    roots = 2 * np.pi * frequencies * (-0.01 + 1j * np.sqrt(1 - 0.01**2))
    data = np.real(np.exp(TIME[:, None] * roots + 1j * phases) @ rng.standard_normal((6, 5)))
    found = identify_modes(data + 3e-3 * rng.standard_normal(data.shape), RATE, 3.9, 30.0)
    others = np.abs(found.frequencies - 6.302) > 0.1
    np.testing.assert_allclose(found.frequencies[others], [3.9, 4.0, 7.4], rtol=1e-4)
    assert np.all(np.abs(found.ratios[others] - 0.01) < 4 * found.ratio_errors[others])  # one of 16,000 is off by more
    assert found.left < 1e-3


def test_standard_deviations_of_frequency_and_damping_are_those_of_many_recordings() -> None:
    """Two channels of unequal noise, another mode beside; every recording says the same of itself."""
    samples, rate, root = 300, 50.0, complex(-0.15, 2 * np.pi * 3.9)
    other = np.array([complex(-0.1, 2 * np.pi * 6.3)])
    time = np.arange(samples) / rate
    clean = np.real(np.exp(root * time)[:, None] * [1.0, 0.5j] + np.exp(other[0] * time)[:, None] * [0.3, 0.4])
    rng = np.random.default_rng(3)
    found, said = [], []
    for _ in range(200):
        data = clean + rng.standard_normal(clean.shape) * [0.02, 0.08]
        fitted = fit_roots(data, np.array([root]), rate, other)[0]
        found.append([abs(fitted) / (2 * np.pi), -fitted.real / abs(fitted)])
        said.append(standard_deviations(data, complex(fitted), other, rate))
    # the scatter of 200 is itself known to 1 / sqrt(400), 5 %; three of these
    np.testing.assert_allclose(np.mean(said, axis=0), np.std(found, axis=0), rtol=0.15)
    assert np.all(np.std(said, axis=0) < 0.1 * np.mean(said, axis=0))  # of 600 residuals: about 4 %


@pytest.mark.parametrize("softening", [0.0, 0.02])
def test_backbone_shows_how_frequency_falls_with_amplitude(softening: float) -> None:
    amplitude = np.exp(-0.1 * TIME)
    phase = 2 * np.pi * np.cumsum(3.9 * (1 - softening * amplitude**2)) / RATE
    other = 0.5 * np.cos(2 * np.pi * 6.3 * TIME)
    data = np.outer(amplitude * np.cos(phase), [1.0, 0.5]) + np.outer(other, [-0.5, 1.0])
    modes = identify_modes(data, RATE, 3.9, 30.0, count=2)
    curve = backbone_of(data, modes, 0, RATE)
    expected = 3.9 * (1 - softening * curve.amplitude**2)
    # the change of amplitude within a span of time blurs its mean by a few per cent of the fall of 0.08 Hz
    np.testing.assert_allclose(curve.frequency, expected, atol=2e-3)
    assert np.ptp(curve.frequency) > 0.04 or softening == 0
    # the band takes a little where the frequency moves
    np.testing.assert_allclose(curve.ratio, 0.1 / (2 * np.pi * curve.frequency), rtol=0.05)


def test_a_force_that_is_not_linear_leaves_sums_and_differences() -> None:
    linear = decay([3.9, 6.3], [0.004, 0.003], [1.0, 0.6], SHAPES[:2])
    bent = linear + 0.02 * linear**2
    assert max(item.over for item in combinations_of(linear, RATE, (3.9, 6.3))) < 20  # noise, and feet of the peaks
    found = {(item.first, item.second): item for item in combinations_of(bent, RATE, (3.9, 6.3))}
    for pair in ((-1, 1), (2, 0), (1, 1)):
        assert found[pair].over > 100
        assert abs(found[pair].found - found[pair].expected) < 0.06  # the resolution of 20 s


def test_another_structure_leaves_most_unexplained() -> None:
    same = [decay([3.9, 6.3], [0.004, 0.003], sizes, SHAPES[:2]) for sizes in ([1.0, 0.6], [0.3, -0.9])]
    other = decay([3.7, 5.9], [0.004, 0.003], [1.0, 0.6], SHAPES[1:])
    recordings = [*same, other]
    identified = [identify_modes(data, RATE, 3.9, 30.0, count=2) for data in recordings]
    window = window_of(identified, [len(data) / RATE for data in recordings])
    left = shares_unexplained(identified, recordings, [RATE] * 3, window)
    assert left[:2, :2].max() < 0.01
    assert left[2, 2] < 0.01
    assert min(left[2, :2].min(), left[:2, 2].min()) > 0.5


@pytest.fixture
def dataset() -> Dataset:
    """Two decays in the bridge's modes 2 and 3, mode 2 12 % above the nominal frequency, and one of mode 3 lower."""
    model = linearise(bridge())
    sensors = bridge_sensors()
    modal = natural_modes(model, 3)
    shapes = modal.shapes[[model.dofs.row(s.node, str(s.direction)) for s in sensors]][:, 1:].T
    shapes = shapes / np.abs(shapes).max(axis=1, keepdims=True)
    f2, f3 = 1.12 * modal.frequencies[1], modal.frequencies[2]
    tones = {"a": ([f2, f3], [1.0, 0.6]), "b": ([f2, f3], [0.4, 0.8]), "c": ([f2, 0.93 * f3], [1.0, 0.6])}
    recordings = tuple(
        Recording(name, decay(list(both), [0.004, 0.003], sizes, shapes)[None], "train")
        for name, (both, sizes) in tones.items()
    )
    return Dataset(bridge(), RATE, sensors, recordings, lowpass=30.0)


def test_modes_are_found_by_shape_and_the_odd_recording_stands_out(dataset: Dataset) -> None:
    compared = compare_recordings(dataset)
    assert compared.followed == (1, 2)
    for observed, third in zip(compared.recordings, (1.0, 1.0, 0.93), strict=True):
        seen = [observed.identified.frequencies[observed.chosen[mode]] for mode in compared.followed]
        np.testing.assert_allclose(seen / compared.nominal[1:3], [1.12, third], rtol=1e-3)
        assert min(observed.criterion[mode, observed.chosen[mode]] for mode in compared.followed) > 0.999
    assert max(compared.left[0, 1], compared.left[1, 0]) < 0.05 < 0.1 < min(compared.left[2, :2])


@blank_sheets(".svg")
def test_script_prints_tables_and_draws(dataset: Dataset, tmp_path: Path) -> None:
    short = replace(dataset, recordings=dataset.recordings[:2])
    file = save_dataset(short, tmp_path, "bridge")
    answer = CliRunner().invoke(app, [str(file), "--out", str(tmp_path / "out")])
    assert answer.exit_code == 0, answer.output
    assert "+12.0%" in answer.output
    for name in ("backbones.png", "spectra.png"):
        assert (tmp_path / "out" / name).stat().st_size > 10_000
    table = json.loads((tmp_path / "out" / "comparison.json").read_text())
    assert [recording["name"] for recording in table["recordings"]] == ["a", "b"]
    rows = list(csv.DictReader((tmp_path / "out" / "comparison.csv").read_text().splitlines()))
    assert {(row["recording"], row["mode"]) for row in rows} >= {("a", "2"), ("a", "3"), ("b", "2"), ("b", "3")}


@pytest.mark.slow
def test_the_command_says_which_columns_it_skips(dataset: Dataset, tmp_path: Path) -> None:
    file = save_dataset(replace(dataset, recordings=dataset.recordings[:1]), tmp_path, "bridge")
    names = [sensor.name for sensor in dataset.sensors]
    table = np.column_stack([dataset.recordings[0].data[0], np.full(SAMPLES, 20.0)])
    header = ",".join([*names, "temperature"])
    np.savetxt(tmp_path / "a.csv", table, delimiter=",", header=header, comments="")
    text = re.sub(r'file = "[^"]*", key = "data"', 'file = "a.csv"', file.read_text())
    file.write_text(text)
    answer = CliRunner().invoke(app, [str(file), "--out", str(tmp_path / "out")])
    assert answer.exit_code == 0, answer.output
    assert "Note: a.csv: column 'temperature' belongs to no sensor and no load and is skipped.\n" in answer.output


@pytest.mark.slow
def test_recordings_too_short_for_a_backbone_are_compared_all_the_same(dataset: Dataset, tmp_path: Path) -> None:
    short = tuple(replace(r, data=r.data[:, : round(0.5 * RATE)]) for r in dataset.recordings[:2])  # two periods
    file = save_dataset(replace(dataset, recordings=short), tmp_path, "bridge")
    answer = CliRunner().invoke(app, [str(file), "--out", str(tmp_path / "out")])
    assert answer.exit_code == 0, answer.output
    assert "windows of 0.5 s" in answer.output
    assert "| 1 | 1.639 | too short | too short |" in answer.output  # a period takes 0.6 s


def test_recordings_too_short_for_any_mode_are_refused_before_any_work(
    dataset: Dataset, monkeypatch: pytest.MonkeyPatch
) -> None:
    """All of them at once: a twentieth of a second holds less than two periods of the fastest mode, 29 Hz."""
    short = tuple(replace(r, data=r.data[:, : round(0.05 * RATE)]) for r in dataset.recordings[:2])
    monkeypatch.setattr(recording_comparison, "identify", lambda *arguments: pytest.fail("work was done"))
    with pytest.raises(InputError) as caught:
        compare_recordings(replace(dataset, recordings=(*short, dataset.recordings[2])))
    assert [fault[:26] for fault in caught.value.faults] == ["recording 'a' lasts 0.05 s", "recording 'b' lasts 0.05 s"]


def test_what_cannot_be_compared_is_told_as_soon_as_it_shows(dataset: Dataset) -> None:
    """Noise shows no mode; it comes first, being shortest, and the long recordings are not looked at in vain."""
    noise = np.random.default_rng(0).standard_normal((1, SAMPLES // 2, len(dataset.sensors)))
    steps: list[None] = []
    with pytest.raises(InputError, match="none of the model's modes is seen in all recordings, no more in 'noise'"):
        compare_recordings(
            replace(dataset, recordings=(*dataset.recordings, Recording("noise", noise, "train"))),
            lambda: steps.append(None),
        )
    assert steps == []
