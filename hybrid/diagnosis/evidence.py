"""What the recordings say of all causes at all places, alone, in some recordings only, and two at once."""

from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np

from fe_models.errors import InputError
from hybrid.diagnosis.candidate import Candidate
from hybrid.diagnosis.changes import changes_beside, groups_in
from hybrid.diagnosis.discrepancy import in_units_of
from hybrid.diagnosis.fitting import Fit, fit
from hybrid.diagnosis.forecasting import DEVIATION, forecast, model_of, within
from hybrid.diagnosis.frame import Frame
from hybrid.diagnosis.neighbours import fits_beside
from hybrid.diagnosis.noise import Band, excess
from hybrid.diagnosis.pairs import asks_for_more, factors_off, is_hopeless, left, pair_fits
from hybrid.diagnosis.posterior import Posterior, posterior_of
from hybrid.diagnosis.recording_groups import asked_for, clear_groups
from hybrid.diagnosis.search import contest, ground_of
from hybrid.diagnosis.setting import Setting
from hybrid.diagnosis.straightening import fitted_as, straighten
from hybrid.diagnosis.switching import fit_switched

BEST = (1.02, 1.1)  # times the noise floor: mean and largest error of forecasts in which no cause would show
FITS = 1.05  # times the energy of noise: what a fit may leave in which no cause would show
WELL = (1.05, 1.25)  # likewise where a second cause would not show
NOISE_OFF = (0.5, 1.5)  # of the noise that the recordings themselves tell: how far it may be told anew
GEOMETRIC = (
    "motions are so large that the frame's geometry shows: what it adds to a linear model was taken into account"
)
FAR_FROM_NOISE = "the nominal model leaves far more than noise: what it lacks counted as noise in the search"


@dataclass(frozen=True)
class Evidence:
    """``base``: the fit without any cause; ``posterior`` over all fits; ``frame``: with the noise of their units.

    ``energy``: of what counted as noise in the search, over that of the noise.
    """

    base: Fit
    posterior: Posterior
    frame: Frame
    candidates: tuple[Candidate, ...]
    notes: tuple[str, ...] = ()
    energy: float = 1.0

    def among(self, fits: tuple[Fit, ...]) -> Posterior:
        """Return the posterior over some of the fits, tempered as in the search."""
        found = posterior_of(fits, self.candidates)
        return replace(found, temper=max(found.temper / self.energy, 1.0))


