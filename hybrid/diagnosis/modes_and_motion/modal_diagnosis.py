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
from hybrid.diagnosis.discrepancy.laws_in_recordings import laws_in, may_have_laws
from hybrid.diagnosis.modal.all_candidates import all_candidates_of
from hybrid.diagnosis.modal.evidence import ModalFit
from hybrid.diagnosis.modal.modal_data import ModalData
from hybrid.diagnosis.modal.search import Search, null_fit, probabilities
from hybrid.diagnosis.modes_and_motion.change_gains import gains_of
from hybrid.diagnosis.modes_and_motion.conclusion import Claims, ModalDiagnosis, concluded
from hybrid.diagnosis.modes_and_motion.forecasts import FoundMotion
from hybrid.diagnosis.modes_and_motion.found import Found, found_beside, found_by_modes, found_instead
from hybrid.diagnosis.modes_and_motion.look import Look, look_at, rebased
from hybrid.diagnosis.modes_and_motion.modes_less_law import measured_less_law
from hybrid.diagnosis.modes_and_motion.unsure_modes import ranked_beside
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
        return _answer(look, _of(*rebased(look.dataset, look.measured, look.drawn)).searched(tell), tell)


@dataclass(frozen=True, eq=False)
class OneStructure:
    """What modes and motion add where all series together leave something open, of recordings of one structure that
    were looked at (``look``).
    """

    look: Look

    @cached_property
    def _bare(self) -> "_Searched":
        return _of(*rebased(self.look.dataset, self.look.measured, self.look.drawn))

    @cached_property
    def _moving(self) -> Found | None:
        with threadpool_limits(THREADS.linear_algebra, "blas"):
            return found_by_modes(self.look.dataset, self._bare.measured, self._bare.null)

    @property
    def moves_by_constants(self) -> bool:
        """Whether the motion of each recording is that of constant values, or not known: where it is not, no linear
        cause makes it so; a law may.
        """
        return self._moving is None or self._moving.track.discrepancy.is_usual

    def by_law(self) -> ModalDiagnosis | None:
        """Return the diagnosis by a force law in the place of all linear causes; None where none is named."""
        with threadpool_limits(THREADS.linear_algebra, "blas"):
            told = _with_motion(self.look, self._bare, self._moving)
            laws = told[1]
            return None if laws is None or laws.named is None else _concluded(self.look, self._bare, told)

    def by_all(self, tell: Callable[[str], object]) -> ModalDiagnosis:
        """Return the diagnosis by all causes that modes and motion tell; ``tell`` hears what is done."""
        with threadpool_limits(THREADS.linear_algebra, "blas"):
            return _answer(self.look, self._bare.searched(tell), tell)


def _answer(look: Look, by_modes: "_Searched", tell: Callable[[str], object]) -> ModalDiagnosis:
    tell("force laws")
    told = _with_motion(look, by_modes)
    tell("forecasts by modes")
    return _concluded(look, by_modes, told)


def _concluded(look: Look, by_modes: "_Searched", told: "_Told") -> ModalDiagnosis:
    claims, laws, motion = told
    if motion is not None and motion.found.law is None:  # a law would have to be taken along
        claims = replace(claims, gains=gains_of(look.dataset, claims.measured, claims.fits[0]))
    answer = concluded(claims, laws, motion, look.dataset.sensors)
    names = ", ".join(look.ambient)
    about = (UNKNOWN_FORCES.format(names=names),) if names else ()
    kinds = {own.kind for own in by_modes.search.candidates} | (by_modes.laws if laws is not None else set())
    return replace(answer, notes=(*answer.notes, *about), identified=look.identified, competed=tuple(sorted(kinds)))


@dataclass(frozen=True, eq=False)
class _Searched:
    """The ``fits`` of all claims to what was ``measured``, most probable first, by a ``search``; ``null``: that of
    nothing wrong; the kinds of force ``laws`` that the structure may have.
    """

    measured: ModalData
    null: ModalFit
    search: Search
    fits: list[ModalFit]
    laws: frozenset[str]

    def searched(self, tell: Callable[[str], object]) -> "_Searched":
        """Return the same with the fits of all that was tried."""
        return replace(self, fits=self.search.run(self.null, tell))

    @property
    def claims(self) -> Claims:
        """The claims with their probabilities."""
        return Claims(self.measured, self.fits, probabilities(self.search, self.fits))


def _of(measured: ModalData, null: ModalFit) -> _Searched:
    """Return the search for causes that modes tell, before it is made."""
    candidates = _candidates(measured)
    laws = frozenset(own.kind for own in candidates if isinstance(own, LawCandidate))
    return _Searched(measured, null, Search.of(measured, candidates), [null], laws)


_Told = tuple[Claims, LawSearch | None, FoundMotion | None]


def _with_motion(look: Look, known: _Searched, found: Found | None = None) -> _Told:
    """Return the claims, the search for force laws where the claims leave something of the motion, and the motion by
    what was found; None where motion tells no laws, or none was left to look for. ``found``: the motion by the best
    claim, where it is known.
    """
    dataset, drawn, best = look.dataset, (look.measured, look.drawn), known.fits[0]
    if look.ambient or not may_have_laws(dataset, known.measured):
        return known.claims, None, None
    found = found or found_by_modes(dataset, known.measured, best)
    motion = None if found is None else FoundMotion.of(dataset, drawn, found)
    if found is None or motion is None or motion.is_at_noise or isinstance(dataset.model, LinearModel):
        return known.claims, None, motion
    laws = laws_in(dataset, drawn, (known.measured, known.null), found.track, known.search.log_odds(best.claim))
    if laws.named is None:
        return _beside_unknown(look, known, laws, motion)
    if not laws.replaces_causes:
        return known.claims, laws, FoundMotion.of(dataset, drawn, found_beside(found, laws))
    linear = measured_less_law(dataset, laws, known.measured)
    null = null_fit(linear)
    if null is None or not len(null.pairs):
        return known.claims, laws, FoundMotion.of(dataset, drawn, found_beside(found, laws))
    again = _of(*rebased(dataset, linear, null)).searched(lambda _: None)
    instead = found_instead(dataset, again.measured, again.fits[0], laws.named)
    return again.claims, laws, motion if instead is None else FoundMotion.of(dataset, drawn, instead)


def _beside_unknown(
    look: Look, known: _Searched, laws: LawSearch, motion: FoundMotion
) -> tuple[Claims, LawSearch, FoundMotion]:
    """Return the claims, and the motion by the best of them, as something that no law on the list is moves the modes;
    what there was, where nothing does.
    """
    left = motion.found.track.discrepancy
    if left.is_usual:
        return known.claims, laws, motion
    fits, probability = ranked_beside(left, known.measured, known.search, known.fits)
    claims = Claims(known.measured, fits, probability)
    if fits[0] is known.fits[0]:
        return claims, laws, motion
    found = found_by_modes(look.dataset, known.measured, fits[0])
    return claims, laws, motion if found is None else FoundMotion.of(look.dataset, (look.measured, look.drawn), found)


def _candidates(measured: ModalData) -> tuple[Candidate, ...]:
    """Return all causes at all places, their priors by a motion in which each mode has as much energy as any other."""
    nominal = measured.nominal
    omega, shapes = nominal.modes
    amplitude = np.random.default_rng(0).standard_normal((200, len(omega)))
    motion = Motion((amplitude / omega) @ shapes.T, amplitude @ shapes.T)
    channels = tuple(Channel(sensor.name, 1.0, 1.0) for sensor in measured.sensors)  # of drifts, which no mode shows
    return all_candidates_of(nominal, motion, channels)
