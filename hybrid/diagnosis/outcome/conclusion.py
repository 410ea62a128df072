"""From evidence to what a report says: verdict, findings, extended structure, and forecasts before and after."""

from dataclasses import dataclass, replace

import numpy as np

from fe_models.dofs import FloatArray
from fe_models.effects import HarmonicForce
from fe_models.sensor_effects import SensorEffect
from fe_models.structure import Structure
from hybrid.diagnosis.contest.evidence import Evidence
from hybrid.diagnosis.contest.pairs import left
from hybrid.diagnosis.contest.posterior import Posterior, of_candidate, rivals_of
from hybrid.diagnosis.contest.setting import Setting
from hybrid.diagnosis.fitting.far_off import DEVIATION, factors_off, within
from hybrid.diagnosis.fitting.fitting import Fit, residuals_at
from hybrid.diagnosis.fitting.forecasting import TINY, Forecast
from hybrid.diagnosis.outcome.acting import recordings_of
from hybrid.diagnosis.outcome.advice import Advice, advise
from hybrid.diagnosis.outcome.calibration import Calibrated, astray, calibration_of, dispersion_of, far_off
from hybrid.diagnosis.outcome.extend import extended_structure
from hybrid.diagnosis.outcome.findings import (
    Alternative,
    Finding,
    at_place,
    cause_of,
    is_held,
    reported_location,
    sentence_of,
)
from hybrid.diagnosis.outcome.materiality import material, weak, without_weak
from hybrid.diagnosis.outcome.noisier import with_own_noise
from hybrid.diagnosis.outcome.scorer import Scorer
from hybrid.diagnosis.outcome.simulation import Simulation, modal_finding, modal_notes, simulation_of
from hybrid.diagnosis.outcome.verdict import ABNORMAL, Errors, Verdict, verdict_of
from hybrid.diagnosis.recorded.gauge import Gauge
from hybrid.diagnosis.shown.all_off import all_off, damping_off
from hybrid.diagnosis.shown.example import Example, example_of
from hybrid.diagnosis.shown.show import Shown, show

RIVALS = 0.005  # least probability of an alternative that is told
NEXT_TO_NOTHING = 1e-9  # of the energy of an error
SUREST = 0.999  # no probability is said to be more
UNSEEN = (
    "the training recordings show nothing{more} wrong, but test recordings do ({names}): what acts there is not felt in"
    ' training, or came later; take such a recording for training (role = "train") and diagnose again'
)
BENT = (
    "motions of {names} are so large that the frame's geometry shows, which recordings for training do not: forecasts"
    " take it into account"
)


@dataclass(frozen=True)
class Diagnosis:
    """All that a report says.

    ``verdict`` and ``findings``, what explains most first; ``calibration`` of the nominal values; ``unexplained``:
    share of the nominal model's wrong energy that is left. ``scores``: forecast NRMSE of the user's simulation,
    "baseline", and of the ``extended`` structure, of the "measured" and the "held_out" channels (None without any);
    ``noise_floor``: what noise alone makes of the first. ``shown``: what the simulation gets wrong, and one recording
    as an ``example`` of it. ``advice``: which sensor more would decide between rivals. ``posterior`` over all fits that
    matter; ``notes``: what the user should know about the data; ``seconds`` that it took.
    """

    verdict: Verdict
    findings: tuple[Finding, ...]
    calibration: tuple[Calibrated, ...]
    unexplained: float
    scores: dict[str, dict[str, float | None]]
    noise_floor: float
    extended: Structure
    shown: Shown
    example: Example
    advice: tuple[Advice, ...]
    posterior: Posterior
    notes: tuple[str, ...]
    seconds: float


@dataclass(frozen=True)
class _Forecasts:
    """By the user's simulation, ``nominal`` and ``calibrated`` within what is normal; by its structure, which is
    another where a modal model stands for it, ``drawn`` and ``own``, likewise; and with what was found, ``extended``.
    """

    nominal: Forecast
    calibrated: Forecast
    drawn: Forecast
    own: Forecast
    extended: Forecast

    @property
    def unexplained(self) -> float:
        """The share of the nominal model's wrong energy that the extended one leaves."""
        return _share(self.extended.excess, self.nominal.excess)


