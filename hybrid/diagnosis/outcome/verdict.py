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
from hybrid.diagnosis.recorded.noise import Band
from hybrid.diagnosis.recorded.noise_model import NoiseModel

BESIDE = 0.01  # of the noise floor: by how much a second cause must improve the forecast; a first one by the user's
# tolerance: beside one that the simulation is wrong is no longer asked, but in what
WHOLLY = 0.03  # of the excess energy: what may be left where all is called explained
# Of what was wrong, in fit and forecast: where less is left, it is what interpolation and steps leave of recordings
# with next to no noise, and no further cause.
CLEARLY = 1e-3
NEAR = 1.15  # times the noise floor: as near as a model that is off by its uncertainty must come
PARTLY = 0.5  # of it: beyond, nothing is
ABNORMAL = 4.0  # stated standard deviations: a calibration that far off takes the place of something else that is wrong
LISTED = 0.85  # probability that the list has what is wrong, where something significant is left or two causes adjoin;
LISTED_IN_PART = 0.25  # and where a part only is explained: in blind cases such a name is wrong where what was hidden
# is not on the list, and mostly right where it is one of two causes


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
        return self.extended <= max(NEAR, 1 + self.tolerance) * self.floor


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
    clearly = significant and max(share, errors.unexplained) < CLEARLY
    forecast = errors.reached or errors.unexplained < CLEARLY
    certain = clearly or (forecast and not (significant and share > WHOLLY / 3) and not beside)
    if errors.nothing_to_gain:
        return Verdict.NOTHING_WRONG, LISTED
    if not best.hypothesis.candidates and best.hypothesis.nominal is base.hypothesis.nominal:
        calm = errors.by_chance or errors.without <= NEAR * errors.floor  # in recordings that were never fitted
        return Verdict.NOTHING_WRONG if calm and not significant else Verdict.UNEXPLAINED, LISTED
    wholly = min(share, errors.unexplained) < WHOLLY
    normal = deviation_of(best) <= ABNORMAL or _is_explained(best, all_causes, noise_model, band)
    all_told = not significant and errors.unexplained < WHOLLY  # how sure its parameters are adds to forecast errors
    if normal and (errors.reached or (errors.near and wholly) or all_told or clearly):
        return Verdict.EXPLAINED, 1.0 if certain else LISTED
    single = len(best.hypothesis.candidates) == 1  # two with elements that go far may stand for anything
    if single and errors.reached and errors.unexplained < WHOLLY and deviation_of_groups(best) <= ABNORMAL:
        return Verdict.EXPLAINED, LISTED  # elements that are off by themselves took the rest
    helps = errors.extended <= errors.without  # what forecasts worse is no part of what is wrong
    partly = helps and min(share, errors.unexplained) < PARTLY  # a calibration gone astray may leave as little
    return (Verdict.PARTLY_EXPLAINED if partly else Verdict.UNEXPLAINED), LISTED_IN_PART


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
        and deviation_of(all_causes) <= ABNORMAL
        and not excess_energy(all_causes, noise_model, band).significant
    )
