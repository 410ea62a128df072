"""What the recordings say of all causes at all places, alone, in some recordings only, and two at once."""

from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np

from fe_models.causes.candidate import Candidate
from fe_models.errors import InputError
from hybrid.diagnosis.contest.config import NOISE_LEVEL
from hybrid.diagnosis.contest.discrepancy import energy_over, in_units_of
from hybrid.diagnosis.contest.growing import reference_fits_of
from hybrid.diagnosis.contest.pairs import is_hopeless
from hybrid.diagnosis.contest.posterior import Posterior, posterior_of
from hybrid.diagnosis.contest.setting import Setting
from hybrid.diagnosis.contest.stages import Search, forecasts_well
from hybrid.diagnosis.contest.straightening import fitted_as, straighten
from hybrid.diagnosis.fitting.calibration_deviation import within
from hybrid.diagnosis.fitting.config import CALIBRATION
from hybrid.diagnosis.fitting.excess_energy import excess_energy
from hybrid.diagnosis.fitting.least_squares import Fit, fit
from hybrid.diagnosis.nominal.geometry import Geometry
from hybrid.diagnosis.recorded.noise import Band, excess
from hybrid.diagnosis.recorded.noise_model import NoiseModel
from hybrid.diagnosis.stage_names import SEARCH

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
OF_PAIRS = (Search.together, Search.in_groups)
GEOMETRIC = (
    "motions are so large that the frame's geometry shows: what it adds to a linear model was taken into account"
)
FAR_FROM_NOISE = "the nominal model leaves far more than noise: what it lacks counted as noise in the search"


@dataclass(frozen=True)
class Evidence:
    """``base``: the fit without any cause; ``posterior`` over all fits, of any of the ``candidates``; ``notes`` for the
    user.

    ``noise_model``: with the noise of the recordings, in units of which the fits' costs are; ``searched``: with what
    counted as noise in the search, mostly the same (see `discrepancy`).
    """

    base: Fit
    posterior: Posterior
    noise_model: NoiseModel
    searched: NoiseModel
    candidates: tuple[Candidate, ...]
    notes: tuple[str, ...] = ()

    @property
    def energy(self) -> float:
        """Of what counted as noise in the search, over that of the noise."""
        return energy_over(self.noise_model, self.searched)

    def among(self, fits: tuple[Fit, ...]) -> Posterior:
        """Return the posterior over some of the fits, as the one over all: by what they leave in the search's units."""
        if self.noise_model is self.searched:
            return posterior_of(fits, self.candidates)
        found = posterior_of(tuple(map(self.as_searched, fits)), self.candidates, is_astray=True)
        return replace(found, fits=tuple(in_units_of(self.noise_model, item, self.searched) for item in found.fits))

    def as_searched(self, item: Fit) -> Fit:
        """Return a fit in units of what counted as noise in the search."""
        return item if self.noise_model is self.searched else in_units_of(self.searched, item, self.noise_model)


@dataclass(frozen=True, eq=False)
class Singles:
    """The ``fits`` in a ``setting`` without any cause and of each alone, from which a ``search`` goes on."""

    setting: Setting
    search: Search
    fits: list[Fit]

    @classmethod
    def of(cls, setting: Setting, tell: Callable[[str], object]) -> "Singles":
        """Return them; ``tell`` hears the name of the stage (`stage_names`), and what is done in it."""
        tell("single causes")
        return cls(setting, *_single_causes(setting, tell))

    @property
    def are_hopeless(self) -> bool:
        """Whether the best of them leaves more than noise, and so much that it is hardly right: of a frame the search
        goes on for minutes then.
        """
        best = self.search.posterior(self.fits).fits[0]
        return is_hopeless(best, self.fits[0]) and self.search.is_wanting(best)


def gather(singles: Singles, tell: Callable[[str], object], pairs: bool = True) -> Evidence:
    """Return the evidence; ``tell`` hears the name of each stage (`stage_names`), and what is done in it.

    ``pairs``: whether two causes at once are tried, which takes minutes of a frame.
    """
    setting, search, fits = singles.setting, singles.search, singles.fits
    for stage, name in zip(STAGES, SEARCH, strict=True):
        tell(name)
        if stage in OF_PAIRS and not pairs:
            continue
        known = search.posterior(fits).fits[0]
        fits = [*fits, *stage(search, fits)]
        search, fits = _straightened_anew(search, fits, known, setting.geometries)
    candidates, noise_model, own = search.candidates, search.noise_model, search.own
    notes = () if search.reference.hypothesis.nominal.geometry is None else (GEOMETRIC,)
    if setting.is_astray:
        posterior = search.posterior(fits)
        energy = energy_over(own, noise_model)
        note = f"{FAR_FROM_NOISE} ({np.sqrt(energy):.0f} times the noise was taken as such)"
        judged = [search.judged(item) for item in (fits[0], *posterior.fits)]
        if min(item.misfit for item in judged) < NOISE_LEVEL.max_share_left * judged[0].misfit:
            own, judged = _with_better_noise(judged, own, setting.band)
        told = replace(posterior, fits=tuple(judged[1:]))
        return Evidence(judged[0], told, own, noise_model, candidates, (*notes, note))
    noise_model, fits = _with_better_noise(fits, noise_model, setting.band)
    posterior = _with_same_noise(posterior_of(tuple(fits), candidates), fits[0], noise_model, candidates)
    return Evidence(fits[0], posterior, noise_model, noise_model, candidates, notes)


