"""The whole chain: show what a simulation gets wrong, name the cause, extend the model, measure the gain.

Two searches answer. That by time series holds every sample against the drawn structure, and tells
nearly all causes where it is as right as was stated. That by modes and motion needs no nearly right structure, and
tells what changed between recordings. A first look at the modes says which goes first; where its answer leaves
something open, the other is asked as well.
"""

from collections.abc import Callable
from dataclasses import replace
from time import perf_counter

from fe_models.causes.laws import force_laws
from fe_models.errors import InputError
from fe_models.nominal import require_mode_in_band
from fe_models.recordings import Dataset
from fe_models.structure import Structure
from hybrid.diagnosis.answer import Answer
from hybrid.diagnosis.config import SEARCH_CHOICE
from hybrid.diagnosis.modes_and_motion.conclusion import ModalDiagnosis
from hybrid.diagnosis.modes_and_motion.look import Look, look_at
from hybrid.diagnosis.modes_and_motion.modal_diagnosis import OneStructure, diagnosed
from hybrid.diagnosis.outcome.conclusion import Diagnosis
from hybrid.diagnosis.outcome.config import VERDICT
from hybrid.diagnosis.recorded.amount import limited
from hybrid.diagnosis.series_diagnosis import SeriesSearch, diagnose_series
from hybrid.diagnosis.stage_names import MODAL_STAGES, SERIES_STAGES

LOOK_STAGES = MODAL_STAGES[:2]  # the stages of a first look
MODES_ALONE = (
    "the modes that the dataset lists are what was diagnosed; its recordings were not used: leave [[modes]] out to have"
    " them identified from these, with force laws and forecasts"
)


def diagnose(dataset: Dataset, advance: Callable[[str], object] | None = None) -> Answer:
    """Return the diagnosis of a dataset; ``advance`` hears the name of each stage (`stage_names`) as it begins, and
    what is done in it, step by step.

    `InputError` names what in the dataset cannot be diagnosed.
    """
    if not dataset.modes:
        dataset.require_recordings("a diagnosis")
    require_mode_in_band(dataset)
    begun, tell = perf_counter(), advance or (lambda _: None)
    dataset, notes = limited(dataset)
    found = _answer(dataset, tell)
    return replace(found, seconds=perf_counter() - begun, notes=(*notes, *found.notes))


def _answer(dataset: Dataset, tell: Callable[[str], object]) -> Answer:
    """Return the answer of the only search that the dataset allows; else that of the search that a first look at the
    modes takes for the better one, and of the other one, too, where it leaves something open.
    """
    if dataset.modes:
        found = _by_modes(look_at(dataset, tell), tell)
        return replace(found, notes=(*found.notes, MODES_ALONE)) if dataset.recordings else found
    if not isinstance(dataset.model, Structure):
        return _by_modes(look_at(dataset, tell), tell)
    if _only_series_tell(dataset.model, dataset):
        return _by_series(dataset, tell)
    if len(dataset.sampling_rates) > 1:
        return _by_modes(look_at(dataset, tell), tell)
    try:
        look = look_at(dataset, tell)
    except InputError:  # no mode is seen: the series say why, in their own words
        return _by_series(dataset, tell, LOOK_STAGES[:1])
    if look.ambient:
        return _by_modes(look, tell)
    if (look.measured.nominal.is_chain and not look.is_far) or look.is_near:  # of such a chain series take seconds
        return _of_nearly_right(dataset, look, tell)
    modal = _by_modes(look, tell)
    if _is_settled(modal) or modal.is_far:
        return modal
    _skip(MODAL_STAGES, tell)
    search = SeriesSearch.with_singles(dataset, tell)
    hopeless = modal.strays and not look.measured.nominal.is_chain and search.singles.are_hopeless
    return _better(_seen_in(look, search.finished(tell, pairs=not hopeless)), modal)


