"""The modes that a claim expects in each recording: state space, values, and how these may be off.

The values of its modes (`mode_values`) are off with the claim's parameters, by what any model gets wrong in all
recordings alike, and by what differs from one to the next.
"""

from dataclasses import dataclass, replace

import numpy as np
from scipy.linalg import eigh

from fe_models.arrays import BoolArray, ComplexArray, FloatArray, IntArray
from hybrid.diagnosis.discrepancy.modal_space import FineMotion, ModalSpace, amplitude_of, roots_of
from hybrid.diagnosis.modal.config import FIT
from hybrid.diagnosis.modal.error_sizes import SCALE_OF, ErrorSizes
from hybrid.diagnosis.modal.evidence import ModalFit
from hybrid.diagnosis.modal.modal_data import ModalData
from hybrid.diagnosis.modal.mode_values import FREQUENCY, RATIO, free_values, quantities_of, shape_parts, shapes_in
from hybrid.diagnosis.modal.predicted_modes import PredictedModes, predicted_modes
from hybrid.diagnosis.response.reduced_model import ReducedModel

ROOT_STEP = 1e-6  # of log frequency or damping ratio: of the slopes of what sensors show of q and q'


@dataclass(frozen=True, eq=False)
class ExpectedModes:
    """Of recordings in which the same causes act: their ``space``; the ``reference`` sensor of each mode (mode,);
    ``slopes`` (value, parameter) of all values by the claim's parameters; how far they were ``moved`` (value,) from
    where the claim has them.
    """

    space: ModalSpace
    reference: IntArray
    slopes: FloatArray
    moved: FloatArray

    @property
    def free(self) -> BoolArray:
        """Which of all values (mode, value) say something: all but those of reference entries."""
        return free_values(self.reference, len(self.space.shown))

    def moved_by(self, step: FloatArray) -> "ExpectedModes":
        """Return the modes with all values moved by a ``step`` (value,)."""
        space, every = self.space, np.zeros(self.free.shape)
        every[self.free] = step
        at_reference = space.shown[self.reference, np.arange(space.count)]
        there = replace(
            space,
            omega=space.omega * np.exp(every[:, FREQUENCY]),
            ratio=space.ratio + every[:, RATIO],
            shown=space.shown + at_reference * shapes_in(every).T,
        )
        return replace(self, space=there, moved=self.moved + step)


@dataclass(frozen=True, eq=False)
class MotionClaim:
    """The claim of a ``fit`` about what was ``measured``, for motions sampled each ``step`` (s), by the numbers of
    their ``recordings`` (motion,).

    ``sizes`` of errors: None, the fit's own; or those given, with which nominal values are off as was stated.
    ``reference``: the reference sensor of each mode (mode,), None: where it moves most.
    """

    measured: ModalData
    fit: ModalFit
    step: float
    recordings: tuple[int, ...]
    sizes: ErrorSizes | None = None
    reference: IntArray | None = None

    def at(self, theta: FloatArray, reference: IntArray) -> "MotionClaim":
        """Return the claim with other parameters (parameter,), and values over the same entries of shapes."""
        return replace(self, fit=replace(self.fit, theta=theta), reference=reference)


@dataclass(frozen=True, eq=False)
class Expectation:
    """What a claim expects: the modes in each motion (``modes``), how far its parameters may be from where they are
    taken, ``shift`` and ``spread`` (parameter,); standard deviations (value,) of the errors that are ``common`` to all
    recordings and of those that ``vary``.
    """

    modes: tuple[ExpectedModes, ...]
    shift: FloatArray
    spread: FloatArray
    common: FloatArray
    vary: FloatArray

    def moved_by(self, step: FloatArray) -> "Expectation":
        """Return the same with all values moved by a ``step`` (value,) in all motions."""
        return replace(self, modes=tuple(own.moved_by(step) for own in self.modes))


def expectation_of(claimed: MotionClaim) -> Expectation | None:
    """Return what a claim expects at its fit's theta, of modes below half the sampling rate or the low-pass.

    None where the structure has no modes there.
    """
    measured, fit = claimed.measured, claimed.fit
    claim, theta = fit.claim, fit.theta
    idle_in = [claim.idle_in(recording) for recording in claimed.recordings]
    found = {idle: _expected(claimed, idle) for idle in dict.fromkeys(idle_in)}
    whole = tuple(item for item in (found[idle] for idle in idle_in) if item is not None)
    if len(whole) < len(idle_in):
        return None
    least = min(whole, key=lambda item: item.space.count)
    if any(item.space.count > least.space.count for item in whole):  # a support that gives way brings one
        return expectation_of(replace(claimed, reference=least.reference))
    hypothesis, first = claim.hypothesis, fit.nuisances
    own = claimed.sizes or fit.sizes
    factor = [getattr(own, SCALE_OF[kind]) if kind and claimed.sizes is None else 1.0 for kind in measured.kinds]
    spread = hypothesis.width.copy()
    spread[:first] *= factor
    centre = hypothesis.centre.copy()
    centre[:first] = -measured.offset
    free, quantity = whole[0].free, quantities_of(len(measured.sensors))
    common, vary = (np.broadcast_to(sizes[quantity], free.shape)[free] for sizes in (own.common, own.varying))
    return Expectation(whole, centre - theta, spread, common, vary)


