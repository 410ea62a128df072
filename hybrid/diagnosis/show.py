"""What the nominal simulation gets wrong, before any cause is named."""

from dataclasses import dataclass

import numpy as np

from fe_models.dofs import FloatArray
from fe_models.recordings import Dataset
from hybrid.diagnosis.fitting import Fit
from hybrid.diagnosis.forecasting import Forecast
from hybrid.diagnosis.noise import Excess
from hybrid.diagnosis.plant import Plant


@dataclass(frozen=True)
class Shown:
    """Nominal and calibrated ``frequencies`` (Hz) and damping ratios, each (2, mode); forecast errors per channel,
    nominal, calibrated and floor, (3, sensor); the share of each recording's residual that is no noise (recording,).
    """

    frequencies: FloatArray
    ratios: FloatArray
    sensors: tuple[str, ...]
    errors: FloatArray
    recordings: tuple[str, ...]
    structured: FloatArray


def show(
    dataset: Dataset, plant: Plant, base: Fit, nominal: Forecast, calibrated: Forecast, had: Excess, left: Excess
) -> Shown:
    """Return what is wrong before a cause is named; ``had``: the excess energy of the calibrated nominal model."""
    thetas = np.stack([np.zeros_like(base.theta), base.theta])
    A = base.hypothesis.system(thetas, (), dataset.sampling_rate, ()).A
    modes = []
    for matrix in A:
        roots = np.linalg.eigvals(matrix)
        roots = roots[np.imag(roots) > 0]
        modes.append(roots[np.argsort(np.abs(roots))])
    count = min(len(roots) for roots in modes)
    omega = np.array([np.abs(roots[:count]) for roots in modes])
    ratios = np.array([-roots[:count].real / np.abs(roots[:count]) for roots in modes])
    names = tuple(name for batch in base.batches for name in batch.names)
    values = np.concatenate([np.square(part).sum(axis=(1, 2)) for part in base.residuals])
    return Shown(
        omega / (2 * np.pi),
        ratios,
        tuple(sensor.name for sensor in dataset.sensors),
        np.stack([nominal.nrmse.mean(axis=0), calibrated.nrmse.mean(axis=0), calibrated.floor.mean(axis=0)]),
        names,
        np.clip(had.by_recording / values, 0.0, 1.0),
    )
