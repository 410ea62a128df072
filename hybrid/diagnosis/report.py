"""The report of a diagnosis: as JSON in the contract's words, and in a few lines that an engineer reads."""

from collections.abc import Iterable
from typing import Any

from fe_models.causes.wording import at_place, kind_words
from fe_models.recordings import TOLERANCE
from hybrid.diagnosis.config import REPORT
from hybrid.diagnosis.learned.gain import Gain, Trained
from hybrid.diagnosis.next_measurement.recommendation import NextMeasurement
from hybrid.diagnosis.observed.observation_report import describe_observations, observations_table
from hybrid.diagnosis.outcome.calibration import Calibrated
from hybrid.diagnosis.outcome.conclusion import Diagnosis
from hybrid.diagnosis.outcome.findings import NOT_ON_THE_LIST, OTHER_CAUSES, Alternative, Finding, in_words
from hybrid.diagnosis.outcome.verdict import Verdict, is_at_floor
from hybrid.diagnosis.probability import two_decimals

HEADLINES = {
    Verdict.NOTHING_WRONG: "Nothing is wrong: calibrated within its uncertainty, the simulation forecasts {reach}.",
    Verdict.EXPLAINED: "The simulation is wrong, and {causes} named below.",
    Verdict.PARTLY_EXPLAINED: "The simulation is wrong; what is named may be part of it, or stand for something else.",
    Verdict.UNEXPLAINED: "The simulation is wrong, and nothing on the list of causes explains it.",
}
ONE_STRUCTURE = {
    True: "  All recordings are of one structure, as far as they tell.",
    False: "  The recordings are not all alike: see below.",
}
KIND_OPEN = "The simulation is wrong. These sensors cannot tell which of several causes it is; the likeliest is below."
PLACE_OPEN = "The simulation is wrong. The kind of its cause is probably the one below; sensors leave its place open."
REMAINDERS = {
    OTHER_CAUSES: "Other causes, each less probable, or several at once",
    NOT_ON_THE_LIST: "Something that is not on the list of causes",
}
ERROR_ENERGY = "the forecast error's energy beyond noise"
# The floor is estimated, and a forecast may be below it:
AT_FLOOR, NOT_AT_FLOOR = ", at the noise floor (about {floor:.4f})", ", above the noise floor (about {floor:.4f})"
FORECAST_AT_NOISE = "as well as the noise lets it"
FORECAST_WITHIN_TOLERANCE = "to within the stated tolerance, {tolerance:.0%} of the noise floor"
FORECAST_NEAR_NOISE = "nearly as well as the noise lets it, and leaves nothing but noise of the training recordings"


def report_table(diagnosis: Diagnosis, gain: Gain | None = None) -> dict[str, Any]:
    """Return the report as plain data, ready for JSON; ``gain``: what was learned on top, where it was."""
    return with_gain(_table(diagnosis), gain)


def with_gain(table: dict[str, Any], gain: Gain | None) -> dict[str, Any]:
    """Return a report's ``table``, changed in place, with what was learned on top, where it was."""
    if gain is not None:
        table["notes"] += gain.notes
        if gain.extended is not None:
            table["scores"]["hybrid"] = _scores(gain.extended)
        both = {"nominal": gain.nominal, "extended": gain.extended}
        table["hybrid"] = {
            name: {**_scores(trained), "learned_share": trained.share}
            for name, trained in both.items()
            if trained is not None
        }
        table["learned_residual"] = {
            name: [vars(place) for place in trained.places] for name, trained in both.items() if trained is not None
        }
    return table


def _scores(trained: Trained) -> dict[str, float | None]:
    return {"measured": trained.measured, "held_out": trained.held_out}


def _table(diagnosis: Diagnosis) -> dict[str, Any]:
    return {
        "schema": 1,
        "verdict": diagnosis.verdict.value,
        "headline": headline(diagnosis),
        "findings": [finding_table(finding) for finding in diagnosis.findings],
        "calibration": calibration_table(diagnosis.calibration),
        "unexplained_fraction": diagnosis.unexplained,
        "scores": dict(diagnosis.scores),
        "noise_floor": diagnosis.noise_floor,
        "seconds": round(diagnosis.seconds, 2),
        "shown": observations_table(diagnosis.observations) | {"one_structure": diagnosis.alike},
        **next_table(diagnosis.next_measurement),
        "notes": list(diagnosis.notes),
    }


