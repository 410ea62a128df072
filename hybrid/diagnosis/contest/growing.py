"""Segments of growing length, and fits that are reached over them: short ones forgive a wrong start."""

from dataclasses import dataclass, replace

from fe_models.arrays import FloatArray
from hybrid.diagnosis.contest.config import SEGMENTS
from hybrid.diagnosis.fitting.config import LEAST_SQUARES
from hybrid.diagnosis.fitting.driven import fitted_motion
from hybrid.diagnosis.fitting.least_squares import Fit, fit
from hybrid.diagnosis.nominal.nominal_model import NominalModel
from hybrid.diagnosis.recorded.batches import Batch
from hybrid.diagnosis.recorded.noise_model import NoiseModel
from hybrid.diagnosis.response.hypothesis import Hypothesis
from hybrid.diagnosis.response.state_space import system_of


@dataclass(frozen=True)
class Lengths:
    """The recordings ``cut`` into ever longer segments; the last are whole."""

    cut: tuple[tuple[Batch, ...], ...]

    @property
    def whole(self) -> tuple[Batch, ...]:
        """The recordings."""
        return self.cut[-1]

    @property
    def alike(self) -> "Lengths":
        """The segments with the same noise in all of them."""
        return Lengths(tuple(tuple(replace(batch, noise=None) for batch in batches) for batches in self.cut))

    def enough(self, batches: tuple[Batch, ...]) -> float:
        """Return the fall in the sum of squares at which fits of one of the lengths stop; of segments early."""
        return LEAST_SQUARES.min_chi2_fall if batches is self.whole else SEGMENTS.enough_fall


def lengths_of(batches: tuple[Batch, ...], states: int) -> Lengths:
    """Return the segments; those too short to tell an initial state are left out."""
    shortest, sensors = min(batch.samples for batch in batches), batches[0].data.shape[2]
    usable = [
        pieces
        for pieces in SEGMENTS.pieces[:-1]
        if shortest // pieces * sensors >= SEGMENTS.min_values_per_state * states
    ]
    cut = []
    for pieces in usable:
        first = usable[0]
        share = first // pieces  # of the shortest segments in one of these, so that they begin where a short one does
        cut.append(tuple(batch.cut(batch.samples // first * share) for batch in batches))
    return Lengths((*cut, batches))


def continued(fit: Fit, longer: tuple[Batch, ...]) -> tuple[FloatArray, ...]:
    """Return where the initial states of longer segments begin: at those of the short ones with the same start."""
    states = []
    for own, short, long in zip(fit.states, fit.batches, longer, strict=True):
        by_recording = own.reshape(len(short.names), short.pieces, -1)
        every = short.pieces // long.pieces
        states.append(by_recording[:, ::every][:, : long.pieces].reshape(len(long.names) * long.pieces, -1))
    return tuple(states)


def fit_growing(
    hypothesis: Hypothesis, theta: FloatArray, lengths: Lengths, noise_model: NoiseModel, start: Fit | None = None
) -> Fit | None:
    """Return the fit over whole recordings, reached over segments of growing length; None where it fails.

    ``start``: a fit of the shortest segments whose initial states to begin with.
    """
    present, states = None, None if start is None else start.states
    for batches in lengths.cut:
        if present is not None:
            theta, states = present.theta, continued(present, batches)
        present = fit(hypothesis, theta, batches, noise_model, states, enough=lengths.enough(batches))
        if present is None:
            return None
    return present


def short_fit(nominal: NominalModel, lengths: Lengths, noise_model: NoiseModel) -> Fit:
    """Return the nominal fit of the shortest segments; force laws of the nominal model are left out where they fail."""
    linear = Hypothesis(replace(nominal, laws=()))
    begun = fit(linear, linear.centre, lengths.cut[0], noise_model)
    assert begun is not None  # a linear system always answers
    if not nominal.laws:
        return begun
    return fit(Hypothesis(nominal), begun.theta, lengths.cut[0], noise_model, begun.states) or begun


@dataclass(frozen=True)
class ReferenceFits:
    """What others are held against: one hypothesis fitted to the shortest segments (``short``) and to ``whole``
    recordings.
    """

    short: Fit
    whole: Fit

    @property
    def hypothesis(self) -> Hypothesis:
        """What was fitted."""
        return self.whole.hypothesis


def reference_fits_of(
    hypothesis: Hypothesis, theta: FloatArray, lengths: Lengths, noise_model: NoiseModel, start: Fit | None = None
) -> ReferenceFits | None:
    """Return the fits of a hypothesis from ``theta``, None where it has none; ``start``: as `fit_growing`'s.

    Beside a force law short segments that begin with the states of another model may not find their own, although
    whole recordings do: they begin anew where the motion of these passes.
    """
    short = fit(hypothesis, theta, lengths.cut[0], noise_model, None if start is None else start.states)
    whole = None if short is None else fit_growing(hypothesis, short.theta, lengths, noise_model, short)
    if short is None or whole is None:
        return None
    again = None if hypothesis.is_linear else shortened(whole, lengths.cut[0], noise_model)
    return ReferenceFits(short if again is None or again.cost > short.cost else again, whole)


def shortened(
    whole: Fit, segments: tuple[Batch, ...], noise_model: NoiseModel, states: tuple[FloatArray, ...] | None = None
) -> Fit | None:
    """Return the fit of short segments from the theta of a fit of ``whole`` recordings, None where it fails.

    Initial states begin at ``states``, where these are given, and beside force laws where the motion of the whole
    passes: whichever leads further.
    """
    starts = [] if states is None else [states]
    if not (whole.hypothesis.is_linear and starts):
        starts.append(passed_by(whole, segments, noise_model))
    fits = [
        fit(whole.hypothesis, whole.theta, segments, noise_model, start, enough=SEGMENTS.enough_fall)
        for start in starts
    ]
    return min((item for item in fits if item is not None), key=lambda item: item.cost, default=None)


def passed_by(whole: Fit, segments: tuple[Batch, ...], noise_model: NoiseModel) -> tuple[FloatArray, ...]:
    """Return the states (segment, state) that the motion of a fit of ``whole`` recordings has where segments begin."""
    system = system_of(whole.hypothesis, whole.theta[None], noise_model.outputs)
    found = []
    for batch, states, short in zip(whole.batches, whole.states, segments, strict=True):
        motion = fitted_motion(system, states, batch).now[:: short.samples, :, : states.shape[1]]
        found.append(motion[: short.pieces].swapaxes(0, 1).reshape(len(short.data), -1))
    return tuple(found)


def padded(start: Fit, hypothesis: Hypothesis) -> tuple[FloatArray, ...]:
    """Return where a ``hypothesis`` begins that has more candidates than a fit, behind its own: (recording, state).

    At rest in the modes that these bring, with harmonic forces that hardly act.
    """
    more, found = len(hypothesis.candidates) - len(start.hypothesis.candidates), list[FloatArray]()
    for states, batch in zip(start.states, start.batches, strict=True):
        own = hypothesis.less(batch.off)
        count = len(own.candidates)
        found.append(own.embedded(states, tuple(range(count - more, count)), SEGMENTS.first_force))
    return tuple(found)
