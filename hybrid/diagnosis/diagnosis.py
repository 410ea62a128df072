"""The whole chain: show what a simulation gets wrong, name the cause, extend the model, measure the gain."""

from collections.abc import Callable
from dataclasses import dataclass, replace
from time import perf_counter
from typing import Any

import numpy as np

from fe_models.dofs import FloatArray
from fe_models.errors import InputError
from fe_models.recordings import Dataset
from fe_models.structure import Structure
from hybrid.diagnosis.acting import recordings_of
from hybrid.diagnosis.advice import Advice, advise
from hybrid.diagnosis.candidate import Candidate
from hybrid.diagnosis.candidates import all_candidates
from hybrid.diagnosis.channels import usable
from hybrid.diagnosis.crossvalidation import as_recordings, folds_of
from hybrid.diagnosis.discrepancy import in_units_of, search_frame
from hybrid.diagnosis.example import Example, example_of
from hybrid.diagnosis.extend import extended_structure
from hybrid.diagnosis.findings import Finding, Verdict, cause_of, place_words, reported_location, sentence_of
from hybrid.diagnosis.fitting import Fit, fit
from hybrid.diagnosis.forecasting import Forecast, Model, forecast
from hybrid.diagnosis.frame import Frame
from hybrid.diagnosis.hypothesis import Hypothesis
from hybrid.diagnosis.noise import Band, excess, noise_of_recordings, structure_band
from hybrid.diagnosis.pairs import asks_for_more, misfit, pair_fits, short_fit
from hybrid.diagnosis.pairs import left as left_of
from hybrid.diagnosis.places import Motion
from hybrid.diagnosis.plant import Plant, plant_of
from hybrid.diagnosis.posterior import Posterior, of_candidate, posterior_of, rivals_of
from hybrid.diagnosis.records import batches_of, columns_of, measured_columns
from hybrid.diagnosis.search import Lengths, contest, lengths_of
from hybrid.diagnosis.show import Shown, show
from hybrid.diagnosis.switching import fit_switched

MATERIAL = 0.05  # of the noise floor: by how much a cause must improve the forecast, and what counts as reaching it
WHOLLY = 0.03  # of the excess energy: what may be left where all is called explained
PARTLY = 0.5  # of it: beyond, nothing is
DOUBT = 0.85  # most probability of a finding beside which something significant is left unexplained
DEVIATION = 2.5  # of its stated standard deviations: how far a nominal value may be calibrated
NOISE_OFF = (0.5, 1.5)  # of the noise that the recordings themselves tell: how far it may be told anew
FAR_FROM_NOISE = "the nominal model leaves far more than noise: what it lacks counted as noise in the search"
RIVALS = 0.005  # least probability of an alternative that is told


@dataclass(frozen=True)
class Diagnosis:
    """All that a report says; ``notes`` what the user should know about the data."""

    verdict: Verdict
    findings: tuple[Finding, ...]
    calibration: tuple[tuple[str, dict[str, Any], float, float], ...]
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


def diagnose(dataset: Dataset, advance: Callable[[str], object] | None = None) -> Diagnosis:
    """Return the diagnosis of a chain's dataset; ``advance`` is told what is done, step by step."""
    begun = perf_counter()
    tell: Callable[[str], object] = advance or (lambda _: None)
    plant = plant_of(dataset)
    dataset, notes = usable(dataset)
    dataset, apart = as_recordings(dataset)
    notes += apart
    measured = measured_columns(dataset)
    batches = columns_of(batches_of(dataset, "train"), measured)
    rate = dataset.sampling_rate
    band = structure_band(plant, rate, dataset.lowpass)
    frame = Frame(tuple(dataset.sensors[i] for i in measured), rate, noise_of_recordings(batches, rate, band))
    nominal = Hypothesis(plant)
    lengths = lengths_of(batches, nominal.states)
    short = short_fit(plant, lengths, frame)
    searched, short = search_frame(plant, lengths, frame, short)
    if searched is not frame:
        return _diagnosed_in(searched, short, plant, dataset, lengths, frame, band, measured, notes, tell, begun)
    motion = Motion.of_states(np.concatenate(short.states), plant)
    candidates = all_candidates(plant, dataset, motion, measured)
    tell("screening")
    singles = contest(nominal, nominal.centre, candidates, lengths, frame, short, lambda: tell("single causes"))
    if singles is None:
        raise InputError("model: with its own force laws these recordings' motion grows beyond all bounds; check them")
    frame, fits = _with_better_noise([singles.base, *singles.fits], frame, band)
    posterior = posterior_of(tuple(fits), candidates)
    if left_of(posterior.fits[0], frame, band).significant and not plant.laws:
        tell("recordings apart")
        fits += fit_switched(short, posterior.fits[0], candidates, lengths, frame)
        posterior = posterior_of(tuple(fits), candidates)
    if asks_for_more(posterior.fits[0], fits[0], frame, band):
        tell("two causes")
        fits += pair_fits(posterior, candidates, batches, frame, band, lambda: tell("two causes"))
    frame, fits = _with_better_noise(fits, frame, band)
    posterior = _with_same_noise(posterior_of(tuple(fits), candidates), fits[0], frame, candidates)
    tell("forecasts")
    return _concluded(dataset, plant, fits[0], posterior, frame, band, measured, candidates, notes, begun)