def _of_nearly_right(dataset: Dataset, look: Look, tell: Callable[[str], object]) -> Answer:
    """Return the answer by series, by halves too, as every sample tells more than modes do, unless modes and motion
    leave nothing open where series do.

    Of a frame series go on for minutes beyond single causes. Where these leave most, and the motion is of no constant
    values, a force law in it is looked for before; where none explains it, two causes at once are not tried.
    """
    _skip(MODAL_STAGES[len(LOOK_STAGES) :], tell)
    search, one_structure = SeriesSearch.with_singles(dataset, tell), OneStructure(look)
    hopeless = not look.measured.nominal.is_chain and search.singles.are_hopeless
    law_is_sought = hopeless and not one_structure.moves_by_constants
    if law_is_sought:
        tell("a force law in the motion")
        law = one_structure.by_law()
        if law is not None and _explains(law):
            _skip(SERIES_STAGES, tell)
            return law
    series = _seen_in(look, search.finished(tell, pairs=not law_is_sought))
    if not series.verdict.is_wanting or law_is_sought:
        return series
    if look.differs:
        modal: ModalDiagnosis | None = _by_modes(look, tell)
    else:
        modal = one_structure.by_all(tell) if one_structure.moves_by_constants else one_structure.by_law()
    return modal if modal is not None and _explains(modal) else series


def _by_series(dataset: Dataset, tell: Callable[[str], object], done: tuple[str, ...] = ()) -> Diagnosis:
    _skip(MODAL_STAGES[len(done) :], tell)
    return diagnose_series(dataset, tell)


def _seen_in(look: Look, found: Diagnosis) -> Diagnosis:
    """Return the answer by series with what a look identified: pages show it, and need not identify it again."""
    return replace(found, identified=look.identified)


def _by_modes(look: Look, tell: Callable[[str], object]) -> ModalDiagnosis:
    found = diagnosed(look, tell)
    _skip(SERIES_STAGES, tell)
    return found


def _only_series_tell(structure: Structure, dataset: Dataset) -> bool:
    """Return whether known forces act, or the simulation has something that modes do not tell: time steps, laws or a
    modal model of its own.
    """
    assumed = dataset.assumptions
    return (
        dataset.is_loaded
        or assumed.modal_model is not None
        or assumed.integrator != "exact"
        or bool(force_laws(structure))
    )


def _is_settled(found: Answer) -> bool:
    """Return whether an answer leaves nothing open: all is explained, by causes that are as good as sure."""
    return not found.verdict.is_wanting and all(
        finding.probability >= SEARCH_CHOICE.sure_probability for finding in found.findings
    )


def _explains(found: ModalDiagnosis) -> bool:
    """Return whether an answer leaves nothing open, forecasts as near to the noise as a structure that is nearly right
    must come: a law that only resembles what acts may do much better than none. Of the only recording of a state
    too little is known to forecast it as well.
    """
    forecasts = found.forecasts
    if found.verdict.is_wanting:
        return False
    if forecasts is not None and forecasts.alone:
        forecasts = forecasts.shared
    if forecasts is None:
        return True
    error = forecasts.scores["extended"]["measured"] or 0.0
    return error <= VERDICT.max_near_ratio * forecasts.floor or forecasts.unexplained < VERDICT.max_negligible_share


def _better(series: Diagnosis, modal: ModalDiagnosis) -> Answer:
    """Return the answer that explains more: all rather than a part, by a cause rather than by none, surely rather than
    perhaps.
    """
    return modal if _merit(modal) > _merit(series) else series


def _merit(found: Answer) -> tuple[bool, bool, float]:
    """Return what an answer is worth: whether it explains all, whether it names a cause, and how surely."""
    least = min((finding.probability for finding in found.findings), default=0.0)
    return not found.verdict.is_wanting, bool(found.findings), least


def _skip(stages: tuple[str, ...], tell: Callable[[str], object]) -> None:
    """Go past the stages of the search that is not needed."""
    for stage in stages:
        tell(stage)
