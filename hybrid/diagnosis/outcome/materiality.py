"""Which causes matter: those without which recordings that were never fitted are forecast worse."""

from collections import Counter

from hybrid.diagnosis.contest.evidence import Evidence
from hybrid.diagnosis.contest.posterior import Posterior
from hybrid.diagnosis.contest.switching import acting_recordings
from hybrid.diagnosis.fitting.calibration_deviation import deviation_of, factors_off, farthest_of, off_together
from hybrid.diagnosis.fitting.config import CALIBRATION
from hybrid.diagnosis.fitting.excess_energy import excess_energy
from hybrid.diagnosis.fitting.forecast_score import ForecastScore
from hybrid.diagnosis.fitting.least_squares import Fit, fit
from hybrid.diagnosis.outcome.config import MATERIALITY, VERDICT
from hybrid.diagnosis.outcome.findings import cause_of, sentence_of
from hybrid.diagnosis.outcome.scorer import Scorer
from hybrid.diagnosis.outcome.verdict import Errors, is_at_floor
from hybrid.diagnosis.recorded.motions import in_words
from hybrid.diagnosis.recorded.noise import Band
from hybrid.diagnosis.recorded.noise_model import NoiseModel

TOO_WEAK = "significant, but too weak to matter for forecasts"
BENDS = "fits only with nominal values beyond what is normal, and forecasts are good without it"


def material(evidence: Evidence, scorer: Scorer) -> tuple[Posterior, list[str]]:
    """Return the posterior among hypotheses of no more causes than matter, and a note on each that does not.

    What leaves no more than noise explains all. Otherwise a cause that takes hardly anything away is a guess. So is a
    second one that bends nominal values beyond what is normal, beside a first that forecasts well without. One that
    recordings demand is none, however little better forecasts are: a late sensor, one more mode's damping.
    """
    posterior, notes = _with_cause(evidence, scorer), list[str]()
    nominal = scorer.forecast(evidence.base, 0.0)
    floor, band = scorer.floor(nominal), scorer.setting.band
    while posterior.fits[0].hypothesis.candidates:
        best = posterior.fits[0]
        count = len(best.hypothesis.candidates)
        fewer = tuple(item for item in posterior.fits if _is_simpler(item, best))
        if not fewer:
            break
        most = max(CALIBRATION.max_deviation_sigma, deviation_of(best))  # what the one needs, the other may have
        simpler = evidence.among(fewer)
        before, after = (scorer.forecast(item, most) for item in (simpler.fits[0], best))
        if simpler.fits[0].hypothesis.candidates:  # two causes may improve on one that only makes it worse
            plain = scorer.forecast(evidence.base, most)
            if scorer.error(plain) < scorer.error(before):
                simpler, before = evidence.among((evidence.base,)), plain
        several = bool(simpler.fits[0].hypothesis.candidates)
        guess = excess_energy(best, evidence.noise_model, band).significant
        trifle = is_trifle(before, after, nominal, several)
        gained = scorer.error(before) - scorer.error(after)
        weaker = gained <= (VERDICT.min_second_gain if several else scorer.setting.tolerance) * floor
        reached = is_at_floor(scorer.error(before), floor, scorer.setting.tolerance)
        bends = reached and several and factors_off(best) and not factors_off(simpler.fits[0])
        if count == 1:  # what is not needed is reported as weak then: see `verdict`
            if reached or not (guess and trifle and weaker):
                break
        elif not bends:
            needless = weaker or (guess and trifle)
            may_ask = several and gained > 0
            if not needless or (may_ask and is_demanded(simpler.fits[0], best, evidence.noise_model, band)):
                break
        kept = {candidate.key for candidate in simpler.fits[0].hypothesis.candidates}
        dropped = [i for i, c in enumerate(best.hypothesis.candidates) if c.key not in kept]
        words = TOO_WEAK if weaker or not bends else BENDS
        notes += [note_unnamed(best, number, posterior.widened, words) for number in dropped]
        posterior = simpler
    return posterior, notes


def is_demanded(fewer: Fit, more: Fit, noise_model: NoiseModel, band: Band) -> bool:
    """Return whether recordings ask for the causes that one fit has ``more`` than another, whatever forecasts gain.

    Without them more than noise is left, and with them noise alone, or less than half as much; or nominal values go far
    beyond what is normal without them alone. A fit of ``fewer`` may have stopped early: it begins there, too.
    """
    again = _without(more, fewer, noise_model)
    if again is None:
        return False
    fewer = min(fewer, again, key=lambda item: item.cost)
    without, beside = (excess_energy(item, noise_model, band) for item in (fewer, more))
    if without.significant:
        return not beside.significant or beside.total <= MATERIALITY.max_mostly_left * without.total
    far = deviation_of(fewer) > MATERIALITY.far_ratio * farthest_of(len(fewer.deviations))
    return far and not factors_off(more) and not beside.significant


