"""The evidence of a claim: how probable the measured modes are if these causes, and no others, act in these recordings.

Nominal values and what any model gets wrong are marginalised in closed form about the best values, where modes are
linear in them (Laplace's approximation, exact slopes); the causes' sizes are fitted by least squares, and their prior's
share that fits (Occam's factor) is Laplace's, too. The sizes of errors are those of maximum likelihood.
"""

from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np
from scipy.linalg import cho_solve, solve_triangular

from fe_models.arrays import FloatArray, IntArray
from fe_models.recordings import QUANTITIES, Sensor
from hybrid.diagnosis.modal.config import FIT, OUTLIER
from hybrid.diagnosis.modal.errors import ErrorSizes, Rows
from hybrid.diagnosis.modal.measured_modes import MeasuredModes
from hybrid.diagnosis.modal.pairing import paired
from hybrid.diagnosis.modal.predicted_modes import PredictedModes, predicted_modes
from hybrid.diagnosis.nominal.nominal_model import NominalModel
from hybrid.diagnosis.recorded.sensor_outputs import SensorOutputs
from hybrid.diagnosis.response.hypothesis import Hypothesis


@dataclass(frozen=True)
class Claim:
    """What is wrong: the candidates of a ``hypothesis``, each in the recordings (numbers) of ``acts``; ``changed``:
    those whose structure has changed in an unknown way.
    """

    hypothesis: Hypothesis
    acts: tuple[tuple[int, ...], ...] = ()
    changed: tuple[int, ...] = ()

    def off(self, recording: int) -> tuple[int, ...]:
        """Return the numbers of the candidates that do not act in a recording."""
        return tuple(number for number, acts in enumerate(self.acts) if recording not in acts)

    @property
    def key(self) -> tuple[object, ...]:
        """What two equal claims have in common."""
        named = zip(self.hypothesis.candidates, self.acts, strict=True)
        return tuple(sorted((candidate.key, acts) for candidate, acts in named)), self.changed


@dataclass(frozen=True)
class Measured:
    """What evidence is made of: the ``nominal`` model, ``offset`` (nuisance,) of its values from what the user drew,
    the measured ``sensors``, their ``rate`` (Hz), and the modes of all ``recordings``.
    """

    nominal: NominalModel
    offset: FloatArray
    sensors: tuple[Sensor, ...]
    rate: float
    recordings: tuple[MeasuredModes, ...]

    @property
    def outputs(self) -> SensorOutputs:
        """The sensors as state spaces take them."""
        return SensorOutputs.measured(self.sensors, self.rate)

    @property
    def orders(self) -> IntArray:
        """How often each sensor's signal is the derivative of a displacement, (sensor,)."""
        return np.array([QUANTITIES.index(sensor.quantity) for sensor in self.sensors])

    @property
    def kind(self) -> tuple[str, ...]:
        """Whose scale each nuisance (nuisance,) has: "stiffness", "mass", "damping", "element", or "" of none."""
        nominal = self.nominal
        parts = [part.quantity for part in nominal.parts] + ["damping"] * len(nominal.ratios)
        return (
            *parts,
            *["element"] * (nominal.values - nominal.factors),
            *[""] * (len(nominal.spread) - nominal.values),
        )

    @cached_property
    def null(self) -> Claim:
        """The claim that nothing is wrong."""
        return Claim(Hypothesis(self.nominal))


@dataclass(frozen=True)
class Pairs:
    """Which measured mode is which: ``recording``, the ``measured`` mode there and the structure's ``mode`` (row,) of
    each pair, and ``reference`` (row,), the sensor over which shapes are taken.
    """

    recording: IntArray
    measured: IntArray
    mode: IntArray
    reference: IntArray

    def __len__(self) -> int:
        return len(self.mode)


@dataclass(frozen=True, eq=False)
class ModalFit:
    """The best ``theta`` (parameter,) of a claim, with the ``sizes`` of errors, and the log ``evidence``.

    ``residual`` (row,), nominal values at their centre, and ``slopes`` (row, parameter); ``lower``: the Cholesky factor
    of the covariance of all ``rows``; ``covariance`` (parameter, parameter) of theta.
    """

    claim: Claim
    theta: FloatArray
    sizes: ErrorSizes
    pairs: Pairs
    rows: Rows
    residual: FloatArray
    slopes: FloatArray
    lower: FloatArray
    covariance: FloatArray
    evidence: float

    @property
    def nuisances(self) -> int:
        """Number of nominal values."""
        return self.claim.hypothesis.nuisances

    @cached_property
    def white(self) -> FloatArray:
        """The residual (row,) in units of all errors."""
        return np.asarray(solve_triangular(self.lower, self.residual, lower=True))


