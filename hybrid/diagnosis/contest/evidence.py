"""What the recordings say of all causes at all places, alone, in some recordings only, and two at once."""

from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np

from fe_models.errors import InputError
from hybrid.diagnosis.causes.candidate import Candidate
from hybrid.diagnosis.contest.discrepancy import energy_over, in_units_of
from hybrid.diagnosis.contest.growing import ground_of
from hybrid.diagnosis.contest.posterior import Posterior, posterior_of
from hybrid.diagnosis.contest.setting import Setting
from hybrid.diagnosis.contest.stages import Search, forecasts_well
from hybrid.diagnosis.contest.straightening import fitted_as, straighten
from hybrid.diagnosis.fitting.far_off import DEVIATION, within
from hybrid.diagnosis.fitting.fitting import Fit, fit
from hybrid.diagnosis.fitting.left_over import left
from hybrid.diagnosis.nominal.geometry import Geometry
from hybrid.diagnosis.recorded.gauge import Gauge
from hybrid.diagnosis.recorded.noise import Band, excess

BEST = (1.02, 1.1)  # times the noise floor: mean and largest error of forecasts in which no cause would show
FITS = 1.05  # times the energy of noise: what a fit may leave in which no cause would show
NOISE_OFF = (0.5, 1.5)  # of the noise that the recordings themselves tell: how far it may be told anew
ANEW = 3  # times at most that geometry is taken along another motion: the best fit changes once or never
STAGES = (
    Search.apart,
    Search.nearby,
    Search.everywhere,
    Search.together,
    Search.promised,
    Search.in_groups,
    Search.beside,
    Search.alone,
    Search.anew,
)
GEOMETRIC = (
    "motions are so large that the frame's geometry shows: what it adds to a linear model was taken into account"
)
FAR_FROM_NOISE = "the nominal model leaves far more than noise: what it lacks counted as noise in the search"


@dataclass(frozen=True)
class Evidence:
    """``base``: the fit without any cause; ``posterior`` over all fits, of any of the ``candidates``; ``notes`` for the
    user.

    ``gauge``: with the noise of the recordings, in units of which the fits' costs are; ``searched``: with what counted
    as noise in the search, mostly the same (see `discrepancy`).
    """

    base: Fit
    posterior: Posterior
    gauge: Gauge
    searched: Gauge
    candidates: tuple[Candidate, ...]
    notes: tuple[str, ...] = ()

    @property
    def energy(self) -> float:
        """Of what counted as noise in the search, over that of the noise."""
        return energy_over(self.gauge, self.searched)

    def among(self, fits: tuple[Fit, ...]) -> Posterior:
        """Return the posterior over some of the fits, as the one over all: by what they leave in the search's units."""
        if self.gauge is self.searched:
            return posterior_of(fits, self.candidates)
        found = posterior_of(tuple(map(self.as_searched, fits)), self.candidates, is_astray=True)
        return replace(found, fits=tuple(in_units_of(self.gauge, item, self.searched) for item in found.fits))

    def as_searched(self, item: Fit) -> Fit:
        """Return a fit in units of what counted as noise in the search."""
        return item if self.gauge is self.searched else in_units_of(self.searched, item, self.gauge)


def gather(setting: Setting, tell: Callable[[str], object]) -> Evidence:
    """Return the evidence; ``tell`` hears what is being done, step by step."""
    tell("screening")
    search, fits = _single_causes(setting, tell)
    for stage in STAGES:
        known = search.posterior(fits).fits[0]
        fits = [*fits, *stage(search, fits)]
        search, fits = _straightened_anew(search, fits, known, setting.geometries)
    candidates, gauge, own = search.candidates, search.gauge, search.own
    notes = () if search.ground.hypothesis.plant.geometry is None else (GEOMETRIC,)
    if setting.is_astray:
        posterior = search.posterior(fits)
        energy = energy_over(own, gauge)
        note = f"{FAR_FROM_NOISE} ({np.sqrt(energy):.0f} times the noise was taken as such)"
        judged = tuple(search.judged(item) for item in posterior.fits)
        told = replace(posterior, fits=judged)
        return Evidence(search.judged(fits[0]), told, own, gauge, candidates, (*notes, note))
    gauge, fits = _with_better_noise(fits, gauge, setting.band)
    posterior = _with_same_noise(posterior_of(tuple(fits), candidates), fits[0], gauge, candidates)
    return Evidence(fits[0], posterior, gauge, gauge, candidates, notes)