def next_table(then: NextMeasurement | None) -> dict[str, Any]:
    """Return what to measure next as plain data; nothing where there is nothing to tell apart."""
    return {} if then is None else {"measure_next": then.as_json()}


def next_lines(then: NextMeasurement | None) -> list[str]:
    """Return what to measure next in lines."""
    if then is None:
        return []
    first, *more = (f"{sentence[0].upper()}{sentence[1:]}." for sentence in then.sentences)
    return [f"Measure this next: {first}", *(f"  {sentence}" for sentence in more)]


def _explained(finding: Finding) -> str:
    if finding.explains < REPORT.min_explained_share:
        return "recordings for training show it, those for testing hardly"
    return explained_in_words(finding.explains, ERROR_ENERGY)


def calibration_table(calibration: Iterable[Calibrated]) -> list[dict[str, Any]]:
    """Return the nominal values that have moved as plain data, in the contract's words."""
    return [
        {"what": item.quantity, "location": item.location, "factor": {"value": item.factor, "std": item.std}}
        for item in calibration
        if abs(item.factor - 1) > REPORT.min_factor_change
    ]


def finding_table(finding: Finding) -> dict[str, Any]:
    """Return a finding as plain data, in the contract's words."""
    return {
        "kind": finding.cause.kind,
        "location": finding.cause.location,
        "parameters": {word: vars(item) for word, item in finding.parameters.items()},
        "probability": finding.probability,
        "explains": finding.explains,
        "recordings": list(dict.fromkeys(finding.recordings)),  # several motions in one file share its name
        "probability_of_kind": min(finding.probability_of_kind, 1.0),  # wherever it is
        "alternatives": [_alternative(item) for item in finding.alternatives],
        "sentence": finding.sentence,
        **({} if finding.gain is None else {"gain": finding.gain}),
    }


def _alternative(item: Alternative) -> dict[str, Any]:
    sizes = {word: vars(parameter) for word, parameter in item.parameters.items()}
    return {**vars(item), "parameters": sizes}


def describe_diagnosis(diagnosis: Diagnosis, gain: Gain | None = None) -> str:
    """Return the report in a few lines, after tables of what the nominal simulation shows."""
    alike = [] if diagnosis.alike is None else [ONE_STRUCTURE[diagnosis.alike]]
    return "\n".join([*describe_observations(diagnosis.observations), *alike, "", summary(diagnosis, gain)])


def summary(diagnosis: Diagnosis, gain: Gain | None = None) -> str:
    """Return the answer: headline, findings with their rivals, forecasts before and after, notes."""
    lines = [headline(diagnosis)]
    for finding in diagnosis.findings:
        lines += finding_lines(finding, _explained(finding))
    lines += next_lines(diagnosis.next_measurement)
    lines += left_lines(diagnosis.unexplained, ERROR_ENERGY) if diagnosis.findings else []
    lines += score_lines(diagnosis.scores, diagnosis.noise_floor, diagnosis.tolerance, bool(diagnosis.findings))
    if gain is not None:
        lines += hybrid_lines(gain)
    lines += [f"Note: {note}." for note in (*diagnosis.notes, *(gain.notes if gain else ()))]
    return "\n".join(lines)


def finding_lines(finding: Finding, explained: str, *facts: str) -> list[str]:
    """Return a finding in lines: what is wrong, how probable that is, what is ``explained``, where anything is, further
    ``facts``, and its rivals.
    """
    first = f"{_probability(finding)}; {explained}" if explained else _probability(finding)
    return [f"- {finding.sentence}", *(f"  {fact}." for fact in (first, *facts)), *_rival_lines(finding)]


def explained_in_words(share: float, measure: str) -> str:
    """Return which ``share`` of a ``measure`` of what is wrong a finding explains."""
    return f"explains {share:.0%} of {measure}"


def left_lines(share: float, measure: str) -> list[str]:
    """Return which ``share`` of a ``measure`` of what was wrong the findings leave, in a line."""
    return [f"Left unexplained: {share:.1%} of {measure}."]