def fit_claim(
    measured: Measured,
    claim: Claim,
    theta: FloatArray,
    sizes: ErrorSizes,
    rounds: int = FIT.max_iterations,
    errors_too: bool = True,
) -> ModalFit | None:
    """Return the best fit of a claim from ``theta`` (parameter,), None where the structure cannot stand there.

    With the ``sizes`` of errors as they are, or, ``errors_too``, as is likeliest.
    """
    hypothesis, first = claim.hypothesis, claim.hypothesis.nuisances
    best: ModalFit | None = None
    for number in range(rounds):
        predicted = _predicted(measured, claim, theta)
        if predicted is None:
            return best
        pairs = pairs_of(measured, claim, predicted)
        values, noise = _values(measured, pairs)
        residual, slopes = _residual(measured, claim, pairs, values, predicted)
        total = theta[:first] + measured.offset
        at_centre = residual + slopes[:, :first] @ total
        rows = _rows(measured, claim, pairs, noise, slopes[:, :first], hypothesis)
        if errors_too and number % 2 == 1:
            sizes = rows.fitted(at_centre, sizes, FIT.error_iterations)
        present = _at(measured, claim, theta, sizes, pairs, rows, at_centre, slopes)
        best = present if best is None or present.evidence > best.evidence else best
        step = _step(measured, present)
        then = _bounded(hypothesis, theta, step)
        errors = np.sqrt(np.diag(present.covariance)[first:])
        settled = (
            np.abs(step[:first]).max(initial=0.0) < FIT.converged_log_step
            and (np.abs(step[first:]) < FIT.converged_sigma * errors).all()
        )
        theta = then
        if settled and number >= 2:
            break
    return best


def refitted_errors(
    measured: Measured, item: ModalFit, claim: Claim, iterations: int = FIT.error_iterations
) -> ModalFit:
    """Return a fit's theta as one of another ``claim`` with the same causes, the sizes of errors fitted anew."""
    changed = np.isin(item.rows.recording, claim.changed)
    rows = replace(item.rows, changed=changed)
    sizes = rows.fitted(item.residual, item.sizes, iterations) if iterations else item.sizes
    return _at(measured, claim, item.theta, sizes, item.pairs, rows, item.residual, item.slopes)


def _at(
    measured: Measured,
    claim: Claim,
    theta: FloatArray,
    sizes: ErrorSizes,
    pairs: Pairs,
    rows: Rows,
    residual: FloatArray,
    slopes: FloatArray,
) -> ModalFit:
    """Return the fit as it stands at ``theta``; ``residual`` at the nominal values' centre."""
    hypothesis, first = claim.hypothesis, claim.hypothesis.nuisances
    lower = np.asarray(np.linalg.cholesky(rows.covariance(sizes)), dtype=np.float64)
    white = solve_triangular(lower, residual, lower=True)
    evidence = float(-0.5 * white @ white - np.log(np.diag(lower)).sum()) + rows.constant + sizes.log_prior
    width = hypothesis.width[first:]
    if len(width):
        own = solve_triangular(lower, slopes[:, first:], lower=True)
        normal = own.T @ own + np.diag(1 / width**2)
        off = (theta[first:] - hypothesis.centre[first:]) / width
        evidence += -0.5 * float(off @ off) - 0.5 * float(np.linalg.slogdet(normal)[1]) - float(np.log(width).sum())
    evidence += _of_outliers(measured, pairs)
    covariance = _covariance(rows, sizes, slopes, width)
    return ModalFit(claim, theta, sizes, pairs, rows, residual, slopes, lower, covariance, evidence)


def _covariance(rows: Rows, sizes: ErrorSizes, slopes: FloatArray, width: FloatArray) -> FloatArray:
    """Return the posterior covariance of theta (parameter, parameter)."""
    bare = replace(rows, slopes=np.zeros((len(rows.quantity), 0)), spread=np.zeros(0), kind=())
    lower = np.linalg.cholesky(bare.covariance(sizes))
    scaled = solve_triangular(lower, slopes, lower=True)
    prior = np.concatenate([rows.scales(sizes), width])
    whitened = scaled * prior  # in units of the prior, in which no value is too large for another
    normal = whitened.T @ whitened + np.eye(len(prior))
    return np.asarray(np.linalg.inv(normal) * np.outer(prior, prior))


