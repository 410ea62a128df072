"""What is shown before a cause is named: modes, shapes, energy by mode, change with amplitude; tables and a picture."""

import json
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from benchmarks.blind_cases import SENSORS, BlindConfig, blind_case
from fe_models.assembly import linearise
from fe_models.built_in.four_dof import four_dof
from fe_models.causes import AddedMass, CubicSpring, Effect, PointDamper, QuadraticDamper
from fe_models.modes import mac, natural_modes
from fe_models.recordings import Dataset, Recording, Uncertainty
from fe_models.simulation import FreeConfig, simulate_free
from hybrid.diagnosis.fitting.least_squares import fit
from hybrid.diagnosis.nominal.structure_model import nominal_model_of
from hybrid.diagnosis.observed.amplitude_dependence import amplitude_dependence
from hybrid.diagnosis.observed.example import Example, draw_example
from hybrid.diagnosis.observed.observation_report import describe_observations, observations_table
from hybrid.diagnosis.observed.observations import Observations, modes_of
from hybrid.diagnosis.observed.uniform_errors import uniform_damping_error, uniform_frequency_error
from hybrid.diagnosis.outcome.conclusion import Diagnosis
from hybrid.diagnosis.recorded.batches import batches_of, columns_of
from hybrid.diagnosis.recorded.noise_model import NoiseModel
from hybrid.diagnosis.recorded.spectra import energy_near
from hybrid.diagnosis.response.hypothesis import Hypothesis
from hybrid.diagnosis.series_diagnosis import diagnose_series as diagnose

NOISE = 0.02
MEASURED = (0, 1, 2, 3)


def motions(*effects: Effect) -> Dataset:
    """Return eight motions of different size of a chain with effects, to be compared with the chain without."""
    rng = np.random.default_rng(1)
    state = rng.standard_normal((2, 8, 4)) * np.linspace(0.4, 1.4, 8)[:, None]
    config = FreeConfig(duration=20.0, sampling_rate=10.0)
    motion = simulate_free(four_dof().with_effects(*effects), state[0], state[1], config, progress=False)
    data = np.stack([motion.shown(s) for s in SENSORS], axis=-1)
    data = data + NOISE * rng.standard_normal(data.shape)
    return Dataset(four_dof(), 10.0, SENSORS, tuple(Recording(f"r{i}", part[None]) for i, part in enumerate(data)))


def test_modes_are_the_structures_own() -> None:
    own = natural_modes(linearise(four_dof()), 4)
    hypothesis = Hypothesis(nominal_model_of(Dataset(four_dof(), 10.0, SENSORS, ())))
    found = modes_of(hypothesis, hypothesis.centre, 10.0)
    np.testing.assert_allclose(found.frequencies, own.frequencies, rtol=1e-3)  # coupled by damping, which they are not
    np.testing.assert_allclose(found.ratios, own.damping_ratio, rtol=1e-2)
    assert np.diag(mac(found.shapes, own.shapes[own.dofs.free])).min() > 0.999


def test_energy_goes_to_the_nearest_frequency() -> None:
    time = np.arange(500) / 10
    wave = 50 * np.stack([np.sin(2 * np.pi * 0.5 * time), 2 * np.sin(2 * np.pi * 1.5 * time)], axis=-1)[None]
    noise = np.random.default_rng(0).standard_normal(wave.shape)
    found = energy_near(np.array([0.5, 1.5, 3.0]), (wave + noise,), 10.0)
    np.testing.assert_allclose(found, [0.2, 0.8, 0.0], atol=1e-2)


@pytest.mark.parametrize(
    ("effects", "frequency", "damping"),
    [
        ((), 0, 0),
        ((CubicSpring((1,), "x", 0.1),), 1, None),
        ((CubicSpring((1,), "x", -0.01),), -1, None),
        ((QuadraticDamper((4,), "x", 0.3),), 0, 1),
    ],
)
def test_change_with_amplitude_has_the_sign_of_its_cause(
    effects: tuple[Effect, ...], frequency: int, damping: int | None
) -> None:
    """From the smallest motion to the largest, in standard deviations: beyond 4 where there is a cause, else within."""
    dataset = motions(*effects)
    batches = columns_of(batches_of(dataset, "train"), MEASURED)
    noise_model = NoiseModel(SENSORS[:4], 10.0, np.full(4, NOISE))
    nominal = nominal_model_of(dataset)
    free = Hypothesis(replace(nominal, spread=np.full_like(nominal.spread, 0.5)))
    linear = fit(free, free.centre, batches, noise_model)
    assert linear is not None
    found = amplitude_dependence(linear, noise_model)
    assert found is not None
    assert (np.diff(found.size) > 0).all()
    f = (found.frequency[-1] - found.frequency[0]) / np.hypot(found.frequency_std[-1], found.frequency_std[0])
    d = (found.damping[-1] - found.damping[0]) / np.hypot(found.damping_std[-1], found.damping_std[0])
    for value, sign in ((f, frequency), (d, damping)):
        assert sign is None or (sign * value > 4 if sign else abs(value) < 4)


@pytest.fixture(scope="module")
def found() -> Diagnosis:
    return diagnose(blind_case(31, BlindConfig(("added_mass",), size=0.8, train=3, test=1, duration=20.0)).dataset)