def _single_causes(setting: Setting, tell: Callable[[str], object]) -> tuple[Search, list[Fit]]:
    """Return the search, and the fits without any cause and of each alone, in recordings less what geometry adds."""
    noise_model, lengths, geometries = setting.searched, setting.lengths, setting.geometries
    reference = reference_fits_of(
        setting.nominal_hypothesis, setting.nominal_hypothesis.centre, lengths, noise_model, setting.short
    )
    if reference is None:
        raise InputError("model: with its own force laws these recordings' motion grows beyond all bounds; check them")
    reference, lengths = straighten(reference, reference.whole, lengths, noise_model, geometries)
    search = Search(reference, lengths, setting.candidates(), noise_model, setting.noise_model, setting.band, tell)
    fits = [reference.whole]
    if setting.is_astray or not _nothing_to_gain(reference.whole, noise_model, setting.band):
        fits += search.singles()
        nearest = min(fits, key=lambda item: item.charged)
        reference, lengths = straighten(reference, nearest, lengths, noise_model, geometries)
        fits = [reference.whole, *fitted_as(reference.whole, fits[1:], noise_model)]
    own = setting.noise_model
    if not setting.is_astray:
        noise_model, fits = _with_better_noise(fits, noise_model, setting.band)
        own = noise_model
    return replace(search, reference=reference, lengths=lengths, noise_model=noise_model, own=own), fits


def _straightened_anew(
    search: Search, fits: list[Fit], known: Fit, geometries: tuple[Geometry, ...]
) -> tuple[Search, list[Fit]]:
    """Return the search and the fits, in recordings less what geometry adds to the motion of the best of them.

    While that is another than the one ``known`` before: along the motion of a wrong cause geometry may seem to add
    nothing, and hide the right one. Changes between recordings stay as they are found.
    """
    for _ in range(NOISE_LEVEL.max_geometry_passes):
        best = search.posterior(fits).fits[0]
        if best.hypothesis.candidates == known.hypothesis.candidates or any(
            b.off for item in fits for b in item.batches
        ):
            break
        known = best
        reference, lengths = straighten(search.reference, best, search.lengths, search.noise_model, geometries)
        if reference is search.reference:
            break
        search = replace(search, reference=reference, lengths=lengths)
        fits = [reference.whole, *fitted_as(reference.whole, fits[1:], search.noise_model)]
    return search, fits


def _nothing_to_gain(base: Fit, noise_model: NoiseModel, band: Band) -> bool:
    """Return whether the nominal model, calibrated within its uncertainty, fits and forecasts as noise lets it."""
    own_gauge, (own,) = _with_better_noise([base], noise_model, band)
    return own.chi2 < NOISE_LEVEL.max_clean_energy_ratio * own.values and forecasts_well(
        replace(own, theta=within(own, CALIBRATION.max_deviation_sigma)), own_gauge, NOISE_LEVEL.max_clean_ratios
    )


def _with_better_noise(fits: list[Fit], noise_model: NoiseModel, band: Band) -> tuple[NoiseModel, list[Fit]]:
    """Return the noise model with the noise that the best fit leaves above the structure's band, and fits rescaled to
    it.
    """
    best = min(fits, key=lambda item: item.charged)
    scale = np.clip(excess(best.residuals, noise_model.rate, band).sigma, *NOISE_LEVEL.new_ratios)
    if excess_energy(best, noise_model, band).significant:  # of what the best fit leaves there some is no noise
        scale = np.minimum(scale, 1.0)
    better = replace(noise_model, sigma=noise_model.sigma * scale)
    usual = float(np.sqrt(np.mean(scale**2)))

    def rescaled(item: Fit) -> Fit:
        grown = np.where(np.arange(len(item.theta)) < item.hypothesis.nuisances, 1.0, usual)  # nominal values are known
        covariance, errors = item.covariance * np.outer(grown, grown), tuple(usual * part for part in item.state_errors)
        return replace(in_units_of(better, item, noise_model), covariance=covariance, state_errors=errors)

    return better, [rescaled(item) for item in fits]


def _with_same_noise(
    posterior: Posterior, base: Fit, noise_model: NoiseModel, candidates: tuple[Candidate, ...]
) -> Posterior:
    """Return the posterior with its best fit found anew: the earlier one was with other noise, and so its errors."""
    best = posterior.fits[0]
    again = None if best is base else fit(best.hypothesis, best.theta, best.batches, noise_model, best.states)
    return posterior if again is None else posterior_of((again, *posterior.fits[1:]), candidates)