def _diagnosed_in(
    searched: Frame,
    short: Fit,
    plant: Plant,
    dataset: Dataset,
    lengths: Lengths,
    frame: Frame,
    band: Band,
    measured: tuple[int, ...],
    notes: list[str],
    tell: Callable[[str], object],
    begun: float,
) -> Diagnosis:
    """Return the diagnosis by a search in which what the model lacks counts as noise: see `discrepancy`."""
    nominal = Hypothesis(plant)
    candidates = all_candidates(plant, dataset, Motion.of_states(np.concatenate(short.states), plant), measured)
    tell("screening")
    singles = contest(nominal, nominal.centre, candidates, lengths, searched, short, lambda: tell("single causes"))
    assert singles is not None  # without force laws in the model the nominal fit always answers
    fits = [singles.base, *singles.fits]
    posterior = posterior_of(tuple(fits), candidates)
    tell("recordings apart")
    fits += fit_switched(short, posterior.fits[0], candidates, lengths, searched)
    posterior = posterior_of(tuple(fits), candidates)
    best, base = (in_units_of(frame, item, searched) for item in (posterior.fits[0], fits[0]))
    if asks_for_more(best, base, frame, band):
        tell("two causes")
        fits += pair_fits(posterior, candidates, lengths.whole, searched, band, lambda: tell("two causes"))
        posterior = posterior_of(tuple(fits), candidates)
    told = replace(posterior, fits=tuple(in_units_of(frame, item, searched) for item in posterior.fits))
    times = float(np.sqrt(np.mean((searched.sigma / frame.sigma) ** 2)))
    notes = [*notes, f"{FAR_FROM_NOISE} ({times:.0f} times the noise was taken as such)"]
    tell("forecasts")
    return _concluded(dataset, plant, base, told, frame, band, measured, candidates, notes, begun)


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


def _concluded(
    dataset: Dataset,
    plant: Plant,
    base: Fit,
    posterior: Posterior,
    frame: Frame,
    band: Band,
    measured: tuple[int, ...],
    candidates: tuple[Candidate, ...],
    notes: list[str],
    begun: float,
) -> Diagnosis:
    best = posterior.fits[0]
    test, folds = batches_of(dataset, "test"), folds_of(dataset, measured)
    width = base.hypothesis.width

    def scored(item: Fit, most: float = np.inf) -> Forecast:
        """Score a fit; its nominal values moved by ``most`` of their standard deviations."""

        def model_of(one: Fit) -> Model:
            return _model(one, np.clip(one.theta, -most * width, most * width) if most < np.inf else None)

        if folds is not None:
            return folds.forecast(item, model_of, frame)
        return forecast(model_of(item), test, dataset.sensors, measured, frame)

    clipped = np.clip(base.theta, -DEVIATION * width, DEVIATION * width)
    nominal = scored(base, 0.0)
    calibrated = scored(base, DEVIATION)
    extended = scored(best)
    own = list(measured)
    floor = float(calibrated.floor[:, own].mean())
    before, after = float(calibrated.nrmse[:, own].mean()), float(extended.nrmse[:, own].mean())
    left, had = left_of(best, frame, band), left_of(base, frame, band)
    rest = max(left.total, misfit(best))
    share = rest / max(misfit(base), rest, 1e-300) if left.significant else 0.0
    reached = before <= (1 + MATERIAL) * floor and before - after <= MATERIAL * floor
    gain = nominal.energy - nominal.floor_energy
    unexplained = float(np.clip((extended.energy - extended.floor_energy) / max(gain, 1e-300), 0.0, 1.0))
    if reached and not (left_of(base, frame, band).significant and share > WHOLLY and not best.hypothesis.candidates):
        verdict = Verdict.NOTHING_WRONG
    elif not best.hypothesis.candidates:
        verdict = Verdict.UNEXPLAINED if left.significant else Verdict.NOTHING_WRONG
    elif not left.significant or share < WHOLLY:
        verdict = Verdict.EXPLAINED
    else:
        verdict = Verdict.PARTLY_EXPLAINED if share < PARTLY else Verdict.UNEXPLAINED
    if verdict is Verdict.NOTHING_WRONG and best.hypothesis.candidates:
        weak = sentence_of(*cause_of(best, len(best.hypothesis.candidates) - 1)).rstrip(".")
        notes = [*notes, f"significant, but too weak to matter for forecasts: {weak}"]
    doubt = 1.0 if verdict is Verdict.EXPLAINED and not (left.significant and share > WHOLLY / 3) else DOUBT
    named = verdict in (Verdict.EXPLAINED, Verdict.PARTLY_EXPLAINED)
    final = best if named else base
    if not named:
        extended = calibrated
    findings: tuple[Finding, ...] = ()
    if named:
        model, temper = _model(best), posterior.temper
        acting = [
            recordings_of(best, number, model, test, measured, frame, temper)
            for number in range(len(best.hypothesis.candidates))
        ]
        findings = _findings(best, posterior, scored, nominal, doubt, acting)
        notes = [*notes, *_apart(dataset, findings)]
    advice = advise(posterior, frame) if named else ()
    notes = [*notes, *(item.sentence for item in advice)]
    theta = final.theta if named else clipped
    count = base.hypothesis.nuisances
    factors = tuple(float(value) for value in np.exp(theta[:count]))
    deviation = np.sqrt(np.diag(final.covariance)[:count])
    shown = show(dataset, base, nominal, calibrated, had, frame)
    held_out = [i for i, sensor in enumerate(dataset.sensors) if sensor.role == "held_out"]
    return Diagnosis(
        verdict=verdict,
        findings=findings,
        calibration=tuple(_calibration(plant, factors, deviation)),
        unexplained=unexplained if verdict is not Verdict.NOTHING_WRONG else 0.0,
        scores={
            "baseline": _scores(nominal, own, held_out),
            "extended": _scores(extended, own, held_out),
        },
        noise_floor=floor,
        extended=extended_structure(plant, factors, findings),
        shown=shown,
        example=example_of(
            (test if folds is None else folds.tests[0])[0],
            _model(base, np.zeros_like(base.theta)),
            _model(best) if named else _model(base, clipped),
            dataset.sensors,
            measured,
            frame,
            shown.observed.frequencies,
        ),
        advice=advice,
        posterior=posterior,
        notes=tuple(notes),
        seconds=perf_counter() - begun,
    )


