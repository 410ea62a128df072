"""Diagnosis by modes: of recordings, whose modes are identified first and whose motion shows force laws, or of a table.

It needs no nearly right model: nominal values may be off by far more than was stated, and how far is estimated.
"""

from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import cached_property
from time import perf_counter

import numpy as np
from threadpoolctl import threadpool_limits

from fe_models.causes.candidate import Candidate, LawCandidate
from fe_models.causes.known import Channel
from fe_models.causes.places import Motion
from fe_models.linear import LinearModel
from fe_models.nominal import require_mode_in_band
from fe_models.recordings import Dataset
from hybrid.diagnosis.config import THREADS
from hybrid.diagnosis.discrepancy.law_search import LawSearch
from hybrid.diagnosis.discrepancy.laws_in_recordings import laws_in_recordings, may_have_laws
from hybrid.diagnosis.modal.all_candidates import all_candidates_of
from hybrid.diagnosis.modal.evidence import ModalFit
from hybrid.diagnosis.modal.modal_data import ModalData
from hybrid.diagnosis.modal.nominal_fit import NominalFit, null_fit
from hybrid.diagnosis.modal.search import ClaimSearch, probabilities
from hybrid.diagnosis.modes_and_motion.change_gains import gains_of
from hybrid.diagnosis.modes_and_motion.conclusion import Claims, ModalDiagnosis, ModesAndMotion, concluded
from hybrid.diagnosis.modes_and_motion.faulty_sensors import notes_on_sensors
from hybrid.diagnosis.modes_and_motion.forecasts import ForecastMotion
from hybrid.diagnosis.modes_and_motion.look import Look, look_at, rebased
from hybrid.diagnosis.modes_and_motion.modes_less_law import measured_less_law
from hybrid.diagnosis.modes_and_motion.motion_fit import MotionFit, motion_by_claim, motion_by_law
from hybrid.diagnosis.modes_and_motion.unsure_modes import ranked_with_unsure_modes
from hybrid.diagnosis.recorded.amount import limited

UNKNOWN_FORCES = (
    "unknown forces, as of wind and traffic, drove {names}: no force law was looked for, and shapes have no scale, so"
    " that masses and stiffnesses are known but for a factor that all of them share"
)


def diagnose_modes(dataset: Dataset, advance: Callable[[str], object] | None = None) -> ModalDiagnosis:
    """Return the diagnosis of a dataset by the modes of its training recordings; ``advance`` hears what is done.

    `InputError` where the dataset has no structure, or no recording shows a mode of it.
    """
    require_mode_in_band(dataset)
    begun, tell = perf_counter(), advance or (lambda _: None)
    dataset, notes = limited(dataset)
    found = diagnosed(look_at(dataset, tell), tell)
    return replace(found, seconds=perf_counter() - begun, notes=(*notes, *found.notes))


def diagnosed(look: Look, tell: Callable[[str], object]) -> ModalDiagnosis:
    """Return the diagnosis of a dataset that was looked at."""
    with threadpool_limits(THREADS.linear_algebra, "blas"):
        bare = _search_in(rebased(look.dataset, look.nominal_fit))
        return _answer(look, bare.searched(tell), tell)


@dataclass(frozen=True, eq=False)
class OneStructure:
    """What modes and motion add where all series together leave something open, of recordings of one structure that
    were looked at (``look``).
    """

    look: Look

    @cached_property
    def _bare(self) -> "_Searched":
        return _search_in(rebased(self.look.dataset, self.look.nominal_fit))

    @cached_property
    def _motion(self) -> MotionFit | None:
        nominal_fit = self._bare.nominal_fit
        with threadpool_limits(THREADS.linear_algebra, "blas"):
            return motion_by_claim(self.look.dataset, nominal_fit.measured, nominal_fit.fit)

    @property
    def moves_by_constants(self) -> bool:
        """Whether the motion of each recording is that of constant values, or not known: where it is not, no linear
        cause makes it so; a law may.
        """
        return self._motion is None or self._motion.track.discrepancy.is_usual

    def by_law(self) -> ModalDiagnosis | None:
        """Return the diagnosis by a force law in the place of all linear causes; None where none is named."""
        with threadpool_limits(THREADS.linear_algebra, "blas"):
            evidence = _with_motion(self.look, self._bare, self._motion)
            if evidence.laws is None or evidence.laws.named is None:
                return None
            return _concluded(self.look, self._bare, evidence)

    def by_all(self, tell: Callable[[str], object]) -> ModalDiagnosis:
        """Return the diagnosis by all causes that modes and motion tell; ``tell`` hears what is done."""
        with threadpool_limits(THREADS.linear_algebra, "blas"):
            return _answer(self.look, self._bare.searched(tell), tell)


@dataclass(frozen=True, eq=False)
class _Searched:
    """The ``fits`` of all claims, most probable first, by a ``search`` that begins with the ``nominal_fit``; the kinds
    of force ``laws`` that the structure may have.
    """

    nominal_fit: NominalFit
    search: ClaimSearch
    fits: list[ModalFit]
    laws: frozenset[str]

    def searched(self, tell: Callable[[str], object]) -> "_Searched":
        """Return the same with the fits of all that was tried."""
        return replace(self, fits=self.search.run(self.nominal_fit.fit, tell))

    @property
    def measured(self) -> ModalData:
        """What claims are judged by."""
        return self.nominal_fit.measured

    @property
    def claims(self) -> Claims:
        """The claims with their probabilities."""
        return Claims(self.measured, self.fits, probabilities(self.search, self.fits))