@pytest.mark.slow
def test_observed_modes_are_those_of_the_truth(found: Diagnosis) -> None:
    """An added mass makes a mode slower than it is in the nominal model."""
    (cause,) = (finding.cause for finding in found.findings)
    assert isinstance(cause, AddedMass)
    true = natural_modes(linearise(four_dof().with_effects(cause)), 4)
    np.testing.assert_allclose(found.observations.observed.frequencies, true.frequencies, rtol=0.01)
    off = np.abs(found.observations.nominal.frequencies / true.frequencies - 1)
    assert off.max() > 0.02
    assert found.observations.mac.shape == (4,)
    assert found.observations.motion_energy.sum() == pytest.approx(1)
    assert found.observations.error_energy.sum() == pytest.approx(1)


def test_frequencies_that_are_all_off_alike_are_reported(found: Diagnosis) -> None:
    """Not those of one mode, which a cause at a place moves, nor by what its owner thinks normal."""
    shown, f = found.observations, found.observations.nominal.frequencies
    alike, one = (replace(shown, observed=replace(shown.observed, frequencies=f * (0.8, b, b, b))) for b in (0.8, 1.0))
    seen = replace(alike, motion_energy=np.full(4, 0.25), mac=np.ones(4))
    (note,) = uniform_frequency_error(seen, Uncertainty())
    assert "observed at 0.8 times" in note
    assert uniform_frequency_error(seen, Uncertainty(stiffness=0.3)) == []
    assert uniform_frequency_error(replace(one, motion_energy=np.full(4, 0.25), mac=np.ones(4)), Uncertainty()) == []


def test_damping_that_is_off_in_all_modes_is_reported(found: Diagnosis) -> None:
    """Not that of one mode, nor what its owner thinks normal; from none at all it is infinitely far."""
    shown = replace(found.observations, motion_energy=np.full(4, 0.25), mac=np.ones(4))

    def with_ratios(observed: tuple[float, ...], nominal: tuple[float, ...]) -> Observations:
        two = (np.array(ratios) for ratios in (observed, nominal))
        own, drawn = (replace(m, ratios=r) for m, r in zip((shown.observed, shown.nominal), two, strict=True))
        return replace(shown, observed=own, nominal=drawn)

    less = with_ratios((0.015,) * 4, (0.05,) * 4)
    (note,) = uniform_damping_error(less, Uncertainty())
    assert "modes 1, 2, 3, 4 are observed with damping ratios of 0.015, 0.015, 0.015, 0.015 instead of 0.05" in note
    assert uniform_damping_error(less, Uncertainty(damping=0.8)) == []
    assert uniform_damping_error(with_ratios((0.015,) * 4, (0.0,) * 4), Uncertainty())
    assert uniform_damping_error(with_ratios((0.015, 0.015, 0.05, 0.05), (0.05,) * 4), Uncertainty()) == []


def test_of_a_mode_that_is_hardly_seen_only_the_drawing_is_told(found: Diagnosis) -> None:
    """What recordings do not show may be calibrated to any frequency."""
    shown = replace(found.observations, motion_energy=np.array([0.5, 0.5, 0.0, 0.0]))
    rows = [line.split() for line in describe_observations(shown) if line.split()[0] in ("1", "2", "3", "4")]
    assert [row.count("-") for row in rows] == [0, 0, 4, 4]
    assert [float(row[1]) for row in rows] == pytest.approx(shown.nominal.frequencies, abs=1e-4)


@pytest.mark.slow
def test_mode_that_is_overdamped_is_in_no_table() -> None:
    """Of the others fewer are observed than there are nominal ones."""
    found = diagnose(motions(PointDamper((2,), "x", 10.0)))
    assert len(found.observations.observed.frequencies) < len(found.observations.nominal.frequencies)
    assert observations_table(found.observations)


def test_tables_tell_channels_and_modes(found: Diagnosis) -> None:
    lines = describe_observations(found.observations)
    assert max(len(line) for line in lines) <= 110
    assert [line.split()[0] for line in lines[2:7]] == ["x4", "a1", "a3", "a4", "a2"]
    assert lines[6].endswith("held out")
    table = json.loads(json.dumps(observations_table(found.observations)))
    assert table["channels"][4]["noise_std"] is None
    assert len(table["modes"]["observed"]["frequencies"]) == 4


def test_picture_is_drawn(found: Diagnosis, tmp_path: Path) -> None:
    example = found.example
    assert example.recording == "r04"
    first, last = (np.mean((example.measured - part) ** 2) for part in (example.nominal, example.extended))
    assert last < 0.5 * first
    path = draw_example(example).save(tmp_path / "what_is_wrong.png")
    assert path.stat().st_size > 10_000


def test_channels_that_are_most_wrong_are_drawn_one_that_was_held_out_among_them(found: Diagnosis) -> None:
    example = found.example
    roles = [sensor.role for sensor in example.sensors]
    assert example.most_wrong(5) == [0, 1, 2, 3, 4]
    two = example.most_wrong(2)
    assert sorted(roles[column] for column in two) == ["held_out", "measured"]
    error = np.std(example.measured - example.nominal, axis=0) / example.measured.std(axis=0)
    fitted = [column for column, role in enumerate(roles) if role == "measured"]
    assert max(fitted, key=lambda column: error[column]) in two


def test_spectrum_of_an_error_is_its_amplitude_over_the_channels_size() -> None:
    time = np.arange(200)[:, None] / 10
    measured = np.sin(2 * np.pi * time)
    error = 0.1 * np.sin(2 * np.pi * 2 * time)
    example = Example("r", 10.0, 0.0, SENSORS[:1], measured, measured - error, measured, np.array([1.0]))
    frequency, amplitude = example.spectrum("nominal")
    assert frequency[np.argmax(amplitude)] == pytest.approx(2.0)
    assert amplitude.max() == pytest.approx(0.1 * np.sqrt(2), rel=1e-2)
