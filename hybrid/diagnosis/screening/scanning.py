"""Large effects, which no first-order test sees: each linear cause at a few sizes, the rest as drawn."""

from dataclasses import replace

import numpy as np

from fe_models.arrays import FloatArray
from fe_models.causes import SensorGain, StiffnessChange
from fe_models.causes.candidate import Candidate, ChangeCandidate, ForceCandidate, SupportCandidate
from fe_models.causes.stiffness_change import REMAINING_SHARES
from hybrid.diagnosis.fitting.calibration_deviation import goes_far, within
from hybrid.diagnosis.fitting.config import LINEARISATION
from hybrid.diagnosis.fitting.least_squares import Fit
from hybrid.diagnosis.fitting.linearisation import orthonormal
from hybrid.diagnosis.nominal.nominal_model import NominalModel
from hybrid.diagnosis.parallel import parallel_map
from hybrid.diagnosis.recorded.noise_model import NoiseModel
from hybrid.diagnosis.response.eigenmodes import eigenmodes
from hybrid.diagnosis.response.hypothesis import Hypothesis
from hybrid.diagnosis.response.loaded import given
from hybrid.diagnosis.response.reduction import basis_of
from hybrid.diagnosis.response.state_space import system_of
from hybrid.diagnosis.response.system import drift, framed_observability
from hybrid.diagnosis.screening.config import SCAN
from hybrid.diagnosis.screening.screening import Screened

Trial = tuple[Candidate, FloatArray]
"""A candidate and sizes (size, parameter) of it."""


def scan(fit: Fit, candidates: tuple[Candidate, ...], noise_model: NoiseModel) -> list[Screened]:
    """Return each linear candidate at the best of its sizes, with the fall in the sum of squares there.

    The uncertain factors stay as drawn, initial states are projected out. ``fit`` should be of short segments, in which
    a motion with wrong frequencies still is in phase; under force laws there is no quick answer, and none is given.
    """
    if not fit.hypothesis.is_linear:
        return []
    trials = [(candidate, sizes_of(candidate)) for candidate in candidates]
    found = _best_of([trial for trial in trials if len(trial[1])], fit, noise_model)
    return sorted(found, key=lambda trial: -trial.gain)


def unseen(fit: Fit, candidates: tuple[Candidate, ...], noise_model: NoiseModel) -> list[Screened]:
    """Return what other things that are off may hide until the first step of a fit, each at the best of its sizes.

    There its gain says nothing. These are supports that give way and the simulation's own time steps, which calibrated
    factors resemble, where these are far off; and elements, with what may be left of their stiffness, where a ``fit``
    leaves much. Modes that come down into the recordings' band with an element are followed.
    """
    much = leaves_much(fit)
    if not fit.hypothesis.is_linear or not (much or goes_far(fit)):
        return []
    resembled = [
        candidate for candidate in candidates if isinstance(candidate, SupportCandidate) or not candidate.names
    ]
    trials = [(candidate, sizes_of(candidate)) for candidate in resembled]
    changes = [c for c in candidates if much and isinstance(c, ChangeCandidate)]
    weakened = [c for c in changes if c.kind == StiffnessChange.kind and "element" in c.location]
    trials += [
        trial for c in weakened for trial in _bringing(c, np.array(REMAINING_SHARES)[:, None], fit.hypothesis.nominal)
    ]
    best: dict[str, Screened] = {}
    for found in sorted(_best_of(trials, fit, noise_model), key=lambda trial: -trial.gain):
        best.setdefault(found.candidate.key, found)
    return list(best.values())


def leaves_much(fit: Fit) -> bool:
    """Return whether a fit leaves so much that an element may be all but lost."""
    return fit.chi2 > SCAN.min_unexplained_ratio * fit.values


