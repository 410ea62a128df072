"""The stages of the search for causes: alone, in some recordings only, two at once, at places next to those found."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import lru_cache

import numpy as np
from scipy.stats import chi2

from fe_models.arrays import FloatArray
from fe_models.causes.candidate import Candidate, HarmonicCandidate
from hybrid.diagnosis.contest.changes import changed, changes_beside, groups_in
from hybrid.diagnosis.contest.config import PAIRS, SHORTLIST, STAGE
from hybrid.diagnosis.contest.discrepancy import in_units_of
from hybrid.diagnosis.contest.effort import effort_of
from hybrid.diagnosis.contest.growing import Lengths, ReferenceFits, fit_growing, padded, shortened
from hybrid.diagnosis.contest.harmonic import fit_forces
from hybrid.diagnosis.contest.neighbours import fits_beside, fits_tied, looks_wrong
from hybrid.diagnosis.contest.odds import Odds
from hybrid.diagnosis.contest.pairs import (
    asks_for_more,
    each_alone,
    explains_change,
    is_hopeless,
    pair_fits,
)
from hybrid.diagnosis.contest.posterior import Posterior, posterior_of, temper_of
from hybrid.diagnosis.contest.recording_groups import asked_for, clear_groups, each_of_two
from hybrid.diagnosis.contest.search import contest
from hybrid.diagnosis.contest.shortlist import not_too_many_of_a_kind
from hybrid.diagnosis.contest.switching import fit_everywhere, fit_switched
from hybrid.diagnosis.fitting.calibration_deviation import factors_off
from hybrid.diagnosis.fitting.excess_energy import excess_energy
from hybrid.diagnosis.fitting.forecast_score import forecast, model_of
from hybrid.diagnosis.fitting.harmonic_amplitude import harmonic_amplitude
from hybrid.diagnosis.fitting.least_squares import Fit, fit
from hybrid.diagnosis.parallel import parallel_map
from hybrid.diagnosis.recorded.noise import Band
from hybrid.diagnosis.recorded.noise_model import NoiseModel
from hybrid.diagnosis.screening.screening import Screened, screen


@dataclass(frozen=True)
class Search:
    """What is searched beside the ``reference``, with the noise of its ``noise_model``; ``own``: with that of the
    recordings.

    Each stage returns further fits, given all ``fits`` so far, the first of them without any cause; ``tell`` hears
    which it is.
    """

    reference: ReferenceFits
    lengths: Lengths
    candidates: tuple[Candidate, ...]
    noise_model: NoiseModel
    own: NoiseModel
    band: Band
    tell: Callable[[str], object]

    def singles(self) -> list[Fit]:
        """Return fits of each cause alone."""
        return list(
            contest(self.reference, self.candidates, self.lengths, self.noise_model, self._hears("another fit"))
        )

    def apart(self, fits: list[Fit]) -> list[Fit]:
        """Return fits of causes that act in some recordings only, alone or beside another one.

        Of three and more it is told which; of two, what the one that is farther from the drawing shows is sought there.
        """
        posterior = self.posterior(fits)
        best = posterior.fits[0]
        two = each_of_two(self.lengths.whole)
        if not (runs_at_times(best) or self._may_change(best) or (two is not None and self._may_act_in_one(best))):
            return []
        hears = self._hears("recordings apart")
        hears()
        if two is not None:
            return changed(self.reference, two, self.candidates, self.noise_model, hears)
        asked = asked_for(self.reference.short, self.candidates, self.noise_model)
        found = fit_switched(self.reference.short, best, asked, self.lengths, self.noise_model)
        after = self.posterior([*fits, *found])
        best = after.fits[0]
        if self._is_settled(best):
            return found
        if any(batch.off for batch in best.batches):
            groups = groups_in(after)
            found += changed(self.reference, groups, self.candidates, self.noise_model, hears)
            best = self.posterior([*fits, *found]).fits[0]
            thorough = effort_of(best.hypothesis.nominal).thorough
            if self._is_settled(best) or (explains_change(best, fits[0]) and not thorough):
                return found
        else:
            groups = clear_groups(asked, self.lengths.whole)
        lasting = _lasting(posterior, fits[0])
        return found + changes_beside(
            self.reference, groups, lasting, self.candidates, self.noise_model, self.band, hears
        )

    def everywhere(self, fits: list[Fit]) -> list[Fit]:
        """Return the fit in all recordings of a cause that does best in some of them only, and was not fitted in all.

        At a wrong place, where a second cause has led it, it fits some recordings worse than not at all.
        """
        best = self.posterior(fits).fits[0]
        keys = _keys(best)
        known = any(_keys(item) == keys and not any(batch.off for batch in item.batches) for item in fits)
        if known or not any(batch.off for batch in best.batches) or self._is_settled(best):
            return []
        self.tell("all recordings")
        found = fit_everywhere(best, self.lengths.whole, self.noise_model)
        return [] if found is None else [found]

    def together(self, fits: list[Fit]) -> list[Fit]:
        """Return fits of two causes at once."""
        posterior = self.posterior(fits)
        best = posterior.fits[0]
        if not asks_for_more(self.judged(best), self.judged(fits[0]), self.own, self.band) or self.is_ample(best):
            return []
        hears = self._hears("two causes")
        hears()
        return pair_fits(posterior, self.candidates, self.lengths.whole, self.noise_model, self.band, hears)

    def promised(self, fits: list[Fit]) -> list[Fit]:
        """Return fits of a cause that promises to be more probable than none, and of those that promise as much: beside
        a single one where no second one was looked for, or alone where none was.

        A search takes a minute of a frame, and what is left may be too little to ask for one among all the noise. What
        a weak cause promises to first order is followed at once; in other recordings it may be all that matters.
        Harmonic forces beside a cause, of which segments say nothing, where something beside it could matter.
        """
        best = self.posterior(fits).fits[0]
        causes = best.hypothesis.candidates
        searched = any(len(item.hypothesis.candidates) > len(causes) for item in fits)
        if searched or len(causes) > 1 or any(batch.off for batch in best.batches):
            return []
        taken = _keys(best)
        others = tuple(candidate for candidate in self.candidates if candidate.key not in taken)
        odds = Odds.among(self.candidates, best.hypothesis.nominal.alike)

        def ahead(trial: Screened) -> float:
            return trial.gain - odds.price(trial.candidate)

        ranked = sorted(screen(best, others, self.noise_model), key=ahead, reverse=True)
        least = max(ahead(ranked[0]) - SHORTLIST.tied_fall * odds.alike, 0.0) if ranked else 0.0
        trials = not_too_many_of_a_kind([trial for trial in ranked if ahead(trial) > least])
        if trials:
            self.tell("what is promised")

        def fitted(trial: Screened) -> Fit | None:
            hypothesis = best.hypothesis.adding(trial.candidate)
            return fit(hypothesis, trial.theta(best), best.batches, self.noise_model, padded(best, hypothesis))

        found = [item for item in parallel_map(fitted, trials[: SHORTLIST.max_promising]) if item is not None]
        if causes and not self.is_enough(best):
            found += fit_forces(best, others, found, self.noise_model, self._hears("what is promised"))
        return found

    def in_groups(self, fits: list[Fit]) -> list[Fit]:
        """Return fits of two causes where one of those found acts in some recordings only, which distinguishes these.

        Of a frame, where it takes long, only if none does better alone that acts in all of them.
        """
        posterior = self.posterior(fits)
        best, groups = posterior.fits[0], groups_in(posterior)
        if groups is None or is_hopeless(best, fits[0]) or self.is_enough(best):
            return []
        alone = next((item for item in posterior.fits if len(item.hypothesis.candidates) == 1), best)
        if not (effort_of(best.hypothesis.nominal).thorough or any(batch.off for batch in alone.batches)):
            return []
        hears = self._hears("recordings apart")
        return changes_beside(self.reference, groups, (), self.candidates, self.noise_model, self.band, hears)

    def nearby(self, fits: list[Fit]) -> list[Fit]:
        """Return fits of the causes found at the places next to theirs, where more would be looked for otherwise."""
        best = self.posterior(fits).fits[0]
        return [] if looks_wrong(best, fits[0]) or self.is_enough(best) else self._beside(best, fits[0], ())

    def beside(self, fits: list[Fit]) -> list[Fit]:
        """Return fits of the causes found at the places next to theirs, but for those that are known, and at all places
        that the recordings do not distinguish from the best.

        Not where they leave so much that they are hardly the right ones.
        """
        best = self.posterior(fits).fits[0]
        if self._is_hopeless(best, fits[0]):
            return []
        found = self._beside(best, fits[0], fits)
        after = self.posterior([*fits, *found])
        return found + fits_tied(
            after.fits, after.temper, self.candidates, self.noise_model, self._hears("places alike")
        )

    def alone(self, fits: list[Fit]) -> list[Fit]:
        """Return fits of each cause found without the others, which may only have led the search to it."""
        best = self.posterior(fits).fits[0]
        causes = _keys(best)
        known = {item.hypothesis.candidates[0].key for item in fits if len(item.hypothesis.candidates) == 1}
        if causes <= known or len(causes) < 2 or any(batch.off for batch in best.batches):
            return []
        self.tell("each cause alone")
        return each_alone(best, self.noise_model)

    def anew(self, fits: list[Fit]) -> list[Fit]:
        """Return the best fit begun anew on short segments, where a force law is in it and it leaves more than noise,
        but not most.

        Over a whole recording the sum of squares has many minima: a stop that is hit a little early or late the first
        time is hit at the wrong times ever after.
        """
        best = self.posterior(fits).fits[0]
        settled = best.hypothesis.is_linear or any(batch.off for batch in best.batches)
        if settled or self._is_hopeless(best, fits[0]) or self.is_enough(best):
            return []
        self.tell("the best anew")
        short = self.reference.short
        start = shortened(best, short.batches, self.noise_model, padded(short, best.hypothesis))
        again = start and fit_growing(best.hypothesis, start.theta, self.lengths, self.noise_model, start)
        return [] if again is None else [again]

    def posterior(self, fits: list[Fit]) -> Posterior:
        """Return the posterior over fits."""
        return posterior_of(tuple(fits), self.candidates, is_astray=self.noise_model is not self.own)

    def judged(self, item: Fit) -> Fit:
        """Return a fit in units of the recordings' own noise."""
        return item if self.noise_model is self.own else in_units_of(self.own, item, self.noise_model)

    def is_wanting(self, item: Fit) -> bool:
        """Return whether a fit leaves more than noise, or bends the calibration beyond what is normal."""
        return factors_off(item) or excess_energy(self.judged(item), self.own, self.band).significant

    def is_enough(self, item: Fit) -> bool:
        """Return whether nothing beside a fit could matter; of a frame's force law it takes seconds to say."""
        return forecasts_well(self.judged(item), self.own, STAGE.max_good_ratios) and not factors_off(item)

    def is_ample(self, item: Fit) -> bool:
        """Return whether what may be wrong beside a fit is not worth a search, which takes a minute of a frame."""
        thorough = effort_of(item.hypothesis.nominal).thorough
        return not thorough and temper_of(self.judged(item)) < PAIRS.max_left_ratio and self.is_enough(item)

    def _may_change(self, best: Fit) -> bool:
        """Return whether what the best fit leaves may be a change between recordings.

        Calibrations that go far to hide one leave something all the same, if less than is significant.
        """
        if not self.is_wanting(best) or fits_unalike(best):
            return self.is_wanting(best)
        judged = self.judged(best)
        rest = excess_energy(judged, self.own, self.band)
        hidden = factors_off(best) and rest.total > STAGE.max_faint_sigma * rest.std
        return hidden or not forecasts_well(judged, self.own, STAGE.max_good_ratios)

    def _may_act_in_one(self, best: Fit) -> bool:
        """Return whether the cause of the best fit to two recordings may act in one of them alone, where the other may
        move too little to deny it.
        """
        thorough = effort_of(best.hypothesis.nominal).thorough
        return bool(best.hypothesis.candidates) and (thorough or not self.is_enough(best))

    def _is_settled(self, best: Fit) -> bool:
        """Return whether nothing more is to be looked for beside the best fit."""
        return not self.is_wanting(best) or self.is_ample(best)

    def _is_hopeless(self, best: Fit, base: Fit) -> bool:
        """Return whether the best leaves most of what is wrong, where the ``base`` leaves more than noise."""
        return is_hopeless(best, base) and self.is_wanting(base)

    def _beside(self, best: Fit, base: Fit, known: Sequence[Fit]) -> list[Fit]:
        return fits_beside(best, base, self.candidates, self.noise_model, self._hears("places next to it"), known)

    def _hears(self, stage: str) -> Callable[[], object]:
        return lambda: self.tell(stage)