def gather(setting: Setting, tell: Callable[[str], object]) -> Evidence:
    """Return the evidence; ``tell`` hears what is being done, step by step."""
    tell("screening")
    plant, frame, band, lengths = setting.plant, setting.searched, setting.band, setting.lengths
    candidates, nominal = setting.candidates(), setting.nominal
    ground = ground_of(nominal, nominal.centre, lengths, frame, setting.short)
    if ground is None:
        raise InputError("model: with its own force laws these recordings' motion grows beyond all bounds; check them")
    ground, lengths = straighten(ground, ground.whole, lengths, frame, setting.geometry)
    fits = [ground.whole]
    if setting.is_astray or not _nothing_to_gain(ground.whole, frame, band):
        fits += contest(ground, candidates, lengths, frame, lambda: tell("single causes"))
        nearest = min(fits, key=lambda item: item.cost)
        ground, lengths = straighten(ground, nearest, lengths, frame, setting.geometry)
        fits = [ground.whole, *fitted_as(ground.whole, fits[1:], frame)]
    notes = () if ground.hypothesis.plant.geometry is None else (GEOMETRIC,)
    if not setting.is_astray:
        frame, fits = _with_better_noise(fits, frame, band)
    noise = setting.frame if setting.is_astray else frame

    def judged(item: Fit) -> Fit:
        return in_units_of(noise, item, frame) if setting.is_astray else item

    def enough(item: Fit) -> bool:  # then nothing more could matter
        return forecasts_well(judged(item), noise, WELL) and not factors_off(item)

    posterior = posterior_of(tuple(fits), candidates)
    best = posterior.fits[0]
    wanting = factors_off(best) or left(judged(best), noise, band).significant
    if wanting and not plant.laws and not enough(best):
        tell("recordings apart")
        lasting = tuple(item for item in posterior.fits if item.hypothesis.candidates)[:1]
        asked = asked_for(ground.short, candidates, frame)
        fits += fit_switched(ground.short, best, asked, lengths, frame)
        posterior = posterior_of(tuple(fits), candidates)
        if not enough(posterior.fits[0]):
            groups = clear_groups(asked, ground.whole.batches)
            fits += changes_beside(ground, groups, lasting, candidates, frame, band, lambda: tell("recordings apart"))
            posterior = posterior_of(tuple(fits), candidates)
    best = posterior.fits[0]
    if not enough(best) and asks_for_more(judged(best), judged(fits[0]), noise, band):
        tell("two causes")
        fits += pair_fits(posterior, candidates, lengths.whole, frame, band, lambda: tell("two causes"))
        posterior = posterior_of(tuple(fits), candidates)
    mixed = None if is_hopeless(posterior.fits[0], fits[0]) else groups_in(posterior)
    if mixed is not None and not enough(posterior.fits[0]):
        fits += changes_beside(ground, mixed, (), candidates, frame, band, lambda: tell("recordings apart"))
    nearest = posterior_of(tuple(fits), candidates).fits[0]
    fits += fits_beside(nearest, fits[0], candidates, frame, lambda: tell("places next to it"))
    if setting.is_astray:
        posterior = posterior_of(tuple(fits), candidates)
        energy = float(np.mean((frame.sigma / noise.sigma) ** 2))
        note = f"{FAR_FROM_NOISE} ({np.sqrt(energy):.0f} times the noise was taken as such)"
        told = replace(posterior, fits=tuple(judged(item) for item in posterior.fits))
        return Evidence(judged(fits[0]), told, noise, candidates, (*notes, note), energy)
    frame, fits = _with_better_noise(fits, frame, band)
    posterior = _with_same_noise(posterior_of(tuple(fits), candidates), fits[0], frame, candidates)
    return Evidence(fits[0], posterior, frame, candidates, notes)


def _nothing_to_gain(base: Fit, frame: Frame, band: Band) -> bool:
    """Return whether the nominal model, calibrated within its uncertainty, fits and forecasts as noise lets it."""
    own_frame, (own,) = _with_better_noise([base], frame, band)
    return own.chi2 < FITS * own.values and forecasts_well(replace(own, theta=within(own, DEVIATION)), own_frame, BEST)


def forecasts_well(item: Fit, frame: Frame, limits: tuple[float, float]) -> bool:
    """Return whether a fit forecasts the recordings that it was fitted to, each from its first fifth, as well as noise
    lets it: their NRMSE over the noise floor, mean and largest, within ``limits``.
    """
    found = forecast(model_of(item, frame), item.batches, frame.sensors, frame.positions, frame)
    over = found.nrmse.mean(axis=1) / found.floor.mean(axis=1)  # (recording,)
    return bool(over.mean() <= limits[0] and over.max() <= limits[1])


def _with_better_noise(fits: list[Fit], frame: Frame, band: Band) -> tuple[Frame, list[Fit]]:
    """Return the frame with the noise that the best fit leaves above the structure's band, and fits rescaled to it."""
    best = min(fits, key=lambda item: item.cost)
    scale = np.clip(excess(best.residuals, frame.rate, band).sigma, *NOISE_OFF)

    def rescaled(item: Fit) -> Fit:
        residuals = tuple(part / scale for part in item.residuals)
        chi2 = sum(float(np.square(part).sum()) for part in residuals)
        return replace(item, residuals=residuals, chi2=chi2, cost=item.cost - item.chi2 + chi2)

    return replace(frame, sigma=frame.sigma * scale), [rescaled(item) for item in fits]


def _with_same_noise(posterior: Posterior, base: Fit, frame: Frame, candidates: tuple[Candidate, ...]) -> Posterior:
    """Return the posterior with its best fit found anew: the earlier one was with other noise, and so its errors."""
    best = posterior.fits[0]
    again = None if best is base else fit(best.hypothesis, best.theta, best.batches, frame, best.states)
    return posterior if again is None else posterior_of((again, *posterior.fits[1:]), candidates)