def _search_in(nominal_fit: NominalFit) -> _Searched:
    """Return the search for causes that modes tell, before it is made."""
    candidates = _candidates(nominal_fit.measured)
    laws = frozenset(own.kind for own in candidates if isinstance(own, LawCandidate))
    return _Searched(nominal_fit, ClaimSearch.of(nominal_fit.measured, candidates), [nominal_fit.fit], laws)


def _answer(look: Look, known: _Searched, tell: Callable[[str], object]) -> ModalDiagnosis:
    """Return the diagnosis by claims that are ``known``, and by what the motion shows beside them."""
    tell("force laws")
    evidence = _with_motion(look, known)
    tell("forecasts by modes")
    return _concluded(look, known, evidence)


def _concluded(look: Look, known: _Searched, evidence: ModesAndMotion) -> ModalDiagnosis:
    """Return what the evidence amounts to, with what was identified and what competed."""
    claims, motion = evidence.claims, evidence.motion
    if motion is not None and motion.explained.law is None:  # a law would have to be taken along
        claims = replace(claims, gains=gains_of(look.dataset, claims.measured, claims.fits[0]))
    answer = concluded(replace(evidence, claims=claims), look.dataset.sensors)
    names = ", ".join(look.ambient)
    about = ((UNKNOWN_FORCES.format(names=names),) if names else ()) + notes_on_sensors(look.measured)
    kinds = {own.kind for own in known.search.candidates} | (known.laws if evidence.laws is not None else set())
    return replace(answer, notes=(*answer.notes, *about), identified=look.identified, competed=tuple(sorted(kinds)))


def _with_motion(look: Look, known: _Searched, explained: MotionFit | None = None) -> ModesAndMotion:
    """Return the claims, the search for force laws where the claims leave something of the motion, and the motion by
    what was found; None where motion tells no laws, or none was left to look for. ``explained``: the motion by the
    best claim, where it is known.
    """
    dataset, drawn, best = look.dataset, look.nominal_fit, known.fits[0]
    if look.ambient or not may_have_laws(dataset, known.measured):
        return ModesAndMotion(known.claims, None, None)
    explained = explained or motion_by_claim(dataset, known.measured, best)
    motion = None if explained is None else ForecastMotion.of(dataset, drawn, explained)
    if explained is None or motion is None or motion.is_at_noise or isinstance(dataset.model, LinearModel):
        return ModesAndMotion(known.claims, None, motion)
    log_odds = known.search.log_odds(best.claim)
    laws = laws_in_recordings(dataset, drawn, known.nominal_fit, explained.track, log_odds)
    if laws.named is None:
        return _beside_unknown(look, known, laws, motion)
    again = _without_law(look, known, laws) if laws.replaces_causes else None
    if again is None:
        return ModesAndMotion(known.claims, laws, ForecastMotion.of(dataset, drawn, explained.with_named_law(laws)))
    instead = motion_by_law(dataset, again.measured, again.fits[0], laws.named)
    moved = motion if instead is None else ForecastMotion.of(dataset, drawn, instead)
    return ModesAndMotion(again.claims, laws, moved)


def _without_law(look: Look, known: _Searched, laws: LawSearch) -> _Searched | None:
    """Return the search for causes in the modes less what the named law does in them; None where these show none."""
    linear = measured_less_law(look.dataset, laws, known.measured)
    null = null_fit(linear)
    if null is None or not len(null.pairs):
        return None
    return _search_in(rebased(look.dataset, NominalFit(linear, null))).searched(lambda _: None)


def _beside_unknown(look: Look, known: _Searched, laws: LawSearch, motion: ForecastMotion) -> ModesAndMotion:
    """Return the claims, and the motion by the best of them, as something that no law on the list is moves the modes;
    what there was, where nothing does.
    """
    left = motion.explained.track.discrepancy
    if left.is_usual:
        return ModesAndMotion(known.claims, laws, motion)
    fits, probability = ranked_with_unsure_modes(left, known.measured, known.search, known.fits)
    claims = Claims(known.measured, fits, probability)
    explained = None if fits[0] is known.fits[0] else motion_by_claim(look.dataset, known.measured, fits[0])
    if explained is not None:
        motion = ForecastMotion.of(look.dataset, look.nominal_fit, explained)
    return ModesAndMotion(claims, laws, motion)


def _candidates(measured: ModalData) -> tuple[Candidate, ...]:
    """Return all causes at all places, their priors by a motion in which each mode has as much energy as any other."""
    nominal = measured.nominal
    omega, shapes = nominal.modes
    amplitude = np.random.default_rng(0).standard_normal((200, len(omega)))
    motion = Motion((amplitude / omega) @ shapes.T, amplitude @ shapes.T)
    channels = tuple(Channel(sensor.name, 1.0, 1.0) for sensor in measured.sensors)  # of drifts, which no mode shows
    return all_candidates_of(nominal, motion, channels)
