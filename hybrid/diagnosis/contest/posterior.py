"""How probable each hypothesis is among all that were considered, tempered by how well the best of them fits."""

from dataclasses import dataclass, replace

import numpy as np

from fe_models.arrays import FloatArray
from fe_models.causes import DeadLoad
from fe_models.causes.candidate import Candidate, HarmonicCandidate, LoadCandidate, SensorCandidate, SupportCandidate
from hybrid.diagnosis.contest.exactness import expected_square, log_evidences
from hybrid.diagnosis.contest.odds import Odds, log_of_groups
from hybrid.diagnosis.fitting.config import HARMONIC
from hybrid.diagnosis.fitting.harmonic_amplitude import harmonic_amplitude
from hybrid.diagnosis.fitting.least_squares import Fit
from hybrid.diagnosis.recorded.batches import acting_as_made
from hybrid.diagnosis.recorded.noise import correlation_factor

PRIOR_NOTHING_WRONG = 0.5  # prior probability that nothing is wrong; each further effect halves what is left


@dataclass(frozen=True)
class Posterior:
    """``fits``, best first, with the ``probability`` (fit,) that one is right, at its places or at any of their twins.

    ``temper``: what log evidences in units of what counted as noise in the search are divided by; ``widened``: what the
    variances of theta, which are of that noise, grow by.
    """

    fits: tuple[Fit, ...]
    probability: FloatArray
    temper: float
    widened: float


def posterior_of(fits: tuple[Fit, ...], candidates: tuple[Candidate, ...], is_astray: bool = False) -> Posterior:
    """Return the posterior over ``fits``; every kind is equally probable beforehand, places of a kind by their weight.

    ``is_astray``: whether what the nominal model lacks counted as noise. Of such a structure nobody can say how exact
    its nominal values are, and these are as uncertain as was stated.

    Where even the best fit leaves more than noise, its errors are no independent draws: the log evidences are divided
    by the energy left over that of noise, times the number of values that are worth one independent value. A model that
    fits leaves them as they are, but for a frame's. Of a frame whose nominal values turn out to be more exact than was
    stated, elements, joints and mesh are so, too: variances grow less then.

    A harmonic force whose amplitude does not differ from zero beyond chance is no hypothesis: slower than any mode, it
    may do no more than push a law to and fro, which takes up whatever that law's model lacks. Nor is a support that is
    not distinguished from a rigid one: the motion that it brings may take up what the structure's model lacks. Nor is
    weight, or a fault of a sensor or a load, whose size is zero within chance: unlike others, no nominal value may
    stand for it in part.
    """
    fits = _distinct(
        tuple(fit for fit in fits if _forces_detected(fit) and _compliance_detected(fit) and _sizes_detected(fit))
    )
    odds = Odds.among(candidates, fits[0].hypothesis.nominal.alike)
    prior = np.array([_log_prior(fit, odds) for fit in fits])
    evidence = np.array([fit.log_evidence for fit in fits])
    best = fits[int(np.argmax(evidence + prior))]
    noise = temper_of(best)
    temper = noise * odds.alike
    score = prior + (evidence / temper if is_astray else log_evidences(fits, best, temper))  # at these very places
    probability = np.exp(score - score.max()) * [_alike(fit) for fit in fits]
    probability /= probability.sum()
    order = np.argsort(-score, kind="stable")
    off = 1.0 if is_astray else expected_square(best, temper)
    return Posterior(
        tuple(fits[int(i)] for i in order), probability[order], temper, noise * (1 + off * (odds.alike - 1))
    )


def _alike(fit: Fit) -> float:
    """Return at how many places, twins and all, the causes of a fit would do the same."""
    return float(np.prod([1 + len(candidate.twins) for candidate in fit.hypothesis.candidates]))