def _without(more: Fit, fewer: Fit, noise_model: NoiseModel) -> Fit | None:
    """Return the fit of the causes of ``fewer`` from where one of ``more`` ended.

    None where it fails, or a cause acts in some recordings only, or brings a mode: what that shows is not the cause's.
    """
    own, kept = more.hypothesis, {candidate.key for candidate in fewer.hypothesis.candidates}
    off = tuple(number for number, candidate in enumerate(own.candidates) if candidate.key not in kept)
    if any(batch.off for batch in more.batches) or any(own.candidates[number].brings for number in off):
        return None
    states = tuple(part[:, own.states_of(off)] for part in more.states)
    return fit(own.less(off), more.theta[own.parameters_of(off)], more.batches, noise_model, states)


def is_trifle(before: ForecastScore, after: ForecastScore, nominal: ForecastScore, several: bool) -> bool:
    """Return whether one of ``several`` causes takes hardly any of what is wrong with the ``nominal`` model away."""
    taken = before.energy - after.energy
    return (
        taken <= MATERIALITY.max_trifles[several] * nominal.excess
        and taken <= MATERIALITY.min_share_of_rest * before.excess
    )


def without_weak(posterior: Posterior, evidence: Evidence, scorer: Scorer) -> tuple[Posterior, list[str]]:
    """Return the posterior without any cause, and a note on each, where the structure needs none to forecast well.

    Beside a modal model that is wrong: `verdict` says that nothing is wrong only of the simulation as a whole.
    """
    base, best = evidence.base, posterior.fits[0]
    own, extended = scorer.forecast(base, CALIBRATION.max_deviation_sigma), scorer.forecast(best)
    tolerance = scorer.setting.tolerance
    errors = Errors(scorer.error(own), scorer.error(extended), scorer.floor(own), 0.0, tolerance=tolerance)
    if not errors.nothing_to_gain:
        return posterior, []
    notes = [weak(best, number, posterior.widened) for number in range(len(best.hypothesis.candidates))]
    return evidence.among((base,)), notes


def _with_cause(evidence: Evidence, scorer: Scorer) -> Posterior:
    """Return the posterior given that something (more) is wrong, where it is.

    A calibration beyond all that is normal is none, if within what is normal it forecasts worse than a cause (more)
    does: normal for one value, or for as many as are off.
    """
    posterior = evidence.posterior
    best = posterior.fits[0]
    count = len(best.hypothesis.candidates)
    causes = tuple(item for item in posterior.fits if len(item.hypothesis.candidates) > count)
    if not causes or not factors_off(best):
        return posterior
    wrong = evidence.among(causes)
    most = CALIBRATION.max_deviation_sigma if off_together(best) else farthest_of(len(best.deviations))
    before, after = scorer.forecast(best, most), scorer.forecast(wrong.fits[0], most)
    gained = scorer.error(before) - scorer.error(after)
    return (
        wrong
        if gained > (VERDICT.min_second_gain if count else scorer.setting.tolerance) * scorer.floor(before)
        else posterior
    )


def _is_simpler(item: Fit, than: Fit) -> bool:
    """Return whether a fit has fewer causes than another, or as many without any force law, which that has."""
    own, others = len(item.hypothesis.candidates), len(than.hypothesis.candidates)
    return own < others or (own == others and item.hypothesis.is_linear and not than.hypothesis.is_linear)


def weak(item: Fit, number: int, widened: float) -> str:
    """Return a note on candidate ``number`` of a fit that forecasts do not need; ``widened``: see `cause_of`."""
    return note_unnamed(item, number, widened, TOO_WEAK)


def note_unnamed(item: Fit, number: int, widened: float, words: str) -> str:
    """Return a note on candidate ``number`` of a fit, which is not named: why, in ``words``."""
    cause, parameters = cause_of(item, number, widened)
    sentence = sentence_of(cause, parameters, item.hypothesis.nominal.structure)
    acting, every = (Counter(names) for names in (acting_recordings(item, number), item.names))
    where = "" if acting == every else f" (in {in_words(acting, every)} only)"
    return f"{words}: {sentence.rstrip('.')}{where}"
