"""Causes behind a calibration gone astray, ranked by the modes that it was needed for.

What would make the modes that recordings show with all factors near nominal may have led these astray. Frequencies are
all but linear in a factor where the phase of a long motion is not, so that this ranks what the score test cannot.
"""

from dataclasses import dataclass
from functools import partial

import numpy as np

from fe_models.arrays import FloatArray
from fe_models.causes.candidate import Candidate, ChangeCandidate
from hybrid.diagnosis.fitting.calibration_deviation import within
from hybrid.diagnosis.fitting.least_squares import Fit
from hybrid.diagnosis.parallel import parallel_map
from hybrid.diagnosis.recorded.noise_model import NoiseModel
from hybrid.diagnosis.response.hypothesis import Hypothesis
from hybrid.diagnosis.screening.config import MODAL_SCAN
from hybrid.diagnosis.screening.observed_modes import ObservedModes, observed_modes, picked_modes
from hybrid.diagnosis.screening.scanning import sizes_of, with_sizes
from hybrid.diagnosis.screening.screening import Screened


@dataclass(frozen=True)
class _Calibration:
    """What nuisances can do about modes, to first order: ``slopes`` (nuisance, value), and the ``inverse`` of their
    normal matrix, prior and all. ``plain`` (1, value): what they leave of the modes seen where all are as drawn.
    """

    slopes: FloatArray
    inverse: FloatArray
    plain: FloatArray

    @classmethod
    def of(
        cls, hypothesis: Hypothesis, drawn: FloatArray, seen: ObservedModes, noise_model: NoiseModel
    ) -> "_Calibration":
        """Return the calibration of a hypothesis about ``drawn``, its theta (parameter,)."""
        values = hypothesis.nuisances
        moved = MODAL_SCAN.difference_step * hypothesis.width[:values]
        thetas = drawn + np.vstack([np.zeros(len(drawn)), np.eye(values, len(drawn)) * moved[:, None]])
        plain, left = np.split(seen.less(picked_modes(hypothesis, thetas, noise_model)), [1])
        slopes = (plain - left) / moved[:, None]
        normal = slopes @ slopes.T + np.diag(hypothesis.precision[:values])
        return cls(slopes, np.asarray(np.linalg.inv(normal), dtype=np.float64), plain)

    def best(self, left: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Return the least cost (variant,) of what is ``left`` (variant, value), prior and all, and the nominal values
        (variant, nuisance) there.
        """
        along = left @ self.slopes.T
        found = along @ self.inverse
        return np.sum(left**2, axis=1) - np.sum(along * found, axis=1), found


def modal_scan(item: Fit, candidates: tuple[Candidate, ...], noise_model: NoiseModel, start: Fit) -> list[Screened]:
    """Return candidates that change M or K, each at the best of its sizes, most promising first.

    ``item``: a fit of whole recordings. The calibration that each asks for goes with it, as a shift from ``start``.
    """
    hypothesis, seen = item.hypothesis, observed_modes(item, noise_model)
    drawn = within(item, 0.0)
    calibration = _Calibration.of(hypothesis, drawn, seen, noise_model)
    plain = float(calibration.best(calibration.plain)[0][0])

    def best(candidate: Candidate) -> Screened:
        extended = hypothesis.adding(candidate)
        left_at = partial(_left_at, extended, drawn, seen, noise_model)
        sizes = _sizes(candidate)
        sizes = sizes[extended.weighs(with_sizes(drawn, sizes))]
        number = int(np.argmin(calibration.best(left_at(sizes))[0]))
        closer = np.linspace(
            sizes[max(number - 1, 0)], sizes[min(number + 1, len(sizes) - 1)], MODAL_SCAN.refined_sizes
        )
        costs, values = calibration.best(left_at(closer))
        number = int(np.argmin(costs))
        shift = np.zeros_like(start.theta)
        shift[: hypothesis.nuisances] = -start.theta[: hypothesis.nuisances]
        shift[: values.shape[1]] += values[number]
        return Screened(candidate, (float(closer[number]),), plain - float(costs[number]), shift, is_drawn=True)

    turning = [candidate for candidate in candidates if isinstance(candidate, ChangeCandidate)]
    return sorted(parallel_map(best, turning), key=lambda trial: -trial.gain)


def _left_at(
    hypothesis: Hypothesis, drawn: FloatArray, seen: ObservedModes, noise_model: NoiseModel, sizes: FloatArray
) -> FloatArray:
    """Return what the structure as drawn leaves of the modes seen, (size, value), with one candidate more."""
    return seen.less(picked_modes(hypothesis, with_sizes(drawn, sizes), noise_model, len(seen.omega)))


def _sizes(candidate: Candidate) -> FloatArray:
    """Return the sizes (size,) that are tried first, in their order."""
    fine = candidate.neutral[0] + np.array(MODAL_SCAN.fine_sizes) * candidate.width[0]
    return np.sort(np.concatenate([sizes_of(candidate)[:, 0], fine[fine > candidate.lower[0]]]))
