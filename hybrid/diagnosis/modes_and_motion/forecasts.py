"""MotionForecasts of recordings by the structure as it was drawn, and by that with what was found.

Either goes on from the first fifth of a recording. What was found goes by its modes as the recordings for training have
them: a real structure's are some thousandths off those of any model.
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from fe_models.recordings import TOLERANCE, Dataset
from hybrid.diagnosis.discrepancy.expected_modes import MotionClaim, expectation_of
from hybrid.diagnosis.discrepancy.forecasting import Forecaster
from hybrid.diagnosis.discrepancy.modal_space import ModalSpace
from hybrid.diagnosis.discrepancy.recorded_motions import noise_in
from hybrid.diagnosis.fitting.forecast_score import ForecastScore, joined, shown_of
from hybrid.diagnosis.modal.error_sizes import ErrorSizes
from hybrid.diagnosis.modal.evidence import as_drawn
from hybrid.diagnosis.modal.modal_data import ModalData
from hybrid.diagnosis.modal.nominal_fit import NominalFit
from hybrid.diagnosis.modes_and_motion.left_out import LeftOut, in_turn
from hybrid.diagnosis.modes_and_motion.motion_fit import MotionFit
from hybrid.diagnosis.observed.example import Example
from hybrid.diagnosis.outcome.config import VERDICT
from hybrid.diagnosis.outcome.forecasts import share_left
from hybrid.diagnosis.outcome.verdict import is_at_floor
from hybrid.diagnosis.recorded.batches import Batch, batches_of, measured_columns
from hybrid.diagnosis.recorded.noise_model import NoiseModel, SensorRoles


@dataclass(frozen=True, eq=False, repr=False)
class MotionForecasts:
    """The scores of the structure as drawn, ``before``, and with what was found, ``after``; one recording as an
    ``example``; ``roles``: which sensors are measured; ``tolerance``: the user's, see `Assumptions`; whether recordings
    are among them that are ``alone`` in their state, of which but the first fifth was known, and then the forecasts of
    the others, whose states are ``shared``, None where there are none.
    """

    before: ForecastScore
    after: ForecastScore
    example: Example
    roles: SensorRoles
    tolerance: float = TOLERANCE
    alone: bool = False
    shared: "MotionForecasts | None" = None

    @property
    def scores(self) -> dict[str, dict[str, float | None]]:
        """The NRMSE of both, of the measured and of the held-out channels (None without any)."""
        own = list(self.roles.measured)
        apart = [column for column, sensor in enumerate(self.roles.sensors) if sensor.role == "held_out"]
        return {
            name: {
                "measured": float(found.nrmse[:, own].mean()),
                "held_out": float(found.nrmse[:, apart].mean()) if apart else None,
            }
            for name, found in (("baseline", self.before), ("extended", self.after))
        }

    @property
    def floor(self) -> float:
        """The NRMSE that noise alone makes, mean over the measured channels."""
        return float(self.after.floor[:, list(self.roles.measured)].mean())

    @property
    def reach_noise(self) -> bool:
        """Whether what was found forecasts as well as the noise lets it, or nearly so, and leaves next to nothing."""
        error = float(self.after.nrmse[:, list(self.roles.measured)].mean())
        nearly = error <= VERDICT.max_near_ratio * self.floor and self.unexplained < VERDICT.max_explained_excess
        return is_at_floor(error, self.floor, self.tolerance) or nearly or self.unexplained < VERDICT.max_certain_excess

    @property
    def unexplained(self) -> float:
        """The share of the drawn structure's wrong energy that is left."""
        return share_left(self.before, self.after)


@dataclass(frozen=True, eq=False)
class ForecastMotion:
    """A motion as it was ``explained``, and its ``forecasts``, None where none are made."""

    explained: MotionFit
    forecasts: MotionForecasts | None

    @classmethod
    def of(cls, dataset: Dataset, drawn: NominalFit, motion: MotionFit) -> "ForecastMotion":
        """Return the motion with the forecasts of a dataset: see `motion_forecasts_of`."""
        return cls(motion, motion_forecasts_of(dataset, drawn, motion))

    @property
    def is_at_noise(self) -> bool:
        """Whether no cause could make forecasts better; without any, whether what the filter sees beside is usual."""
        if self.forecasts is None:
            return self.explained.track.discrepancy.is_small
        return self.forecasts.reach_noise


