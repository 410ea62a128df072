"""What the recordings say of all causes at all places, alone, in some recordings only, and two at once."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace

import numpy as np

from fe_models.errors import InputError
from hybrid.diagnosis.causes.candidate import Candidate
from hybrid.diagnosis.contest.changes import changes_beside, groups_in
from hybrid.diagnosis.contest.discrepancy import in_units_of
from hybrid.diagnosis.contest.growing import Ground, Lengths, fit_growing, ground_of, padded
from hybrid.diagnosis.contest.neighbours import fits_beside
from hybrid.diagnosis.contest.pairs import (
    HELPLESS,
    asks_for_more,
    each_alone,
    factors_off,
    is_hopeless,
    left,
    misfit,
    pair_fits,
)
from hybrid.diagnosis.contest.posterior import Posterior, posterior_of
from hybrid.diagnosis.contest.recording_groups import asked_for, clear_groups
from hybrid.diagnosis.contest.search import contest
from hybrid.diagnosis.contest.setting import Setting
from hybrid.diagnosis.contest.straightening import fitted_as, straighten
from hybrid.diagnosis.contest.switching import fit_switched
from hybrid.diagnosis.fitting.fitting import Fit, fit
from hybrid.diagnosis.fitting.forecasting import DEVIATION, forecast, model_of, within
from hybrid.diagnosis.recorded.frame import Frame
from hybrid.diagnosis.recorded.noise import Band, excess

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


@dataclass(frozen=True)
class _Search:
    """What is searched beside the ``ground``, with the noise of its ``frame``; ``own``: with that of the recordings.

    Each stage returns further fits, given all ``fits`` so far, the first of them without any cause; ``tell`` hears
    which it is.
    """

    ground: Ground
    lengths: Lengths
    candidates: tuple[Candidate, ...]
    frame: Frame
    own: Frame
    band: Band
    tell: Callable[[str], object]

    def singles(self) -> list[Fit]:
        """Return fits of each cause alone."""
        return list(contest(self.ground, self.candidates, self.lengths, self.frame, self._hears("single causes")))

    def apart(self, fits: list[Fit]) -> list[Fit]:
        """Return fits of causes that act in some recordings only, alone or beside another one."""
        posterior = self.posterior(fits)
        best = posterior.fits[0]
        if not self.is_wanting(best) or self.ground.hypothesis.plant.laws or self.is_enough(best):
            return []
        hears = self._hears("recordings apart")
        hears()
        asked = asked_for(self.ground.short, self.candidates, self.frame)
        found = fit_switched(self.ground.short, best, asked, self.lengths, self.frame)
        after = self.posterior([*fits, *found])
        best = after.fits[0]
        if not self.is_wanting(best) or self.is_ample(best):
            return found
        parted = any(batch.off for batch in best.batches)
        groups = groups_in(after) if parted else clear_groups(asked, self.lengths.whole)
        lasting = _lasting(posterior, fits[0])
        return found + changes_beside(self.ground, groups, lasting, self.candidates, self.frame, self.band, hears)

    def together(self, fits: list[Fit]) -> list[Fit]:
        """Return fits of two causes at once."""
        posterior = self.posterior(fits)
        best = posterior.fits[0]
        if self.is_ample(best) or not asks_for_more(self.judged(best), self.judged(fits[0]), self.own, self.band):
            return []
        hears = self._hears("two causes")
        hears()
        return pair_fits(posterior, self.candidates, self.lengths.whole, self.frame, self.band, hears)

    def in_groups(self, fits: list[Fit]) -> list[Fit]:
        """Return fits of two causes where one of those found acts in some recordings only, which tells these apart."""
        posterior = self.posterior(fits)
        best, groups = posterior.fits[0], groups_in(posterior)
        if groups is None or self.is_enough(best) or is_hopeless(best, fits[0]):
            return []
        hears = self._hears("recordings apart")
        return changes_beside(self.ground, groups, (), self.candidates, self.frame, self.band, hears)

    def nearby(self, fits: list[Fit]) -> list[Fit]:
        """Return fits of the causes found at the places next to theirs, where more would be looked for otherwise."""
        return [] if self.is_enough(self.posterior(fits).fits[0]) else self._beside(fits, ())

    def beside(self, fits: list[Fit]) -> list[Fit]:
        """Return fits of the causes found at the places next to theirs, but for those that are known.

        Not where they leave so much that they are hardly the right ones.
        """
        return [] if is_hopeless(self.posterior(fits).fits[0], fits[0]) else self._beside(fits, fits)

    def alone(self, fits: list[Fit]) -> list[Fit]:
        """Return fits of each cause found without the others, which may only have led the search to it."""
        best = self.posterior(fits).fits[0]
        causes = {candidate.key for candidate in best.hypothesis.candidates}
        known = {item.hypothesis.candidates[0].key for item in fits if len(item.hypothesis.candidates) == 1}
        if causes <= known or len(causes) < 2 or any(batch.off for batch in best.batches):
            return []
        self.tell("each cause alone")
        return each_alone(best, self.frame)

    def anew(self, fits: list[Fit]) -> list[Fit]:
        """Return the best fit begun anew on short segments, where a force law is in it and it leaves more than noise,
        but not most.

        Over a whole recording the sum of squares has many minima: a stop that is hit a little early or late the first
        time is hit at the wrong times ever after.
        """
        best = self.posterior(fits).fits[0]
        fitting = best.hypothesis.is_linear or self.is_enough(best) or any(batch.off for batch in best.batches)
        if fitting or is_hopeless(best, fits[0]):
            return []
        self.tell("the best anew")
        short = self.ground.short
        start = replace(short, states=padded(short.states, best.hypothesis))
        again = fit_growing(best.hypothesis, best.theta, self.lengths, self.frame, start)
        return [] if again is None else [again]

    def posterior(self, fits: list[Fit]) -> Posterior:
        """Return the posterior over fits."""
        return posterior_of(tuple(fits), self.candidates)

    def judged(self, item: Fit) -> Fit:
        """Return a fit in units of the recordings' own noise."""
        return item if self.frame is self.own else in_units_of(self.own, item, self.frame)

    def is_wanting(self, item: Fit) -> bool:
        """Return whether a fit leaves more than noise, or bends the calibration beyond what is normal."""
        return factors_off(item) or left(self.judged(item), self.own, self.band).significant

    def is_enough(self, item: Fit) -> bool:
        """Return whether nothing beside a fit could matter."""
        return forecasts_well(self.judged(item), self.own, WELL) and not factors_off(item)

    def is_ample(self, item: Fit) -> bool:
        """Return whether what may be wrong beside a fit is not worth a search, which takes a minute of a frame."""
        return self.is_enough(item) and not item.hypothesis.plant.is_chain

    def _beside(self, fits: list[Fit], known: Sequence[Fit]) -> list[Fit]:
        best, hears = self.posterior(fits).fits[0], self._hears("places next to it")
        return fits_beside(best, fits[0], self.candidates, self.frame, hears, known)

    def _hears(self, stage: str) -> Callable[[], object]:
        return lambda: self.tell(stage)