def _single_causes(setting: Setting, tell: Callable[[str], object]) -> tuple[Search, list[Fit]]:
    """Return the search, and the fits without any cause and of each alone, in recordings less what geometry adds."""
    gauge, lengths, geometries = setting.searched, setting.lengths, setting.geometries
    ground = ground_of(setting.nominal, setting.nominal.centre, lengths, gauge, setting.short)
    if ground is None:
        raise InputError("model: with its own force laws these recordings' motion grows beyond all bounds; check them")
    ground, lengths = straighten(ground, ground.whole, lengths, gauge, geometries)
    search = Search(ground, lengths, setting.candidates(), gauge, setting.gauge, setting.band, tell)
    fits = [ground.whole]
    if setting.is_astray or not _nothing_to_gain(ground.whole, gauge, setting.band):
        fits += search.singles()
        nearest = min(fits, key=lambda item: item.charged)
        ground, lengths = straighten(ground, nearest, lengths, gauge, geometries)
        fits = [ground.whole, *fitted_as(ground.whole, fits[1:], gauge)]
    own = setting.gauge
    if not setting.is_astray:
        gauge, fits = _with_better_noise(fits, gauge, setting.band)
        own = gauge
    return replace(search, ground=ground, lengths=lengths, gauge=gauge, own=own), fits


def _straightened_anew(
    search: Search, fits: list[Fit], known: Fit, geometries: tuple[Geometry, ...]
) -> tuple[Search, list[Fit]]:
    """Return the search and the fits, in recordings less what geometry adds to the motion of the best of them.

    While that is another than the one ``known`` before: along the motion of a wrong cause geometry may seem to add
    nothing, and hide the right one. Changes between recordings stay as they are found.
    """
    for _ in range(ANEW):
        best = search.posterior(fits).fits[0]
        if best.hypothesis.candidates == known.hypothesis.candidates or any(
            b.off for item in fits for b in item.batches
        ):
            break
        known = best
        ground, lengths = straighten(search.ground, best, search.lengths, search.gauge, geometries)
        if ground is search.ground:
            break
        search = replace(search, ground=ground, lengths=lengths)
        fits = [ground.whole, *fitted_as(ground.whole, fits[1:], search.gauge)]
    return search, fits


def _nothing_to_gain(base: Fit, gauge: Gauge, band: Band) -> bool:
    """Return whether the nominal model, calibrated within its uncertainty, fits and forecasts as noise lets it."""
    own_gauge, (own,) = _with_better_noise([base], gauge, band)
    return own.chi2 < FITS * own.values and forecasts_well(replace(own, theta=within(own, DEVIATION)), own_gauge, BEST)


def _with_better_noise(fits: list[Fit], gauge: Gauge, band: Band) -> tuple[Gauge, list[Fit]]:
    """Return the gauge with the noise that the best fit leaves above the structure's band, and fits rescaled to it."""
    best = min(fits, key=lambda item: item.charged)
    scale = np.clip(excess(best.residuals, gauge.rate, band).sigma, *NOISE_OFF)
    if left(best, gauge, band).significant:  # of what the best fit leaves there some is no noise
        scale = np.minimum(scale, 1.0)
    better = replace(gauge, sigma=gauge.sigma * scale)
    usual = float(np.sqrt(np.mean(scale**2)))

    def rescaled(item: Fit) -> Fit:
        grown = np.where(np.arange(len(item.theta)) < item.hypothesis.nuisances, 1.0, usual)  # nominal values are known
        covariance, errors = item.covariance * np.outer(grown, grown), tuple(usual * part for part in item.state_errors)
        return replace(in_units_of(better, item, gauge), covariance=covariance, state_errors=errors)

    return better, [rescaled(item) for item in fits]


def _with_same_noise(posterior: Posterior, base: Fit, gauge: Gauge, candidates: tuple[Candidate, ...]) -> Posterior:
    """Return the posterior with its best fit found anew: the earlier one was with other noise, and so its errors."""
    best = posterior.fits[0]
    again = None if best is base else fit(best.hypothesis, best.theta, best.batches, gauge, best.states)
    return posterior if again is None else posterior_of((again, *posterior.fits[1:]), candidates)