def _model(item: Fit, theta: FloatArray | None = None) -> Model:
    """Return a fit's model for forecasts; the size of initial states is that of the training recordings."""
    most = max(range(len(item.states)), key=lambda i: item.states[i].shape[1])
    full = [states for states in item.states if states.shape[1] == item.states[most].shape[1]]
    size = np.sqrt(np.mean(np.concatenate(full) ** 2, axis=0))
    switched = tuple(sorted({number for batch in item.batches for number in batch.off}))
    return Model(item.hypothesis, item.theta if theta is None else theta, np.maximum(size, 1e-6 * size.max()), switched)


def _findings(
    best: Fit,
    posterior: Posterior,
    scored: Callable[[Fit], Forecast],
    nominal: Forecast,
    doubt: float,
    acting: list[tuple[str, ...]],
) -> tuple[Finding, ...]:
    findings = []
    whole = scored(best)
    had = max(nominal.energy - nominal.floor_energy, 1e-300)
    for number, candidate in enumerate(best.hypothesis.candidates):
        cause, parameters = cause_of(best, number)
        without = _strongest_without(posterior, candidate)
        lost = nominal.energy if without is None else scored(without).energy
        explains = float(np.clip((lost - whole.energy) / had, 0.0, 1.0))
        rivals = rivals_of(posterior, candidate, RIVALS)
        findings.append(
            Finding(
                cause,
                parameters,
                min(of_candidate(posterior, candidate), doubt, 0.999),
                explains,
                acting[number],
                tuple((rival.kind, reported_location(rival), p) for rival, p in rivals),
                sentence_of(cause, parameters),
            )
        )
    return tuple(sorted(findings, key=lambda finding: -finding.explains))


def _apart(dataset: Dataset, findings: tuple[Finding, ...]) -> list[str]:
    """Return a line on each finding that acts in some recordings only."""
    names = list(dict.fromkeys(recording.name for recording in dataset.recordings))
    return [
        f"the recordings are not all of one structure: {finding.cause.kind} at {place_words(finding.cause.location)}"
        f" acts in {', '.join(finding.recordings)}, and does not, or too little to tell, in"
        f" {', '.join(name for name in names if name not in finding.recordings)}"
        for finding in findings
        if len(finding.recordings) < len(names)
    ]


def _strongest_without(posterior: Posterior, candidate: Candidate) -> Fit | None:
    """Return the fit of the best hypothesis less one candidate, None where that was not fitted."""
    rest = {other.key for other in posterior.fits[0].hypothesis.candidates} - {candidate.key}
    for item in posterior.fits:
        if rest and {other.key for other in item.hypothesis.candidates} == rest:
            return item
    return None


def _calibration(
    plant: Plant, factors: tuple[float, ...], deviation: FloatArray
) -> list[tuple[str, dict[str, Any], float, float]]:
    """Return quantity, location, factor and its standard deviation."""
    names: list[tuple[str, dict[str, Any]]] = [(part.quantity, part.location) for part in plant.parts]
    names += [("damping", {"modes": [mode + 1]}) for mode in range(len(plant.ratios))]
    return [
        (what, where, factor, float(factor * std))
        for (what, where), factor, std in zip(names, factors, deviation, strict=True)
    ]


def _scores(found: Forecast, measured: list[int], held_out: list[int]) -> dict[str, float | None]:
    apart = float(found.nrmse[:, held_out].mean()) if held_out else None
    return {"measured": float(found.nrmse[:, measured].mean()), "held_out": apart}
