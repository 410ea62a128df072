"""Which findings are named: the causes of the best fit and a wrong modal model, what explains most first."""

import numpy as np

from fe_models.arrays import TINY, FloatArray
from fe_models.causes.candidate import Candidate
from hybrid.diagnosis.contest.posterior import Posterior, of_candidate, rivals_of
from hybrid.diagnosis.fitting.forecast_score import ForecastModel
from hybrid.diagnosis.outcome.acting import recordings_of
from hybrid.diagnosis.outcome.config import MENTION
from hybrid.diagnosis.outcome.findings import (
    NOT_ON_THE_LIST,
    OTHER_CAUSES,
    Alternative,
    Finding,
    Parameter,
    cause_of,
    sentence_of,
)
from hybrid.diagnosis.outcome.forecasts import share
from hybrid.diagnosis.outcome.ruling import Ruling
from hybrid.diagnosis.outcome.simulation import modal_finding
from hybrid.diagnosis.probability import SUREST
from hybrid.diagnosis.recorded.motions import motions_of


def named_by(ruling: Ruling) -> tuple[Finding, ...]:
    """Return the findings that a ruling names, what explains most first; none where it names nothing.

    How probable it is that what is wrong is on the list at all is the ruling's; given that, the posterior tells how
    probable each cause is.
    """
    if not ruling.is_named:
        return ()
    found, model = ruling.found, ruling.scorer.model(ruling.best)
    findings = [_finding(ruling, number, part, model) for number, part in enumerate(_taken_away(ruling))]
    if ruling.simulation.is_wrong:
        probability = min(ruling.simulation.probability, SUREST) * ruling.listed
        every = tuple(motions_of(ruling.setting.dataset).elements())
        rest = tuple(remainder(probability, [], ruling.listed))
        findings.insert(0, modal_finding(ruling.simulation, found.nominal, found.extended, probability, rest, every))
    return tuple(sorted(findings, key=lambda finding: -finding.explains))


def _finding(ruling: Ruling, number: int, taken: float, model: ForecastModel) -> Finding:
    """Return the finding of cause ``number`` of the best fit, by whose ``model`` recordings are forecast.

    ``taken``: the energy of forecast errors, in units of the noise's variance, that the cause takes away.
    """
    best, posterior, scorer, setting = ruling.best, ruling.posterior, ruling.scorer, ruling.setting
    candidate = best.hypothesis.candidates[number]
    cause, parameters = cause_of(best, number, posterior.widened)
    temper = posterior.temper * ruling.evidence.energy  # of what is left of the recordings themselves
    acting = recordings_of(best, number, model, scorer.test, setting.measured, scorer.noise_model, temper)
    listed = ruling.listed * min((hum.machine for hum in ruling.hums if hum.number == number), default=1.0)
    probability = min(of_candidate(posterior, candidate), SUREST) * listed
    rivals = [
        Alternative(rival.kind, rival.reported_location, p * listed, _size(posterior, rival))
        for rival, p in rivals_of(posterior, candidate, MENTION.min_alternative_probability)
    ]
    return Finding(
        cause,
        parameters,
        probability,
        share(taken, ruling.found.nominal.excess),
        tuple(name for name in motions_of(setting.dataset) for _ in range(acting[name])),
        (*rivals, *remainder(probability, rivals, listed)),
        sentence_of(cause, parameters, setting.nominal.structure),
    )


def _size(posterior: Posterior, rival: Candidate) -> dict[str, Parameter]:
    """Return the parameters of a rival in the most probable fit that has it; none where only its twin was fitted."""
    for fit in posterior.fits:
        keys = [candidate.key for candidate in fit.hypothesis.candidates]
        if rival.key in keys:
            return cause_of(fit, keys.index(rival.key), posterior.widened)[1]
    return {}


def remainder(probability: float, rivals: list[Alternative], listed: float) -> list[Alternative]:
    """Return what the ``probability`` of a finding and of its ``rivals`` leaves to others: of what is ``listed`` to
    causes that are not listed one by one, and all else to what is not on the list.
    """
    others = listed - probability - sum(rival.probability for rival in rivals)
    rest = ((OTHER_CAUSES, others), (NOT_ON_THE_LIST, 1 - listed))
    return [Alternative(kind, {}, share) for kind, share in rest if share >= MENTION.min_alternative_probability]


def _taken_away(ruling: Ruling) -> FloatArray:
    """Return the energy of forecast errors that each cause of the best fit takes away, (cause,).

    What all of them take is shared by Shapley's values: the mean of what each takes alone and of what is lost without
    it, the others fitted anew. Without one of them its rivals, and the calibration, may make up for most of it.
    """
    found, drawn = ruling.found, ruling.found.drawn.energy
    keys = [candidate.key for candidate in ruling.best.hypothesis.candidates]
    whole = drawn - found.extended.energy
    if len(keys) == 1:
        return np.array([whole])
    taken = [
        drawn - _energy_with(ruling, {key}) + _energy_with(ruling, set(keys) - {key}) - found.extended.energy
        for key in keys
    ]
    shares = np.maximum(taken, TINY)
    return np.asarray(whole * shares / shares.sum())


def _energy_with(ruling: Ruling, keys: set[str]) -> float:
    """Return the energy of forecast errors by the best fit of those causes alone; as drawn where none was fitted."""
    fits = ruling.posterior.fits
    item = next((item for item in fits if {c.key for c in item.hypothesis.candidates} == keys), None)
    return ruling.found.drawn.energy if item is None else ruling.scorer.forecast(item).energy
