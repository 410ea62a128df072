"""A recording followed by a filter that knows a structure's modes, and the discrepancy with which it does best."""

from collections.abc import Sequence
from dataclasses import dataclass, field, replace

import numpy as np

from fe_models.arrays import FloatArray
from hybrid.diagnosis.discrepancy.config import DISCREPANCY
from hybrid.diagnosis.discrepancy.kalman import FilteredMotion, filtered
from hybrid.diagnosis.discrepancy.linearisation import LinearisedMotion, unforced
from hybrid.diagnosis.discrepancy.modal_space import ModalSpace
from hybrid.diagnosis.discrepancy.size import Discrepancy
from hybrid.diagnosis.parallel import parallel_map


@dataclass(frozen=True, eq=False)
class FollowedMotion:
    """A motion: its ``data`` (time, sensor), the variance of their ``noise`` (sensor,), their ``envelope`` (time,
    sensor), the rms about each sample, and the ``amplitude`` of q in each mode (time, mode); its ``linearisation``
    under force laws, None where no law acts.
    """

    data: FloatArray
    noise: FloatArray
    envelope: FloatArray
    amplitude: FloatArray
    linearisation: LinearisedMotion | None = None

    @property
    def samples(self) -> int:
        """Number of samples."""
        return len(self.data)

    def begin(self, samples: int) -> "FollowedMotion":
        """Return its first ``samples``, under no force law."""
        return FollowedMotion(self.data[:samples], self.noise, self.envelope[:samples], self.amplitude[:samples])


def followed(space: ModalSpace, data: FloatArray, noise: FloatArray) -> FollowedMotion:
    """Return a motion with how large it is, and each mode of it, over the period about each sample.

    As a filter shows it that lets each mode go its own way.
    """
    loose = Discrepancy(DISCREPANCY.loose_size, DISCREPANCY.loose_share)
    squared = _about(data**2, np.full(data.shape[1], float(space.omega.min())), space.step)
    shown = np.abs(space.shown).max(axis=0)
    even = np.broadcast_to(np.abs(data).max() / shown, (len(data), space.count))
    own = FollowedMotion(data, noise, np.sqrt(squared), even)
    n = space.count
    for _ in range(DISCREPANCY.passes):  # a mode goes as freely as its own motion is large
        known = filtered_by(space, own, loose)
        squared = _about(known.states[:, :n] ** 2 + (known.states[:, n:] / space.omega) ** 2, space.omega, space.step)
        least = DISCREPANCY.min_amplitude * np.sqrt((squared * shown**2).max()) / shown
        own = replace(own, amplitude=np.sqrt(squared + least**2))
    return own


def _about(squared: FloatArray, omega: FloatArray, step: float) -> FloatArray:
    """Return the mean of squares (time, column) over the period of each column's ``omega`` (rad/s) about each time."""
    smooth = np.zeros_like(squared)
    for column, own in enumerate(omega):
        width = min(max(round(2 * np.pi / own / step), 1), len(squared))
        kernel = np.ones(width) / width
        padded = np.pad(squared[:, column], (width // 2, width - 1 - width // 2), mode="edge")
        smooth[:, column] = np.convolve(padded, kernel, mode="valid")
    return smooth


def filtered_by(space: ModalSpace, own: FollowedMotion, discrepancy: Discrepancy) -> FilteredMotion:
    """Return what a filter makes of a motion with a ``discrepancy``."""
    pushes = discrepancy.size**2 * space.omega**3 * space.step * own.amplitude**2
    begin = (DISCREPANCY.initial_amplitude * own.amplitude.max(axis=0)) ** 2
    variances = np.concatenate([begin, begin * space.omega**2])
    linearisation = own.linearisation or unforced(space, own.samples)
    noise = own.noise + (discrepancy.share * own.envelope) ** 2
    return filtered(linearisation, own.data, noise, pushes, variances, space.step)


def likeliest_discrepancy(
    motions: Sequence[tuple[ModalSpace, FollowedMotion]], start: Discrepancy, factors: Sequence[float]
) -> Discrepancy:
    """Return the discrepancy that is most probable in ``motions`` with their modes, from a ``start``: either part is
    changed by the ``factors``, the largest first, as long as it is better for it.
    """
    best, known = start, _LogPosteriors(motions)
    for factor in factors:
        moved = True
        while moved:
            moved = False
            for change in ((factor, 1.0), (1 / factor, 1.0), (1.0, factor), (1.0, 1 / factor)):
                while known.of(then := best.times(*change)) > known.of(best):
                    best, moved = then, True
    return best


@dataclass(frozen=True, eq=False)
class _LogPosteriors:
    """The log posterior of discrepancies in ``motions`` with their modes, each computed once."""

    motions: Sequence[tuple[ModalSpace, FollowedMotion]]
    known: dict[Discrepancy, float] = field(default_factory=dict)

    def of(self, discrepancy: Discrepancy) -> float:
        if discrepancy not in self.known:
            found = parallel_map(lambda pair: filtered_by(*pair, discrepancy).log_density, self.motions)
            self.known[discrepancy] = sum(found) + discrepancy.log_prior
        return self.known[discrepancy]