def _keys(item: Fit) -> set[str]:
    return {candidate.key for candidate in item.hypothesis.candidates}


def _lasting(posterior: Posterior, base: Fit) -> tuple[Fit, ...]:
    """Return the best single causes that may act in all recordings beside a change: of all, and of those that are no
    harmonic force, whose waves of any size in each recording take up what changes, too.

    No law that leaves most of what the ``base`` does: what else changes beside it takes long to fit.
    """
    most = STAGE.max_law_share * base.misfit
    single = [f for f in posterior.fits if f.hypothesis.candidates and (f.hypothesis.is_linear or f.misfit <= most)]
    others = [item for item in single if not isinstance(item.hypothesis.candidates[0], HarmonicCandidate)]
    return tuple({id(item): item for item in (*single[:1], *others[:1])}.values())


def fits_unalike(item: Fit) -> bool:
    """Return whether a fit leaves more of some recordings than of others, as one that stands for a change does, and as
    chance rarely does: of short recordings mean squares scatter.
    """
    whole = [part.reshape(len(batch.names), -1) for part, batch in zip(item.residuals, item.batches, strict=True)]
    squares = np.concatenate([np.square(part).mean(axis=1) for part in whole])  # (recording,)
    values = np.repeat(
        [batch.share * part.shape[1] for part, batch in zip(whole, item.batches, strict=True)],
        [len(part) for part in whole],
    )
    drawn = chi2(values)
    sums = values * squares / np.average(squares, weights=values)
    by_chance = 2 * len(values) * float(np.minimum(drawn.cdf(sums), drawn.sf(sums)).min())
    return bool(squares.max() > STAGE.min_unlike_ratio * squares.min() and by_chance < STAGE.max_unlike_chance)


def runs_at_times(item: Fit) -> bool:
    """Return whether a fit is of a harmonic force that acts in some recordings only, as one that stands for a change
    does: of any size in each recording it takes up whatever comes in one of them.
    """
    causes = item.hypothesis.candidates
    return (
        len(causes) == 1 and isinstance(causes[0], HarmonicCandidate) and not harmonic_amplitude(item, 0).acting.all()
    )


def forecasts_well(item: Fit, noise_model: NoiseModel, limits: tuple[float, float]) -> bool:
    """Return whether a fit forecasts the recordings that it was fitted to, each from its first fifth, as well as noise
    lets it: their NRMSE over the noise floor, mean and largest, within ``limits``.
    """
    over = _over_floor(item, noise_model)
    return bool(over.mean() <= limits[0] and over.max() <= limits[1])


@lru_cache(maxsize=2)  # stage after stage asks it of the same best fit, and geometry makes it take a second
def _over_floor(item: Fit, noise_model: NoiseModel) -> FloatArray:
    """Return the NRMSE of forecasts over the noise floor (recording,)."""
    found = forecast(model_of(item, noise_model), item.batches, noise_model.roles)
    return np.asarray(found.nrmse.mean(axis=1) / found.floor.mean(axis=1))
