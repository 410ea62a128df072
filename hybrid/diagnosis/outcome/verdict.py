"""How a diagnosis ends: from what its best fit leaves, and from the forecasts before and after."""

from dataclasses import dataclass
from enum import Enum
from math import inf

from fe_models.arrays import TINY
from fe_models.recordings import TOLERANCE
from hybrid.diagnosis.contest.neighbours import adjoin
from hybrid.diagnosis.fitting.calibration_deviation import deviation_of, deviation_of_groups
from hybrid.diagnosis.fitting.excess_energy import excess_energy
from hybrid.diagnosis.fitting.least_squares import Fit
from hybrid.diagnosis.outcome.config import VERDICT
from hybrid.diagnosis.recorded.noise import Band
from hybrid.diagnosis.recorded.noise_model import NoiseModel


class Verdict(Enum):
    """How a diagnosis ends."""

    NOTHING_WRONG = "nothing_wrong"
    EXPLAINED = "explained"
    PARTLY_EXPLAINED = "partly_explained"
    UNEXPLAINED = "unexplained"

    @property
    def is_wanting(self) -> bool:
        """Whether something is left that no cause explains."""
        return self in (Verdict.PARTLY_EXPLAINED, Verdict.UNEXPLAINED)


def is_at_floor(error: float | None, floor: float, tolerance: float) -> bool:
    """Return whether a forecast's ``error`` counts as reaching the noise floor."""
    return error is not None and error <= (1 + tolerance) * floor


@dataclass(frozen=True)
class Errors:
    """NRMSE of forecasts, mean over the measured channels: of the ``calibrated`` nominal model, of the ``extended``
    one, and the noise ``floor``. ``unexplained``: share of the nominal model's wrong energy that the extended one
    leaves; ``drawn``: the NRMSE of the nominal model as it is; ``by_chance``: whether a perfect model may have such
    errors as it or the calibrated one; ``tolerance``: the user's, see `Assumptions`.
    """

    calibrated: float
    extended: float
    floor: float
    unexplained: float
    drawn: float = inf
    by_chance: bool = False
    tolerance: float = TOLERANCE

    @property
    def without(self) -> float:
        """The error without any cause: few recordings may have led a calibration astray."""
        return min(self.drawn, self.calibrated)

    @property
    def nothing_to_gain(self) -> bool:
        """Whether the nominal model, calibrated, is as good as noise lets it be, and no cause makes it better."""
        gained = self.calibrated - self.extended
        return is_at_floor(self.calibrated, self.floor, self.tolerance) and gained <= self.tolerance * self.floor

    @property
    def reached(self) -> bool:
        """Whether the extended model is as good as noise lets it be."""
        return is_at_floor(self.extended, self.floor, self.tolerance)

    @property
    def near(self) -> bool:
        """Whether what the extended model still gets wrong is little beside noise."""
        return self.extended <= max(VERDICT.max_near_ratio, 1 + self.tolerance) * self.floor


def verdict_of(
    best: Fit, all_causes: Fit, base: Fit, noise_model: NoiseModel, band: Band, errors: Errors
) -> tuple[Verdict, float]:
    """Return the verdict on the ``best`` fit, and how probable it is that the list has what is wrong.

    ``all_causes``: the best fit with those, too, that hardly matter for forecasts. ``base``: the fit without any cause;
    that of the user's modal model, where this is wrong by itself.
    """
    significant = excess_energy(best, noise_model, band).significant
    rest = max(excess_energy(best, noise_model, band).total, best.misfit)
    share = rest / max(base.misfit, rest, TINY) if significant else 0.0
    beside = adjoin(best) or adjoin(all_causes)
    clearly = significant and max(share, errors.unexplained) < VERDICT.max_negligible_share
    forecast = errors.reached or errors.unexplained < VERDICT.max_negligible_share
    certain = clearly or (forecast and not (significant and share > VERDICT.max_certain_excess) and not beside)
    if errors.nothing_to_gain:
        return Verdict.NOTHING_WRONG, VERDICT.listed
    if not best.hypothesis.candidates and best.hypothesis.nominal is base.hypothesis.nominal:
        # in recordings that were never fitted
        calm = errors.by_chance or errors.without <= VERDICT.max_near_ratio * errors.floor
        return Verdict.NOTHING_WRONG if calm and not significant else Verdict.UNEXPLAINED, VERDICT.listed
    wholly = min(share, errors.unexplained) < VERDICT.max_explained_excess
    normal = deviation_of(best) <= VERDICT.max_usual_sigma or _is_explained(best, all_causes, noise_model, band)
    # how sure its parameters are adds to forecast errors
    all_told = not significant and errors.unexplained < VERDICT.max_explained_excess
    if normal and (errors.reached or (errors.near and wholly) or all_told or clearly):
        return Verdict.EXPLAINED, 1.0 if certain else VERDICT.listed
    single = len(best.hypothesis.candidates) == 1  # two with elements that go far may stand for anything
    if (
        single
        and errors.reached
        and errors.unexplained < VERDICT.max_explained_excess
        and deviation_of_groups(best) <= VERDICT.max_usual_sigma
    ):
        return Verdict.EXPLAINED, VERDICT.listed  # elements that are off by themselves took the rest
    helps = errors.extended <= errors.without  # what forecasts worse is no part of what is wrong
    # a calibration gone astray may leave as little
    partly = helps and min(share, errors.unexplained) < VERDICT.max_part_share
    return (Verdict.PARTLY_EXPLAINED if partly else Verdict.UNEXPLAINED), VERDICT.listed_in_part


def is_contradicted(before: float | None, after: float | None, errors: Errors) -> bool:
    """Return whether held-out sensors, where there are any, are forecast worse with what is named than without it."""
    return before is not None and after is not None and after - before > errors.tolerance * errors.floor


def _is_explained(best: Fit, all_causes: Fit, noise_model: NoiseModel, band: Band) -> bool:
    """Return whether the best fit's causes, with weak ones, leave nothing but noise, the calibration normal: what is
    astray without those stands for them.
    """
    named, more = ({candidate.key for candidate in item.hypothesis.candidates} for item in (best, all_causes))
    return (
        named < more
        and deviation_of(all_causes) <= VERDICT.max_usual_sigma
        and not excess_energy(all_causes, noise_model, band).significant
    )
