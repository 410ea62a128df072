"""A frame building in space of 100,000 degrees of freedom, as matrices by groups, diagnosed by sixteen sensors.

    python -m benchmarks.large_matrices --out runs/large_matrices

Its stiffnesses and masses are off by 5 %, and before the second of two recordings the columns of some floors lose a
quarter of theirs. Printed: what was found, the minutes and the peak of memory of the command, files read included.
"""

import argparse
import resource
import subprocess
import sys
import time
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from benchmarks.space_frame import corner, tall_frame
from fe_models.arrays import FloatArray
from fe_models.causes import StiffnessChange
from fe_models.files.dataset_file import save_dataset
from fe_models.linear import LinearModel
from fe_models.matrix_effects import model_with_effects
from fe_models.modes import natural_modes
from fe_models.recordings import Assumptions, Dataset, Recording, Sensor, Uncertainty


@dataclass(frozen=True)
class LargeCase:
    """How large the building is, what is wrong and how it is measured."""

    bays: int = 16
    floors: int = 65
    floors_a_group: int = 13
    off: float = 0.05  # relative standard deviation of what groups are off by, and stated to be
    changed: str = "columns 14 to 26"
    factor: float = 0.75
    rate: float = 12.0  # Hz
    seconds: float = 120.0
    noise: float = 0.01  # of each channel's standard deviation
    modes: int = 10
    levels: int = 4  # two corners each, in x and y


def large_dataset(case: LargeCase, seed: int) -> Dataset:
    """Return two free decays of the building, before and after its change, beside the model as drawn."""
    rng = np.random.default_rng(seed)
    drawn = tall_frame(case.bays, case.floors, case.floors_a_group)
    truth = drawn
    for group in drawn.groups:
        truth = model_with_effects(
            truth, StiffnessChange((), float(np.exp(case.off * rng.standard_normal())), group.name)
        )
    damaged = model_with_effects(truth, StiffnessChange((), case.factor, case.changed))
    levels = np.linspace(0, case.floors, case.levels + 1).astype(int)[1:]
    places = [(corner(case.bays, int(level), far), axis) for level in levels for far in (False, True) for axis in "xy"]
    sensors = tuple(
        Sensor(f"{axis}{node}", node, "x" if axis == "x" else "y", "acceleration", "m/s^2") for node, axis in places
    )
    recordings = tuple(
        Recording(name, decay(model, sensors, case, rng)[None])
        for name, model in (("before", truth), ("after", damaged))
    )
    assumed = Assumptions(uncertainty=Uncertainty(case.off, case.off, 0.1))
    return Dataset(drawn, case.rate, sensors, recordings, assumptions=assumed)


def decay(model: LinearModel, sensors: tuple[Sensor, ...], case: LargeCase, rng: np.random.Generator) -> FloatArray:
    """Return accelerations (time, sensor) of a free decay in all modes below half the rate, with noise."""
    modal = natural_modes(model, case.modes)
    below = modal.frequencies < case.rate / 2
    omega, ratio = modal.omega[below], modal.damping_ratio[below]
    rows = [modal.dofs.row(sensor.node, str(sensor.direction)) for sensor in sensors]
    roots = omega * (-ratio + 1j * np.sqrt(1 - ratio**2))
    waves = np.exp(np.outer(np.arange(round(case.seconds * case.rate)) / case.rate, roots))
    begun = np.exp(2j * np.pi * rng.uniform(size=len(omega))) * rng.uniform(0.5, 1.5, len(omega))
    clean = np.real((waves * begun) @ modal.shapes[rows][:, below].T)
    return np.asarray(clean + case.noise * clean.std(axis=0) * rng.standard_normal(clean.shape))


def main() -> None:
    """Make the case, diagnose it by the command and print what that took."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--out", type=Path, default=Path("runs/large_matrices"))
    parser.add_argument("--seed", type=int, default=0)
    parser.add_argument("--bays", type=int, default=LargeCase.bays, help="columns along a side")
    given = parser.parse_args()
    case = LargeCase(bays=given.bays)
    dataset = large_dataset(case, given.seed)
    assert isinstance(dataset.model, LinearModel)
    file = save_dataset(dataset, given.out / "data")
    print(f"{dataset.model.mass.shape[0]} degrees of freedom, {len(dataset.sensors)} sensors: {file}", flush=True)
    del dataset
    begun = time.perf_counter()
    arguments = ["diagnose", str(file), "--out", str(given.out / "diagnosis")]
    call = f"from hybrid.commands.app import app; app({arguments!r})"
    subprocess.run([sys.executable, "-c", call], check=True)
    minutes = (time.perf_counter() - begun) / 60
    used = resource.getrusage(resource.RUSAGE_CHILDREN)
    peak, busy = used.ru_maxrss / 2**20, (used.ru_utime + used.ru_stime) / 60
    print((given.out / "diagnosis" / "summary.txt").read_text())
    print(f"hidden: {case.changed} at {case.factor} in the second recording")
    print(f"{minutes:.1f} minutes, {busy:.1f} of them of one processor; peak memory {peak:.2f} GiB")


if __name__ == "__main__":
    main()
