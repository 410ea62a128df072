"""What a user should know beside the findings: notes on a ruling."""

from collections import Counter

from fe_models.causes import HarmonicForce, SensorEffect, StiffnessChange
from fe_models.causes.wording import at_place, kind_words, place_words
from hybrid.diagnosis.fitting.calibration_deviation import factors_off
from hybrid.diagnosis.fitting.excess_energy import excess_energy
from hybrid.diagnosis.observed.observations import Observations
from hybrid.diagnosis.observed.uniform_errors import uniform_damping_error, uniform_frequency_error
from hybrid.diagnosis.outcome.calibration import astray, dispersion_of, far_off
from hybrid.diagnosis.outcome.config import VERDICT
from hybrid.diagnosis.outcome.findings import Finding
from hybrid.diagnosis.outcome.folding import folding_of
from hybrid.diagnosis.outcome.hum import line_of
from hybrid.diagnosis.outcome.loading import loading_of
from hybrid.diagnosis.outcome.materiality import weak
from hybrid.diagnosis.outcome.mounting import mounting_of
from hybrid.diagnosis.outcome.rest import rest_of
from hybrid.diagnosis.outcome.ruling import Ruling
from hybrid.diagnosis.outcome.simulation import modal_notes
from hybrid.diagnosis.outcome.too_few import too_few
from hybrid.diagnosis.outcome.verdict import Verdict
from hybrid.diagnosis.recorded.motions import in_words, motions_of

UNSEEN = (
    "the training recordings show nothing{more} wrong, but test recordings do ({names}): what acts there is not felt in"
    ' training, or came later; take such a recording for training (role = "train") and diagnose again'
)
OR_MASS = (
    "free vibrations hardly tell the stiffness of {elements} from their mass: {times:.4g} times what is drawn of that"
    " would look much like it, and is no cause on the list"
)
BENT = (
    "motions of {names} are so large that the frame's geometry shows, which recordings for training do not: forecasts"
    " take it into account"
)


def remarks_on(ruling: Ruling, findings: tuple[Finding, ...], shown: Observations) -> tuple[str, ...]:
    """Return the notes on a ruling, on its findings, and on what is ``shown`` of the simulation."""
    loading, hum = _loading(ruling), _hum(ruling)
    return (
        *ruling.notes,
        *_on_causes(ruling, findings),
        *_rest(ruling, shown),
        *hum,
        *_folding(ruling),
        *loading,
        *([] if hum else _unseen(ruling)),  # hum may be where no motion is looked for
        *modal_notes(ruling.simulation, ruling.found.nominal, ruling.found.own, ruling.scorer, ruling.is_named),
        *_bent(ruling),
        *too_few(ruling.reported, ruling.scorer, ruling.errors.floor),
        *dispersion_of(ruling.reported, ruling.posterior.temper),
        *([] if loading else _all_off(ruling, shown)),
    )


def _on_causes(ruling: Ruling, findings: tuple[Finding, ...]) -> list[str]:
    """Return what there is to say of causes that are named, or of those that are not, where nothing is wrong."""
    best, notes = ruling.best, list[str]()
    if ruling.is_named:
        notes += _apart(ruling, findings)
        notes += _or_mass(ruling, findings)
        notes += astray(best, VERDICT.max_usual_sigma) if ruling.verdict is Verdict.PARTLY_EXPLAINED else []
    elif ruling.verdict is Verdict.NOTHING_WRONG:
        notes += far_off(ruling.reported)
        if ruling.simulation.fit is ruling.evidence.base:  # else a cause may matter, if not for the user's modal model
            causes = range(len(best.hypothesis.candidates))
            notes += [weak(best, number, ruling.posterior.widened) for number in causes]
    return notes


def _apart(ruling: Ruling, findings: tuple[Finding, ...]) -> list[str]:
    """Return a line on each finding that acts in some recordings only."""
    every, lines = motions_of(ruling.setting.dataset), []
    for finding in findings:
        cause, acting = finding.cause, Counter(finding.recordings)
        without = every - acting
        alike = "all alike" if isinstance(cause, HarmonicForce | SensorEffect) else "all of one structure"
        if without:
            lines.append(
                f"the recordings are not {alike}: {kind_words(cause.kind)} {at_place(cause.location)} acts in"
                f" {in_words(acting, every)}, and does not, or too little to tell, in {in_words(without, every)}"
            )
    return lines


