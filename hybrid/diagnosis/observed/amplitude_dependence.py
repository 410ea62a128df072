"""How frequency and damping change with the size of the motion: the mark of a nonlinear cause, before it is named.

Segments of the recordings are sorted by size. Of those of one size the changes of all frequencies in common, and of all
damping ratios, are found by least squares, to first order about the linear model of all of them.
"""

from dataclasses import dataclass

import numpy as np

from fe_models.arrays import FloatArray
from hybrid.diagnosis.contest.growing import lengths_of
from hybrid.diagnosis.fitting.least_squares import Fit
from hybrid.diagnosis.fitting.linearisation import linearise_batch
from hybrid.diagnosis.observed.config import OBSERVATION
from hybrid.diagnosis.recorded.noise_model import NoiseModel


@dataclass(frozen=True)
class Amplitude:
    """By level, smallest first, (level,): ``size``, the motion's rms over that of the largest level; relative
    ``frequency`` and ``damping`` changes against the mean, with standard deviations.
    """

    size: FloatArray
    frequency: FloatArray
    frequency_std: FloatArray
    damping: FloatArray
    damping_std: FloatArray


def amplitude_dependence(item: Fit, noise_model: NoiseModel) -> Amplitude | None:
    """Return it for a linear fit; None where force laws act, or the recordings are too short to be cut."""
    hypothesis, nominal = item.hypothesis, item.hypothesis.nominal
    batches = lengths_of(item.batches, hypothesis.states).cut[0]
    if (
        not hypothesis.is_linear
        or sum(len(batch.data) for batch in batches) < OBSERVATION.amplitude_levels * OBSERVATION.min_segments_per_level
    ):
        return None
    springs = [i for i, part in enumerate(nominal.parts) if part.quantity == "stiffness"]
    ratios = range(len(nominal.parts), nominal.factors)
    sizes, normals, slopes, squares, counts = [], [], [], [], []
    for batch in batches:
        part = linearise_batch(hypothesis, item.theta, batch, noise_model, None)
        assert part is not None  # linear systems always answer
        # frequency goes with the root of the stiffness: a common factor of all frequencies counts twice
        two = np.stack([2 * part.slopes[springs].sum(axis=0), part.slopes[list(ratios)].sum(axis=0)])
        normals.append(np.einsum("irv,jrv->rij", two, two))
        slopes.append(np.einsum("irv,rv->ri", two, part.residual))
        squares.append(np.square(part.residual).sum(axis=1))
        counts.append(np.full(len(batch.data), part.residual.shape[1]))
        sizes.append(np.sqrt(np.mean((batch.data / batch.sigma(noise_model)) ** 2, axis=(1, 2))))
    size, normal, slope, square, count = (np.concatenate(part) for part in (sizes, normals, slopes, squares, counts))
    found = []
    for level in np.array_split(np.argsort(size), OBSERVATION.amplitude_levels):
        inverse = np.linalg.pinv(normal[level].sum(axis=0))
        change = inverse @ slope[level].sum(axis=0)
        inflation = max(1.0, float(square[level].sum() / count[level].sum()))  # what is no noise is no less uncertain
        std = np.sqrt(np.diag(inverse) * inflation)
        found.append((np.sqrt(np.mean(size[level] ** 2)), change[0], std[0], change[1], std[1]))
    rows = np.array(found).T
    return Amplitude(rows[0] / rows[0, -1], *rows[1:])