def _expected(claimed: MotionClaim, idle: tuple[int, ...]) -> ExpectedModes | None:
    """Return the modes expected where some candidates do not act, ``idle``."""
    measured, fit, step = claimed.measured, claimed.fit, claimed.step
    whole, nominal = fit.claim.hypothesis, measured.nominal
    hypothesis, kept = whole.less(idle), whole.parameters_of(idle)
    theta = fit.theta[kept]
    thetas = np.vstack([theta, theta + np.diag(FIT.difference_step * hypothesis.width)])
    predicted = predicted_modes(hypothesis, thetas, measured.outputs, hardly_differ=True)
    if predicted is None:
        return None
    reference = claimed.reference
    if reference is None:
        below = np.flatnonzero(np.abs(predicted.roots[0]) < min(np.pi / step, nominal.cutoff))
    else:  # the same modes, though one may have moved beyond the limit
        below = np.arange(len(reference))
    if not 0 < len(below) <= predicted.roots.shape[1]:
        return None
    rows = nominal.rows(measured.sensors)
    shapes, shown = _scaled(hypothesis.reduced(theta[None]), rows, predicted, below, measured.orders)
    space = ModalSpace(
        np.abs(predicted.roots[0, below]),
        predicted.ratios[0, below],
        shapes,
        shown,
        rows,
        measured.orders == 2,
        step,
        nominal.lowpass,
    )
    if reference is None:
        reference = np.argmax(np.abs(shown) / space.omega ** measured.orders[:, None], axis=0)
    every = predicted.values_over(below, reference)
    slopes = np.zeros((every.shape[1], every.shape[2], len(whole.centre)))
    moved = FIT.difference_step * hypothesis.width
    slopes[..., kept] = ((every[1:] - every[0]) / moved[:, None, None]).transpose(1, 2, 0)
    slopes = slopes[free_values(reference, len(rows))]
    return ExpectedModes(space, reference, slopes, np.zeros(len(slopes)))


def _scaled(
    reduced: ReducedModel, rows: FloatArray, predicted: PredictedModes, below: IntArray, orders: IntArray
) -> tuple[FloatArray, ComplexArray]:
    """Return mass-normalised shapes (dof, mode) of the modes ``below`` a limit, and what sensors show of each one's
    free motion, (sensor, mode): shapes of the state space, as large as these are.
    """
    squared, vectors = eigh(reduced.stiffness[0], reduced.mass[0])
    every = reduced.shapes[0] @ vectors
    order = np.abs(np.sqrt(np.maximum(squared, 0.0))[:, None] - np.abs(predicted.roots[0, below])).argmin(axis=0)
    shapes = every[:, order]
    undamped = (rows @ shapes) * predicted.roots[0, below] ** orders[:, None]
    shown = predicted.shapes[0, below].T
    scale = np.sum(shown.conj() * undamped, axis=0) / np.sum(np.abs(shown) ** 2, axis=0)
    return shapes, shown * scale


def slopes_over_time(
    modes: ExpectedModes, states: FloatArray, motion: FineMotion, mode: int
) -> tuple[FloatArray, FloatArray]:
    """Return what a unit of each value of a ``mode`` adds to ``states`` (time, 2 mode) in each step, and to the
    channels at once: (value, time, 2 mode), (value, time, sensor); ``motion``: that of the states within the steps.
    """
    space, n, sensors = modes.space, modes.space.count, len(modes.space.shown)
    free = modes.free[mode]
    added, shown = np.zeros((len(free), len(states), 2 * n)), np.zeros((len(free), len(states), sensors))
    q, rate = states[:, mode], states[:, n + mode]
    omega, ratio = space.omega[mode], space.ratio[mode]
    within_q, within_rate = motion.q[:, mode], motion.rate[:, mode]
    for number, force in enumerate(
        (-2 * omega**2 * within_q - 2 * ratio * omega * within_rate, -2 * omega * within_rate)
    ):
        added[number][:, [mode, n + mode]] = space.driven(force, mode)
        moved = (omega * np.exp(ROOT_STEP), ratio) if number == 0 else (omega, ratio + ROOT_STEP)
        of_q, of_rate = (
            (after - before) / ROOT_STEP
            for after, before in zip(
                amplitude_of(roots_of(*map(np.asarray, moved))), amplitude_of(space.roots[mode]), strict=True
            )
        )
        shown[number] = np.real(space.shown[:, mode] * (of_q * q + of_rate * rate)[:, None])
    of_q, of_rate = amplitude_of(space.roots[mode])
    over_reference = space.shown[modes.reference[mode], mode] * (of_q * q + of_rate * rate)
    real, imaginary = (range(*part.indices(len(free))) for part in shape_parts(sensors))
    for sensor in range(sensors):
        shown[real[sensor], :, sensor] = over_reference.real
        shown[imaginary[sensor], :, sensor] = -over_reference.imag
    return added[free], shown[free]