def score_lines(
    scores: dict[str, dict[str, float | None]], floor: float, tolerance: float, is_named: bool
) -> list[str]:
    """Return the forecasts before and after in words, with the noise ``floor`` that the second may reach within the
    ``tolerance``.
    """
    base, extended = scores["baseline"], scores["extended"]
    after = "after" if is_named else "without a named cause"
    reached = AT_FLOOR if is_at_floor(extended["measured"], floor, tolerance) else NOT_AT_FLOOR
    lines = [
        f"Forecast NRMSE: {base['measured']:.4f} before, {extended['measured']:.4f} {after}"
        f"{reached.format(floor=floor)}."
    ]
    if base["held_out"] is not None:
        lines.append(f"Held-out sensors: {base['held_out']:.4f} before, {extended['held_out']:.4f} {after}.")
    return lines


def headline(diagnosis: Diagnosis) -> str:
    """Return the answer in one sentence, no surer than the probabilities of what it names."""
    unsure = [finding for finding in diagnosis.findings if finding.probability < REPORT.min_named_probability]
    if diagnosis.verdict is Verdict.EXPLAINED and unsure:
        return (
            PLACE_OPEN
            if all(finding.probability_of_kind >= REPORT.min_named_probability for finding in unsure)
            else KIND_OPEN
        )
    causes = "the causes are" if len(diagnosis.findings) > 1 else "the cause is"
    return HEADLINES[diagnosis.verdict].format(causes=causes, reach=_reach(diagnosis))


def _reach(diagnosis: Diagnosis) -> str:
    """Return how near to the noise floor forecasts come, in words."""
    error, floor = diagnosis.scores["extended"]["measured"], diagnosis.noise_floor
    if error is None or is_at_floor(error, floor, TOLERANCE):
        return FORECAST_AT_NOISE
    if is_at_floor(error, floor, diagnosis.tolerance):
        return FORECAST_WITHIN_TOLERANCE.format(tolerance=diagnosis.tolerance)
    return FORECAST_NEAR_NOISE


def _probability(finding: Finding) -> str:
    """Return how probable a finding is; where it may be of its kind elsewhere, that of the kind, and the places."""
    same = [item for item in finding.alternatives if item.kind == finding.cause.kind]
    if not same:
        return f"Probability {two_decimals(finding.probability)}"
    listed = same[: REPORT.max_places_listed]
    places = [f"{at_place(item.location)} ({two_decimals(item.probability)})" for item in listed]
    more = len(same) - len(places)
    others = ", ".join(places) + (f" and {more} more places" if more else "")
    return (
        f"Probability {two_decimals(finding.probability)} at this place,"
        f" {two_decimals(finding.probability_of_kind)} of its kind ({kind_words(finding.cause.kind)}), here or {others}"
    )


def _rival_lines(finding: Finding) -> list[str]:
    """Return a line on each of the first rivals of another kind, one on the others, and those on what is left."""
    rivals = [item for item in finding.alternatives if not item.is_remainder and item.kind != finding.cause.kind]
    lines = [
        f"  Cannot be ruled out: {rival_words(item)} ({two_decimals(item.probability)})."
        for item in rivals[: REPORT.max_rivals_listed]
    ]
    if len(rivals) > REPORT.max_rivals_listed:
        lines.append(f"  And {len(rivals) - REPORT.max_rivals_listed} more.")
    rest = [item for item in finding.alternatives if item.is_remainder]
    return lines + [f"  {rival_words(item)}: {two_decimals(item.probability)}." for item in rest]


def rival_words(rival: Alternative) -> str:
    """Return what may stand in a finding's place, in words, with its size where that is known."""
    if rival.is_remainder:
        return REMAINDERS[rival.kind]
    sizes = "".join(f", {word} {in_words(item)}" for word, item in rival.parameters.items())
    return f"{kind_words(rival.kind)} {at_place(rival.location)}{sizes}"


def hybrid_lines(gain: Gain) -> list[str]:
    """Return the hybrid's scores on both structures, and where its learned forces act."""
    lines = []
    for name, trained in (("nominal", gain.nominal), ("extended", gain.extended)):
        if trained is None:
            continue
        apart = "" if trained.held_out is None else f", held-out {trained.held_out:.4f}"
        lines.append(f"Hybrid model on the {name} structure: NRMSE {trained.measured:.4f}{apart}.")
        for place in trained.places[: REPORT.max_learned_places_listed]:
            laws = ", ".join(f"{kind_words(word)} {part:.0%}" for word, part in list(place.laws.items())[:3])
            lines.append(
                f"  learned {at_place(place.location)}: {place.share:.0%} of it; of that explain {laws};"
                f" {place.rest:.0%} nothing"
            )
    return lines