def concluded(setting: Setting, evidence: Evidence) -> Diagnosis:
    """Return the diagnosis that the evidence amounts to."""
    base, gauge = evidence.base, evidence.gauge
    scorer, noisier = with_own_noise(Scorer.of(setting, evidence), evidence.posterior.fits[0])
    posterior, notes = _mattering(setting, evidence, scorer)
    notes = noisier + notes
    best = posterior.fits[0]
    simulation = simulation_of(setting, evidence, posterior, scorer)
    normal = DEVIATION if best.hypothesis.candidates else ABNORMAL  # no cause is likelier than a value that far off
    found = _forecasts(scorer, simulation.fit, base, best, normal)
    errors = Errors(
        scorer.error(found.calibrated), scorer.error(found.extended), scorer.floor(found.own), found.unexplained
    )
    wrong = simulation.fit if simulation.is_wrong else base
    verdict, listed = verdict_of(best, evidence.posterior.fits[0], wrong, gauge, setting.band, errors)
    named = verdict in (Verdict.EXPLAINED, Verdict.PARTLY_EXPLAINED)
    final, theta = (best, best.theta) if named else _as_drawn_or_calibrated(base, gauge, normal)
    findings = _findings(scorer, evidence, posterior, simulation, found, listed) if named else ()
    if named:
        notes += _apart(setting, findings)
        notes += astray(best, ABNORMAL) if verdict is Verdict.PARTLY_EXPLAINED else []
    elif verdict is Verdict.NOTHING_WRONG:
        notes += far_off(replace(base, theta=theta))
        if simulation.fit is base:  # else a cause may matter for the structure, if not for the user's modal model
            notes += [weak(best, number, posterior.temper) for number in range(len(best.hypothesis.candidates))]
    if verdict is not Verdict.NOTHING_WRONG and not (named and errors.near):
        item, forecast, more = (best, found.extended, " more") if named else (base, found.own, "")
        notes += _unseen(item, forecast, scorer, evidence, more)
    after = found.extended if named else found.own if theta.any() else found.drawn
    notes += modal_notes(simulation, found.nominal, found.own, scorer, named)
    advice = advise(posterior, evidence.searched, setting.dataset.sensors) if named else ()
    shown = show(setting.dataset, simulation.fit, final, found.nominal, found.calibrated, gauge)
    if errors.near or verdict is Verdict.NOTHING_WRONG:
        names = ", ".join(scorer.bent_in(replace(final, theta=theta)))
        notes += [BENT.format(names=names)] if names else []
    notes += dispersion_of(replace(final, theta=theta), posterior.temper)
    notes += all_off(shown, setting.dataset.assumptions.uncertainty)
    if verdict in (Verdict.PARTLY_EXPLAINED, Verdict.UNEXPLAINED):
        notes += damping_off(shown, setting.dataset.assumptions.uncertainty)
    return Diagnosis(
        verdict=verdict,
        findings=findings,
        calibration=calibration_of(setting.plant, theta, posterior.temper * final.covariance),
        unexplained=0.0 if verdict is Verdict.NOTHING_WRONG else found.unexplained,
        scores={
            name: {"measured": scorer.error(scored), "held_out": scorer.held_out_error(scored)}
            for name, scored in (("baseline", found.nominal), ("extended", after))
        },
        noise_floor=errors.floor,
        extended=extended_structure(setting.plant, theta[: base.hypothesis.nuisances], findings),
        shown=shown,
        example=example_of(
            scorer.shown,
            scorer.example_model(simulation.fit, np.zeros_like(simulation.fit.theta)),
            scorer.example_model(final, None if named else theta),
            scorer.view,
            shown.observed.frequencies,
        ),
        advice=advice,
        posterior=posterior,
        notes=(*setting.notes, *evidence.notes, *notes, *(item.sentence for item in advice)),
        seconds=0.0,
    )


def _mattering(setting: Setting, evidence: Evidence, scorer: Scorer) -> tuple[Posterior, list[str]]:
    """Return the posterior among hypotheses whose causes matter, and a note on each cause that does not."""
    posterior, notes = material(evidence, scorer)
    if setting.modal is None:
        return posterior, notes
    posterior, more = without_weak(posterior, evidence, scorer)
    return posterior, notes + more


def _forecasts(scorer: Scorer, simulated: Fit, base: Fit, best: Fit, normal: float) -> _Forecasts:
    """Return the forecasts by fits of the user's simulation and of its structure, ``base`` without any cause.

    ``normal``: how far a nominal value may be calibrated, in stated standard deviations.
    """
    nominal, calibrated = (scorer.forecast(simulated, most) for most in (0.0, normal))
    drawn, own = nominal, calibrated
    if simulated is not base:
        drawn, own = (scorer.forecast(base, most) for most in (0.0, normal))
    return _Forecasts(nominal, calibrated, drawn, own, scorer.forecast(best))