def gather(setting: Setting, tell: Callable[[str], object]) -> Evidence:
    """Return the evidence; ``tell`` hears what is being done, step by step."""
    tell("screening")
    search, fits = _single_causes(setting, tell)
    stages = search.apart, search.nearby, search.together, search.in_groups, search.beside, search.alone, search.anew
    for stage in stages:
        fits += stage(fits)
    candidates, frame, own = search.candidates, search.frame, search.own
    notes = () if search.ground.hypothesis.plant.geometry is None else (GEOMETRIC,)
    if setting.is_astray:
        posterior = search.posterior(fits)
        energy = float(np.mean((frame.sigma / own.sigma) ** 2))
        note = f"{FAR_FROM_NOISE} ({np.sqrt(energy):.0f} times the noise was taken as such)"
        told = replace(posterior, fits=tuple(search.judged(item) for item in posterior.fits))
        return Evidence(search.judged(fits[0]), told, own, candidates, (*notes, note), energy)
    frame, fits = _with_better_noise(fits, frame, setting.band)
    posterior = _with_same_noise(posterior_of(tuple(fits), candidates), fits[0], frame, candidates)
    return Evidence(fits[0], posterior, frame, candidates, notes)


def _single_causes(setting: Setting, tell: Callable[[str], object]) -> tuple[_Search, list[Fit]]:
    """Return the search, and the fits without any cause and of each alone, in recordings less what geometry adds."""
    frame, lengths, geometry = setting.searched, setting.lengths, setting.geometry
    ground = ground_of(setting.nominal, setting.nominal.centre, lengths, frame, setting.short)
    if ground is None:
        raise InputError("model: with its own force laws these recordings' motion grows beyond all bounds; check them")
    ground, lengths = straighten(ground, ground.whole, lengths, frame, geometry)
    search = _Search(ground, lengths, setting.candidates(), frame, setting.frame, setting.band, tell)
    fits = [ground.whole]
    if setting.is_astray or not _nothing_to_gain(ground.whole, frame, setting.band):
        fits += search.singles()
        nearest = min(fits, key=lambda item: item.cost)
        ground, lengths = straighten(ground, nearest, lengths, frame, geometry)
        fits = [ground.whole, *fitted_as(ground.whole, fits[1:], frame)]
    own = setting.frame
    if not setting.is_astray:
        frame, fits = _with_better_noise(fits, frame, setting.band)
        own = frame
    return replace(search, ground=ground, lengths=lengths, frame=frame, own=own), fits


def _lasting(posterior: Posterior, base: Fit) -> tuple[Fit, ...]:
    """Return the best single causes that may act in all recordings beside a change: of all, and of those that are no
    harmonic force, whose waves of any size in each recording take up what changes, too.

    No law that leaves most of what the ``base`` does: what else changes beside it takes long to fit.
    """
    most = HELPLESS * misfit(base)
    single = [f for f in posterior.fits if f.hypothesis.candidates and (f.hypothesis.is_linear or misfit(f) <= most)]
    others = [item for item in single if not item.hypothesis.candidates[0].oscillator]
    return tuple({id(item): item for item in (*single[:1], *others[:1])}.values())


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
    if left(best, frame, band).significant:  # of what the best fit leaves there some is no noise
        scale = np.minimum(scale, 1.0)

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