def _forces_detected(fit: Fit) -> bool:
    """Return whether the amplitude of each harmonic force of a fit is told from none."""
    candidates = fit.hypothesis.candidates
    return all(
        harmonic_amplitude(fit, number).is_significant
        for number, candidate in enumerate(candidates)
        if isinstance(candidate, HarmonicCandidate)
    )


def _compliance_detected(fit: Fit) -> bool:
    """Return whether the compliance of each support of a fit that gives way is told from none."""
    soft = [part.start for _, part in fit.hypothesis.each(SupportCandidate)]
    least = np.maximum(fit.hypothesis.lower, HARMONIC.min_amplitude_sigma * np.sqrt(np.diag(fit.covariance)))
    return bool((fit.theta[soft] > least[soft]).all())


def _sizes_detected(fit: Fit) -> bool:
    """Return whether weight, and each fault of a sensor or a load, in a fit is told from none."""
    errors = np.sqrt(np.diag(fit.covariance))
    return all(
        abs(fit.theta[part.start] - candidate.neutral[0]) > HARMONIC.min_amplitude_sigma * errors[part.start]
        for candidate, part in zip(fit.hypothesis.candidates, fit.hypothesis.slices, strict=True)
        if isinstance(candidate, SensorCandidate | LoadCandidate) or candidate.kind == DeadLoad.kind
    )


def _distinct(fits: tuple[Fit, ...]) -> tuple[Fit, ...]:
    """Return the best fit of each hypothesis: searches may reach the same one from several starts."""
    best: dict[tuple[object, ...], Fit] = {}
    for fit in fits:
        known = best.get(fit.claim)
        if known is None or known.log_evidence < fit.log_evidence:
            best[fit.claim] = fit
    return tuple(best.values())


def temper_of(best: Fit) -> float:
    """Return the energy that a fit leaves over that of noise, times the number of values that are worth one independent
    value.
    """
    return max(1.0, best.chi2 / best.values) * max(correlation_factor(best.residuals) * best.batches[0].share, 1.0)


def _log_prior(fit: Fit, odds: Odds) -> float:
    halved = total = float(np.log(PRIOR_NOTHING_WRONG))
    for number, candidate in enumerate(fit.hypothesis.candidates):
        total += halved + odds.log(candidate) + log_of_groups(acting_as_made(fit.batches, number))
    return total


def of_candidate(posterior: Posterior, candidate: Candidate) -> float:
    """Return the probability that this kind acts at this very place, alone or with others.

    Its twins, places that move alike, share what is said of all of them.
    """
    return float(
        sum(
            p
            for fit, p in zip(posterior.fits, posterior.probability, strict=True)
            if any(other.key == candidate.key for other in fit.hypothesis.candidates)
        )
    ) / (1 + len(candidate.twins))


def rivals_of(posterior: Posterior, candidate: Candidate, least: float) -> list[tuple[Candidate, float]]:
    """Return what may stand in a candidate's place in the best fit, with its probability, if that is ``least``.

    Twins, the candidate's own and those of others, as well as what was fitted.
    """
    rest = {other.key for other in posterior.fits[0].hypothesis.candidates} - {candidate.key}
    share = of_candidate(posterior, candidate)
    found = {twin.key: (twin, share) for twin in twins_of(candidate)}
    for fit, p in zip(posterior.fits, posterior.probability, strict=True):
        own = {other.key: other for other in fit.hypothesis.candidates}
        extra = [other for key, other in own.items() if key not in rest]
        if rest <= own.keys() and len(extra) == 1 and extra[0].key != candidate.key:
            for place in (extra[0], *twins_of(extra[0])):
                known = found.get(place.key, (place, 0.0))
                found[place.key] = (place, known[1] + float(p) / (1 + len(extra[0].twins)))
    return sorted((item for item in found.values() if item[1] >= least), key=lambda item: -item[1])


def twins_of(candidate: Candidate) -> list[Candidate]:
    """Return a candidate at each of the other places where it would do the same."""
    return [replace(candidate, location=twin, twins=()) for twin in candidate.twins]