def _bringing(candidate: ChangeCandidate, sizes: FloatArray, nominal: NominalModel) -> list[Trial]:
    """Return the ``sizes`` of a candidate by the number of modes that come down into the recordings' band there."""
    if nominal.kept is None:
        return [(candidate, sizes)]
    basis = basis_of(nominal, (candidate,))
    (change,) = basis.changes
    assert change is not None  # of a stiffness
    amounts = np.append(candidate.amount(sizes[:, 0]), 0.0)[:, None, None]
    omega2 = eigenmodes(basis.mass + amounts * change[0], basis.stiffness + amounts * change[2]).omega2
    inside = np.sum(omega2 < (2 * np.pi * nominal.highest) ** 2, axis=1)
    more = np.maximum(inside[:-1] - inside[-1], 0)
    return [(replace(candidate, brings=int(count)), sizes[more == count]) for count in np.unique(more)]


def _best_of(trials: list[Trial], fit: Fit, noise_model: NoiseModel) -> list[Screened]:
    """Return each candidate at the best of its sizes."""
    theta = within(fit, 0.0)
    plain = float(_left(fit.hypothesis, theta[None], fit, noise_model)[0])

    def best(trial: Trial) -> Screened:
        candidate, sizes = trial
        hypothesis = fit.hypothesis.adding(candidate)
        thetas = with_sizes(theta, sizes)
        weighs = hypothesis.weighs(thetas)
        sizes, thetas = sizes[weighs], thetas[weighs]
        left = _left(hypothesis, thetas, fit, noise_model)
        number = int(np.argmin(left))
        start, gain = tuple(sizes[number].tolist()), float(plain - left[number])
        return Screened(candidate, start, gain, theta - fit.theta, is_drawn=True)

    return parallel_map(best, trials)


def sizes_of(candidate: Candidate) -> FloatArray:
    """Return the sizes (size, parameter) that are tried of a candidate, none where a scan does not serve."""
    if not candidate.names:
        return np.zeros((1, 0))  # it acts or it does not
    if candidate.kind == SensorGain.kind and candidate.starts:  # what the other sensors tell: see `with_other_units`
        return np.array(candidate.starts)
    if len(candidate.names) > 1 or not candidate.scalable or isinstance(candidate, ForceCandidate):
        return np.zeros((0, len(candidate.names)))
    steps = SCAN.compliances if isinstance(candidate, SupportCandidate) else SCAN.sizes
    sizes = np.append(candidate.neutral[0] + np.array(steps) * candidate.width[0], candidate.far)
    most = candidate.upper[0] if candidate.upper else np.inf
    return sizes[(sizes > candidate.lower[0]) & (sizes < most)][:, None]


def with_sizes(theta: FloatArray, sizes: FloatArray) -> FloatArray:
    """Return ``theta`` (parameter,) with each of the sizes (size, ...) of one candidate more, (size, parameter)."""
    return np.column_stack([np.repeat(theta[None], len(sizes), axis=0), sizes])


def _left(hypothesis: Hypothesis, thetas: FloatArray, fit: Fit, noise_model: NoiseModel) -> FloatArray:
    """Return the sum of squares (variant,) that initial states leave, channels of a recording noisy alike."""
    system = system_of(hypothesis, thetas, noise_model.outputs)
    total = np.zeros(len(thetas))
    for batch in fit.batches:
        loud = np.exp(np.log(batch.sigma(noise_model) / noise_model.sigma).mean(axis=2))  # (recording, 1): one serves
        frame, rows = framed_observability(system, batch.samples)
        rows = (rows / noise_model.sigma[:, None]).reshape(len(thetas), -1, rows.shape[-1])
        usable = np.abs(rows).max(axis=(1, 2)) < LINEARISATION.max_channel_sigma
        basis, _ = orthonormal(np.where(usable[:, None, None], rows, 0.0))
        wanted = batch.data - given(system, batch) - drift(system, batch.samples)[:, None]
        wanted = wanted / (noise_model.sigma * loud[..., None])  # (variant, recording, time, sensor)
        inside = (frame[:, None].swapaxes(2, 3) @ wanted).reshape(*wanted.shape[:2], -1) @ basis
        left = np.sum(wanted**2, axis=(1, 2, 3)) - np.sum(inside**2, axis=(1, 2))
        total += np.where(usable, left, np.inf)
    return total