def _or_mass(ruling: Ruling, findings: tuple[Finding, ...]) -> list[str]:
    """Return a line on a stiffness of several elements as one, which a mass of theirs looks like: no cause is that."""
    if ruling.setting.dataset.is_loaded:
        return []  # known forces distinguish stiffness from mass
    return [
        OR_MASS.format(elements=place_words(cause.location), times=1 / cause.factor)
        for cause in (finding.cause for finding in findings)
        if isinstance(cause, StiffnessChange) and len(cause.elements) > 1 and isinstance(cause.factor, float)
    ]


def _rest(ruling: Ruling, shown: Observations) -> list[str]:
    """Return what the rest looks like, where something is left that nothing explains."""
    noise_model = ruling.evidence.noise_model
    if (
        not ruling.verdict.is_wanting
        or not excess_energy(ruling.reported, noise_model, ruling.setting.band).significant
    ):
        return []
    mounted = mounting_of(ruling.evidence.base, noise_model)
    rest = rest_of(ruling.reported, shown.observed.frequencies, noise_model)
    return [rest, *([] if mounted is None else [mounted])]


def _hum(ruling: Ruling) -> list[str]:
    """Return a line on each harmonic force that one sensor's own tone may be, or on a tone among noise."""
    noise_model = ruling.evidence.noise_model
    if ruling.best.hypothesis.candidates:
        told = [] if ruling.verdict is Verdict.NOTHING_WRONG else [hum.sentence for hum in ruling.hums]
    else:
        told = (
            []
            if excess_energy(ruling.reported, noise_model, ruling.setting.band).significant
            else [line_of(ruling.reported, noise_model)]
        )
    return [sentence for sentence in told if sentence is not None]


def _folding(ruling: Ruling) -> list[str]:
    """Return a line on fast modes that recordings show elsewhere, where more than noise is left."""
    noise_model, setting = ruling.evidence.noise_model, ruling.setting
    astray = (
        ruling.verdict is not Verdict.NOTHING_WRONG
        and excess_energy(ruling.reported, noise_model, setting.band).significant
    )
    return folding_of(ruling.reported, setting, noise_model) if astray else []


def _loading(ruling: Ruling) -> list[str]:
    """Return a line on loads that would explain what no cause does, were they of another size."""
    told = loading_of(ruling.evidence.base, ruling.evidence.noise_model) if ruling.verdict.is_wanting else None
    return [] if told is None else [told]


def _unseen(ruling: Ruling) -> list[str]:
    """Return a note on test recordings whose forecasts are wrong, where nothing of the training recordings is."""
    named, scorer = ruling.is_named, ruling.scorer
    if ruling.verdict is Verdict.NOTHING_WRONG or (named and ruling.errors.near):
        return []
    item, forecast, more = (
        (ruling.best, ruling.found.extended, " more") if named else (ruling.evidence.base, ruling.found.own, "")
    )
    if excess_energy(item, ruling.evidence.noise_model, ruling.setting.band).significant or factors_off(item):
        return []
    names = ", ".join(scorer.wrong_in(forecast))
    return [UNSEEN.format(more=more, names=names)] if names else []


def _bent(ruling: Ruling) -> list[str]:
    """Return a note on test recordings that show a frame's geometry where those for training do not, if such forecasts
    are good.
    """
    if not (ruling.errors.near or ruling.verdict is Verdict.NOTHING_WRONG):
        return []
    names = ", ".join(ruling.scorer.bent_in(ruling.reported))
    return [BENT.format(names=names)] if names else []


def _all_off(ruling: Ruling, shown: Observations) -> list[str]:
    """Return notes on what is off in all modes: of damping, where something is left that no cause explains."""
    uncertainty = ruling.setting.dataset.assumptions.uncertainty
    return uniform_frequency_error(shown, uncertainty) + (
        uniform_damping_error(shown, uncertainty) if ruling.verdict.is_wanting else []
    )