def _step(measured: Measured, item: ModalFit) -> FloatArray:
    """Return how far theta (parameter,) is from where the linearised modes fit best."""
    first, hypothesis = item.nuisances, item.claim.hypothesis
    width, centre = hypothesis.width[first:], hypothesis.centre[first:]
    own = solve_triangular(item.lower, item.slopes[:, first:], lower=True)
    along = own.T @ item.white - (item.theta[first:] - centre) / width**2
    sizes_step = np.linalg.solve(own.T @ own + np.diag(1 / width**2), along) if len(width) else np.zeros(0)
    left = item.residual - item.slopes[:, first:] @ sizes_step
    scale = item.rows.scales(item.sizes)
    wanted = scale**2 * (item.slopes[:, :first].T @ cho_solve((item.lower, True), left))
    return np.concatenate([wanted - measured.offset - item.theta[:first], sizes_step])


def _bounded(hypothesis: Hypothesis, theta: FloatArray, step: FloatArray) -> FloatArray:
    """Return theta (parameter,) after a step, cut where it would cross a bound or go too far at once."""
    first = hypothesis.nuisances
    step = step.copy()
    step[:first] = np.clip(step[:first], -FIT.max_log_step, FIT.max_log_step)
    then = theta + step
    for bound, crossed in ((hypothesis.lower, then <= hypothesis.lower), (hypothesis.upper, then >= hypothesis.upper)):
        then[crossed] = theta[crossed] + FIT.bound_approach * (bound[crossed] - theta[crossed])
    return then


def _predicted(measured: Measured, claim: Claim, theta: FloatArray) -> dict[tuple[int, ...], PredictedModes] | None:
    """Return the modes and their slopes, a variant a parameter after the first, by the candidates that do not act."""
    found = {}
    for off in dict.fromkeys(claim.off(recording) for recording in range(len(measured.recordings))):
        hypothesis, kept = claim.hypothesis.less(off), claim.hypothesis.parameters_of(off)
        own = theta[kept]
        thetas = np.vstack([own, own + np.diag(FIT.difference_step * hypothesis.width)])
        modes = predicted_modes(hypothesis, thetas, measured.outputs, hardly_differ=True)
        if modes is None or not modes.roots.shape[1]:
            return None
        found[off] = modes
    return found


def pairs_of(measured: Measured, claim: Claim, predicted: dict[tuple[int, ...], PredictedModes]) -> Pairs:
    """Return which measured mode is which of those predicted."""
    found: list[tuple[int, int, int]] = []
    for recording, own in enumerate(measured.recordings):
        modes = predicted[claim.off(recording)]
        mode = paired(own, modes.log_omega[0], modes.shapes[0], measured.orders)
        found += [(recording, int(k), int(mode[k])) for k in np.flatnonzero(mode >= 0)]
    rows = np.array(found, dtype=int).reshape(-1, 3)
    first = predicted[next(iter(predicted))]
    displaced = first.shapes[0] * np.exp(-np.outer(first.log_omega[0], measured.orders))
    largest = np.argmax(np.abs(displaced), axis=1)
    number = np.minimum(rows[:, 2], len(largest) - 1)  # a cause may bring a mode that others do not have
    return Pairs(rows[:, 0], rows[:, 1], rows[:, 2], largest[number])


def _values(measured: Measured, pairs: Pairs) -> tuple[FloatArray, FloatArray]:
    """Return what was measured of each pair (pair, 2 + 2 sensor), and its covariance (pair, same, same)."""
    sensors = len(measured.sensors)
    values = np.zeros((len(pairs), 2 + 2 * sensors))
    noise = np.zeros((len(pairs), 2 + 2 * sensors, 2 + 2 * sensors))
    for recording, own in enumerate(measured.recordings):
        here = np.flatnonzero(pairs.recording == recording)
        reference = np.zeros(len(own.log_omega), dtype=int)
        reference[pairs.measured[here]] = pairs.reference[here]
        every, covariance = own.over(reference)
        values[here], noise[here] = every[pairs.measured[here]], covariance[pairs.measured[here]]
    return values, noise


def _free(measured: Measured, pairs: Pairs) -> FloatArray:
    """Return which values (pair, 2 + 2 sensor) say something: not the reference entries."""
    sensors = len(measured.sensors)
    free = np.ones((len(pairs), 2 + 2 * sensors), dtype=bool)
    for part in (2, 2 + sensors):
        free[np.arange(len(pairs)), part + pairs.reference] = False
    return free


