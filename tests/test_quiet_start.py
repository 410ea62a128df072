"""What a trigger records before its event is noticed, and no free decay is taken for it."""

from pathlib import Path

import numpy as np
import pytest

from fe_models.arrays import FloatArray
from fe_models.files.dataset_file import load_dataset
from fe_models.quiet_start import quiet_start
from hybrid.inspection.inspection import inspect_file
from hybrid.inspection.inspection_report import as_json, describe

RATE = 50.0


def decay(seconds: float = 20.0, frequencies: tuple[float, float] = (1.9, 6.3), seed: int = 0) -> FloatArray:
    """Return two sensors that show two modes, let go at their largest deflection, with 2 % of noise."""
    time = np.arange(round(seconds * RATE)) / RATE
    omega = 2 * np.pi * np.array(frequencies)
    motion = (np.exp(-0.01 * omega * time[:, None]) * np.cos(omega * time[:, None])) @ np.array(
        [[1.0, 0.6], [0.5, -0.7]]
    )
    return np.asarray(motion + 0.02 * motion.std(axis=0) * np.random.default_rng(seed).standard_normal(motion.shape))


def waiting(motion: FloatArray, seconds: float, at: FloatArray | float = 0.0) -> FloatArray:
    """Return the motion after so many s in which sensors rest ``at`` values of their own, with noise."""
    rng = np.random.default_rng(1)
    noise = 0.02 * motion.std(axis=0) * rng.standard_normal((round(seconds * RATE), 2))
    return np.vstack([at + noise, motion])


@pytest.mark.parametrize("seconds", [1.0, 3.0, 15.0])
@pytest.mark.parametrize("at", [0.0, 9.81, [1.1, 0.1]])
def test_a_quiet_beginning_is_as_long_as_it_is(seconds: float, at: FloatArray | float) -> None:
    motion = waiting(decay(), seconds, at)
    assert abs(quiet_start(motion) - seconds * RATE) <= 4  # samples: from its largest deflection it begins slowly


def test_free_decays_begin_at_once() -> None:
    assert quiet_start(decay()) == 0
    assert quiet_start(decay(4.0, (0.3, 0.5))) == 0  # little more than one period of the slowest mode
    assert quiet_start(waiting(decay(), 0.2)) == 0  # less than a period: nothing to be said
    assert quiet_start(np.zeros((100, 2))) == 0
    assert quiet_start(np.random.default_rng(0).standard_normal((1000, 2))) == 0
    time = np.arange(2000)[:, None] / RATE
    grown = time * np.exp(-time / 8) * np.cos(12 * time) * np.ones(2)  # an earthquake
    assert quiet_start(grown) == 0


def written(folder: Path, data: FloatArray, more: str = "") -> Path:
    """Write a dataset of one recording of the chain."""
    np.savetxt(folder / "r.csv", data, delimiter=",", header="a1,a3", comments="")
    sensors = "".join(
        f'[[sensors]]\nname = "a{node}"\nnode = {node}\ndirection = "x"\nquantity = "acceleration"\nunit = "m/s^2"\n'
        for node in (1, 3)
    )
    recording = f'[[recordings]]\nname = "r"\nfile = "r.csv"\n{more}\n'
    path = folder / "dataset.toml"
    path.write_text(f'schema = 1\nmodel = "four_dof"\nsampling_rate = {RATE}\n{sensors}{recording}')
    return path


def test_a_dataset_and_an_inspection_say_so(tmp_path: Path) -> None:
    data = waiting(decay(), 3.0)
    note = "nothing moves in its first 3 s: leave these out"
    path = written(tmp_path, data)
    assert load_dataset(path).notes[0].startswith(f"r: {note}")
    found = inspect_file(tmp_path / "r.csv", sampling_rate=RATE)
    assert f"N{note[1:]}" in describe(found)
    assert as_json(found)["quiet_samples"] == 150
    assert load_dataset(written(tmp_path, decay())).notes == ()
    assert load_dataset(written(tmp_path, data, 'excitation = "ambient"')).notes == ()