def motion_forecasts_of(dataset: Dataset, drawn: NominalFit, motion: MotionFit) -> MotionForecasts | None:
    """Return the forecasts of the recordings for testing by the ``drawn`` structure, and as the ``motion`` was
    explained; without any, those of the recordings for training, each by what was fitted to others (`in_turn`).

    None where known forces drove them, there is but one, the drawn structure has no modes, or no first fifth shows any.
    """
    if any(recording.is_driven for recording in dataset.recordings):
        return None
    parts = [LeftOut.of(dataset, motion)] if dataset.select("test") else in_turn(dataset, motion)
    spaces = _drawn(dataset, drawn) if parts else []
    if not spaces:
        return None
    each = [_forecasts(part, drawn.measured, spaces) for part in parts]
    shared = [own for own, part in zip(each, parts, strict=True) if part.state is None]
    if len(shared) == len(each):
        return _joined(each)
    return replace(_joined(each), alone=True, shared=_joined(shared) if shared else None)


def _joined(parts: Sequence[MotionForecasts]) -> MotionForecasts:
    """Return the forecasts of all ``parts``, with the example of the first."""
    before, after = joined([part.before for part in parts]), joined([part.after for part in parts])
    return replace(parts[0], before=before, after=after)


def _forecasts(left_out: LeftOut, measured: ModalData, drawn: Sequence[ModalSpace]) -> MotionForecasts:
    """Return the forecasts of the recordings for testing; ``drawn``: the modes of the structure as it was drawn, that
    of ``measured``.
    """
    roles, train, test = _batches(left_out.dataset, left_out.measured)
    before = Forecaster.of(drawn, measured.nominal, None, train, roles)
    after = Forecaster.of(left_out.spaces, left_out.measured.nominal, left_out.law, train, roles)
    if left_out.state is not None:
        after = after.of_state(left_out.state)
    example, tolerance = _example(test[0].take([0]), before, after), left_out.dataset.assumptions.tolerance
    return MotionForecasts(before.score(test), after.score(test), example, roles, tolerance)


def scored_by(spaces: Sequence[ModalSpace], measured: ModalData, dataset: Dataset, state: int) -> ForecastScore:
    """Return how well modes, one space for each state that a structure may be in, forecast recordings for testing,
    which are known to be of the ``state`` with that number.
    """
    roles, train, test = _batches(dataset, measured)
    return Forecaster.of(spaces, measured.nominal, None, train, roles).of_state(state).score(test)


def _batches(dataset: Dataset, measured: ModalData) -> tuple[SensorRoles, tuple[Batch, ...], tuple[Batch, ...]]:
    """Return what recordings show, and those for training and for testing with their noise, all channels of them."""
    own = measured_columns(dataset)
    usual, levels = noise_in(dataset, measured)
    sensors = tuple(dataset.sensors[column] for column in own)
    roles = SensorRoles(dataset.sensors, own, NoiseModel(sensors, dataset.sampling_rate, usual))
    train, test = (
        tuple(levels.beside(batch, own) for batch in batches_of(dataset, role)) for role in ("train", "test")
    )
    return roles, train, test


def _drawn(dataset: Dataset, drawn: NominalFit) -> list[ModalSpace]:
    """Return the modes of a structure as it was drawn."""
    fit = as_drawn(drawn.measured, drawn.fit)
    expected = expectation_of(MotionClaim(drawn.measured, fit, 1 / dataset.sampling_rate, (0,), ErrorSizes()))
    return [] if expected is None else [modes.space for modes in expected.modes]


def _example(batch: Batch, before: Forecaster, after: Forecaster) -> Example:
    """Return a recording as both forecast it."""
    first, roles = shown_of(batch.samples), before.roles
    rate = roles.noise_model.rate
    drawn, extended = (own.forecast(batch)[0, first:] for own in (before, after))
    omega = np.abs(np.linalg.eigvals(after.systems[0].A[0]))
    frequencies = np.unique(np.round(omega / (2 * np.pi), 9))
    measured = batch.recorded[0, first:]
    return Example(batch.names[0], rate, first / rate, roles.sensors, measured, drawn, extended, frequencies)