def _residual(
    measured: Measured,
    claim: Claim,
    pairs: Pairs,
    values: FloatArray,
    predicted: dict[tuple[int, ...], PredictedModes],
) -> tuple[FloatArray, FloatArray]:
    """Return what is measured less what is predicted (row,), and the slopes of that prediction (row, parameter)."""
    hypothesis = claim.hypothesis
    residual, slopes = np.zeros_like(values), np.zeros((*values.shape, len(hypothesis.centre)))
    for off, modes in predicted.items():
        here = np.array([claim.off(recording) == off for recording in pairs.recording], dtype=bool)
        if not here.any():
            continue
        kept = hypothesis.parameters_of(off)
        every = modes.over(pairs.mode[here], pairs.reference[here])  # (variant, pair, value)
        residual[here] = values[here] - every[0]
        moved = FIT.difference_step * hypothesis.less(off).width
        own = ((every[1:] - every[0]) / moved[:, None, None]).transpose(1, 2, 0)
        rows = np.zeros((*own.shape[:2], len(hypothesis.centre)))
        rows[..., kept] = own
        slopes[here] = rows
    free = _free(measured, pairs)
    return residual[free], slopes[free]


def _rows(
    measured: Measured, claim: Claim, pairs: Pairs, noise: FloatArray, slopes: FloatArray, hypothesis: Hypothesis
) -> Rows:
    """Return all rows with their errors."""
    sensors, free = len(measured.sensors), _free(measured, pairs)
    quantity = np.broadcast_to([0, 1] + [2] * sensors + [3] * sensors, free.shape)[free]
    place = np.broadcast_to(np.arange(free.shape[1]), free.shape)[free]
    mode = np.broadcast_to(pairs.mode[:, None], free.shape)[free]
    recording = np.broadcast_to(pairs.recording[:, None], free.shape)[free]
    shared = np.unique(mode * free.shape[1] + place, return_inverse=True)[1]
    whole = np.zeros((len(quantity), len(quantity)))
    begin = 0
    for own, covariance in zip(free, noise, strict=True):
        end = begin + int(own.sum())
        whole[begin:end, begin:end] = covariance[np.ix_(own, own)]
        begin = end
    return Rows(
        quantity,
        shared,
        recording,
        whole,
        slopes,
        hypothesis.width[: hypothesis.nuisances],
        measured.kind,
        np.isin(recording, claim.changed),
    )


def _of_outliers(measured: Measured, pairs: Pairs) -> float:
    """Return the log density of the measured modes that no mode of the structure is, and the prior of all."""
    sensors = len(measured.sensors)
    widths = [OUTLIER.log_frequency, OUTLIER.damping_ratio] + [OUTLIER.shape] * (2 * sensors - 2)
    each = -float(np.sum(np.log(widths))) - 0.5 * len(widths) * float(np.log(2 * np.pi * np.e))
    every = sum(len(own.log_omega) for own in measured.recordings)
    alone = every - len(pairs)
    return alone * (each + float(np.log(OUTLIER.probability))) + len(pairs) * float(np.log1p(-OUTLIER.probability))


def predicted_of(
    measured: Measured, claim: Claim, theta: FloatArray
) -> tuple[dict[tuple[int, ...], PredictedModes], Pairs]:
    """Return a claim's modes at ``theta`` (parameter,), by the candidates that do not act, and which measured one is
    which of them; none where the structure does not stand.
    """
    predicted = _predicted(measured, claim, theta)
    if predicted is None:
        return {}, Pairs(*np.zeros((4, 0), dtype=int))
    return predicted, pairs_of(measured, claim, predicted)


def misfit_of(measured: Measured, item: ModalFit, errors: ModalFit | None = None) -> float:
    """Return the sum of squares of what a fit's theta leaves of all pairs, in units of what modes vary by from one
    recording to the next and what their identification leaves open; ``errors``: the fit whose sizes count, or its own.
    """
    claim = item.claim
    predicted, pairs = predicted_of(measured, claim, item.theta)
    if not len(pairs):
        return float("inf")
    values, noise = _values(measured, pairs)
    residual, slopes = _residual(measured, claim, pairs, values, predicted)
    rows = _rows(measured, claim, pairs, noise, slopes[:, : item.nuisances], claim.hypothesis)
    varies = rows.varies((errors or item).sizes)
    return float(np.sum(residual**2 / (np.diag(rows.noise) + varies**2)))