def _unseen(item: Fit, found: Forecast, scorer: Scorer, evidence: Evidence, more: str) -> list[str]:
    """Return a note on test recordings whose forecasts by a fit are wrong, where it leaves nothing of the training
    recordings that is.
    """
    if left(item, evidence.gauge, scorer.setting.band).significant or factors_off(item):
        return []
    names = ", ".join(scorer.wrong_in(found))
    return [UNSEEN.format(more=more, names=names)] if names else []


def _as_drawn_or_calibrated(base: Fit, gauge: Gauge, most: float) -> tuple[Fit, FloatArray]:
    """Return the fit without any cause and its theta: calibrated by no more than ``most`` standard deviations, or zero
    where what is wrong has led that astray.
    """
    drawn, calibrated = np.zeros_like(base.theta), within(base, most)
    left_by = [
        sum(np.inf if part is None else float(np.square(part).sum()) for part in residuals_at(base, theta, gauge))
        for theta in (drawn, calibrated)
    ]
    return base, drawn if left_by[0] < left_by[1] else calibrated


def _findings(
    scorer: Scorer,
    evidence: Evidence,
    posterior: Posterior,
    simulation: Simulation,
    found: _Forecasts,
    listed: float,
) -> tuple[Finding, ...]:
    """Return the causes of the best fit and a wrong modal model, what explains most first.

    ``listed``: how probable it is that what is wrong is on the list at all; given that, the posterior tells how
    probable each cause is.
    """
    best, findings = posterior.fits[0], list[Finding]()
    whole, model = found.extended, scorer.model(best)
    setting, temper = scorer.setting, posterior.temper * evidence.energy  # of what is left of the recordings themselves
    names, taken = _names(setting), _taken_away(posterior, found, scorer)
    if simulation.is_wrong:
        findings.append(modal_finding(simulation, found.nominal, whole, SUREST * listed, names))
    for number, candidate in enumerate(best.hypothesis.candidates):
        cause, parameters = cause_of(best, number, posterior.temper)
        acting = recordings_of(best, number, model, scorer.test, setting.measured, scorer.gauge, temper)
        findings.append(
            Finding(
                cause,
                parameters,
                min(of_candidate(posterior, candidate), SUREST) * listed,
                _share(taken[number], found.nominal.excess),
                tuple(name for name in names if name in acting),
                tuple(
                    Alternative(rival.kind, reported_location(rival), p * listed)
                    for rival, p in rivals_of(posterior, candidate, RIVALS)
                ),
                sentence_of(cause, parameters, held=is_held(setting.plant.structure.supports, cause)),
            )
        )
    return tuple(sorted(findings, key=lambda finding: -finding.explains))


def _share(part: float, whole: float) -> float:
    """Return what a part is of the whole, between 0 and 1; of next to nothing nothing."""
    share = float(np.clip(part / whole, 0.0, 1.0))
    return share if share > NEXT_TO_NOTHING else 0.0


def _names(setting: Setting) -> tuple[str, ...]:
    """Return the names of the recordings in the dataset's order, each once: several in one file share one."""
    return tuple(dict.fromkeys(recording.name for recording in setting.dataset.recordings))


def _apart(setting: Setting, findings: tuple[Finding, ...]) -> list[str]:
    """Return a line on each finding that acts in some recordings only."""
    names, lines = _names(setting), []
    for finding in findings:
        cause, without = finding.cause, [name for name in names if name not in finding.recordings]
        alike = "all alike" if isinstance(cause, HarmonicForce | SensorEffect) else "all of one structure"
        if without:
            lines.append(
                f"the recordings are not {alike}: {cause.kind} {at_place(cause.location)} acts in"
                f" {', '.join(finding.recordings)}, and does not, or too little to tell, in {', '.join(without)}"
            )
    return lines


def _taken_away(posterior: Posterior, found: _Forecasts, scorer: Scorer) -> FloatArray:
    """Return the energy of forecast errors that each cause of the best fit takes away, (cause,).

    What all of them take, shared in proportion to what is lost without each, the others fitted anew: these make up for
    most of it where they resemble it.
    """
    keys = [candidate.key for candidate in posterior.fits[0].hypothesis.candidates]
    whole, lost = found.drawn.energy - found.extended.energy, np.zeros(len(keys))
    for number, key in enumerate(keys):
        rest = set(keys) - {key}
        fits = (item for item in posterior.fits if {c.key for c in item.hypothesis.candidates} == rest)
        without = next(fits, None) if rest else None
        energy = found.drawn.energy if without is None else scorer.forecast(without).energy
        lost[number] = max(energy - found.extended.energy, TINY)
    return np.asarray(whole * lost / lost.sum())
