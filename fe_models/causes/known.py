"""What is known before causes are sought, from which each cause makes its candidates."""

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Protocol

import numpy as np
from scipy.sparse import csr_array

from fe_models.arrays import FloatArray, IntArray
from fe_models.causes.base import Cause, Effect
from fe_models.causes.candidate import Changes
from fe_models.causes.force_law import ForceLaw
from fe_models.causes.load_name import LoadName
from fe_models.causes.places import (
    MIN_MOTION_SHARE,
    Elongation,
    ModelForPlaces,
    Motion,
    MovingPlace,
    Place,
    places_among,
    places_of,
)
from fe_models.structure import TRANSLATIONS, Structure


class UncertainStiffnessOrMass(Protocol):
    """The stiffness or mass of some elements, by their numbers, which is uncertain as a whole."""

    @property
    def quantity(self) -> str: ...  # noqa: D102
    @property
    def elements(self) -> tuple[int, ...]: ...  # noqa: D102


class ModelForCauses(ModelForPlaces, Protocol):
    """The nominal model, as far as causes ask for it.

    ``built``: the structure with its effects that are plain parts built in; ``parts``: what of it is uncertain as a
    whole; ``own_ratios`` (mode,): damping ratios; ``below``: number of modes that recordings can show; ``highest``
    (Hz): the highest frequency that they show; ``integration``: the error of the simulation's own steps, if any.
    """

    @property
    def built(self) -> Structure: ...  # noqa: D102
    @property
    def parts(self) -> Sequence[UncertainStiffnessOrMass]: ...  # noqa: D102
    @property
    def own_ratios(self) -> FloatArray: ...  # noqa: D102
    @property
    def below(self) -> int: ...  # noqa: D102
    @property
    def highest(self) -> float: ...  # noqa: D102
    @property
    def integration(self) -> Cause | None: ...  # noqa: D102

    def pull(self, law: ForceLaw) -> FloatArray:
        """Return the coefficients (dof,) of a law's elongation."""

    def released(self, row: int) -> FloatArray:
        """Return the displacements (dof,) when a held degree of freedom moves by one and the others stay held."""

    def changes_of(self, effect: Effect) -> Changes:
        """Return what an effect adds to M, C and K."""

    def frequencies_with(self, effect: Effect) -> FloatArray:
        """Return the natural frequencies (mode,), rad/s, of the structure with an effect; `InputError` without any."""


@dataclass(frozen=True)
class Channel:
    """A measured sensor: its ``name``, the ``rms`` of what it shows and how long its longest recording is, s."""

    name: str
    rms: float
    duration: float


@dataclass(frozen=True)
class LoadChannel:
    """What one instrument recorded of the loads: ``load`` says which, ``positions`` among all that are known.

    ``twins``: other loads that go with it in every recording, so that nothing tells which of them is meant.
    """

    load: LoadName
    positions: tuple[int, ...]
    twins: tuple[LoadName, ...] = ()


@dataclass(frozen=True)
class Known:
    """The ``nominal`` model, the ``motion`` that it needs to follow the recordings, and the measured ``channels``.

    ``slowest`` (Hz): one cycle in the longest recording. ``loads``: what is known to act, by how it was recorded.
    ``elongations``: along which forces may act, None where the structure says it.
    """

    nominal: ModelForCauses
    motion: Motion
    channels: tuple[Channel, ...] = ()
    slowest: float = 0.0
    loads: tuple[LoadChannel, ...] = ()
    elongations: tuple[Elongation, ...] | None = None

    @cached_property
    def places(self) -> list[Place]:
        """Where forces can act."""
        if self.elongations is not None:
            return places_among(self.nominal, self.motion, self.elongations)
        return places_of(self.nominal, self.motion)

    @cached_property
    def least_elongation(self) -> float:
        """The rms elongation (m) of a place that hardly moves beside the others."""
        sizes = [float(np.std(self.motion.displacement @ place.pull)) for place in self.places]
        return MIN_MOTION_SHARE * max(sizes, default=0.0)

    @cached_property
    def moving_places(self) -> list[MovingPlace]:
        """The places that move, with their motion."""
        every = [MovingPlace.of(place, self.motion) for place in self.places]
        return [place for place in every if place.size > self.least_elongation]

    @property
    def period(self) -> float:
        """The usual period of the motion, s."""
        moving = np.isin(self.nominal.dofs.direction, TRANSLATIONS)  # rotations are no lengths
        displacement, velocity = self.motion.displacement[..., moving], self.motion.velocity[..., moving]
        if self.elongations is not None:  # coordinates are no lengths, what is sensed is
            pulls = np.column_stack([pull for *_, pull in self.elongations])
            displacement, velocity = self.motion.displacement @ pulls, self.motion.velocity @ pulls
        return 2 * np.pi * float(np.std(displacement) / np.std(velocity))

    @property
    def element_groups(self) -> list[tuple[int, ...]]:
        """The numbers of each element alone, and of those that are uncertain as a whole."""
        parts = self.nominal.parts
        groups = [part.elements for part in parts if part.quantity == "stiffness" and len(part.elements) > 1]
        return [(number,) for number in range(1, len(self.nominal.structure.elements) + 1)] + groups

    def part_of(self, numbers: tuple[int, ...]) -> int | None:
        """Return the uncertain stiffness that elements are of, by its number: what they lack, they lack of that."""
        for number, part in enumerate(self.nominal.parts):
            if part.quantity == "stiffness" and set(numbers) <= set(part.elements):
                return number
        return None

    @property
    def zeros(self) -> csr_array:
        """A matrix of zeros (dof, dof)."""
        return csr_array(self.nominal.mass.shape)

    def diagonal(self, rows: IntArray) -> csr_array:
        """Return ones at the diagonal's ``rows``, sparse (dof, dof)."""
        return csr_array((np.ones(len(rows)), (rows, rows)), shape=self.nominal.mass.shape)


def outer(pull: FloatArray) -> csr_array:
    """Return b b^T of an elongation's coefficients (dof,), sparse."""
    column = csr_array(pull[:, None])
    return csr_array(column @ column.T)
