"""The first look at recordings: their modes, and how far off the drawn structure is by them."""

from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np
from threadpoolctl import threadpool_limits

from fe_models.arrays import FloatArray
from fe_models.errors import InputError
from fe_models.recordings import Dataset
from hybrid.diagnosis.config import SEARCH_CHOICE, THREADS
from hybrid.diagnosis.modal.config import FIT
from hybrid.diagnosis.modal.evidence import ModalFit, Start, fit_claim
from hybrid.diagnosis.modal.modal_data import ModalData
from hybrid.diagnosis.modal.nominal_fit import NominalFit, null_fit
from hybrid.diagnosis.modal.search import ClaimSearch
from hybrid.diagnosis.modes_and_motion.measured_in_dataset import as_measured, measured_in
from hybrid.diagnosis.modes_and_motion.parts_off import parts_surely_off
from hybrid.diagnosis.nominal.any_model import with_parts_scaled
from hybrid.diagnosis.nominal.nominal_model import NominalModel
from hybrid.identification.identification import Identification


@dataclass(frozen=True)
class Look:
    """A ``dataset`` with the modes ``measured`` in it, and the fit of the ``drawn`` structure to them, nominal values
    alone as far off as the modes say; what was ``identified`` in its recordings, by their names.
    """

    dataset: Dataset
    measured: ModalData
    drawn: ModalFit
    identified: Mapping[str, Identification]

    @property
    def nominal_fit(self) -> NominalFit:
        """The fit of the drawn structure with what was measured."""
        return NominalFit(self.measured, self.drawn)

    @property
    def ambient(self) -> tuple[str, ...]:
        """The names of the recordings that unknown forces drove."""
        return tuple(name for name, own in self.identified.items() if own.is_ambient)

    @property
    def is_near(self) -> bool:
        """Whether the structure may be as right as was stated, but for one place, and the same in all recordings."""
        return not self.is_far and not self.differs

    @property
    def is_far(self) -> bool:
        """Whether the structure is off in more than one place by more than was stated."""
        return len(parts_surely_off(self.measured, self.drawn)) >= SEARCH_CHOICE.far_groups

    @cached_property
    def differs(self) -> bool:
        """Whether an unknown change in some recordings is more probable than none."""
        search = ClaimSearch.of(self.measured, ())
        return search.run_changes(self.drawn)[0].claim.changed != ()


def look_at(dataset: Dataset, tell: Callable[[str], object]) -> Look:
    """Return a dataset with its modes; ``tell`` hears what is done.

    `InputError` where the dataset has no structure, or no recording shows a mode of it.
    """
    dataset = as_measured(dataset)
    with threadpool_limits(THREADS.linear_algebra, "blas"):
        tell("modes of the recordings")
        measured, identified = measured_in(dataset, tell)
        tell("nominal values")
        drawn = null_fit(measured)
    if drawn is None or not len(drawn.pairs):
        raise InputError("no recording shows a mode of this structure: check node numbers, directions and units")
    return Look(dataset, measured, drawn, identified)


def rebased(dataset: Dataset, nominal_fit: NominalFit) -> NominalFit:
    """Return the fit with the nominal model's parts as it has them, and its basis of modes that of these.

    Modes of the drawn structure are a poor basis for those of one that is off by a fifth.
    """
    for _ in range(FIT.max_rebased):
        measured, null = nominal_fit.measured, nominal_fit.fit
        parts = len(measured.nominal.parts)
        shift = null.theta[:parts]
        if np.abs(shift).max(initial=0.0) < FIT.max_basis_shift:
            break
        nominal = with_parts_scaled(measured.nominal, dataset, np.exp(shift))
        offset, theta = (_values_of(values, measured.nominal, nominal) for values in (measured.offset, null.theta))
        offset[:parts] += shift
        theta[:parts] = 0.0
        moved = replace(measured, nominal=nominal, offset=offset)
        again = fit_claim(moved, Start(moved.null, theta, null.sizes))
        if again is None or again.evidence < null.evidence - FIT.same_nats:
            break
        nominal_fit = NominalFit(moved, again)
    return nominal_fit


def _values_of(values: FloatArray, old: NominalModel, new: NominalModel) -> FloatArray:
    """Return nominal ``values`` (nuisance,) of an ``old`` model for a ``new`` one of other stiffnesses, of which more
    modes or fewer are in the band, and other patterns of the scatter are felt: these begin with none.
    """
    found = np.zeros(len(new.spread))
    both = min(old.factors, new.factors)  # parts come first, then the damping ratios of the lowest modes
    found[:both] = values[:both]
    if len(old.scatter.changes) == len(new.scatter.changes):
        found[new.factors : new.values] = values[old.factors : old.values]
    found[new.values :] = values[old.values :]
    return found
