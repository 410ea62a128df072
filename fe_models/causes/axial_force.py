"""An axial force in elements that the model does not know of: geometric stiffness, P-delta."""

from dataclasses import dataclass
from functools import partial
from math import hypot
from typing import ClassVar

import numpy as np
from numpy.typing import NDArray
from scipy.sparse import csr_array

from fe_models.causes.base import Effect, count_faults, element_faults, parameter, value_of
from fe_models.causes.candidate import ChangeCandidate
from fe_models.causes.equilibrium import is_borne, line_of
from fe_models.causes.known import Known
from fe_models.causes.searched import Searched
from fe_models.structure import Beam, Direction, Element, Spring, Structure

PRIOR_FREQUENCY_SHARE = 0.3  # of a squared frequency: what the usual axial force takes from it
# how probable an axial force is that nothing takes off where its element ends, to one that is borne:
# possible, for weights and friction are not drawn, but of two that sensors hardly distinguish not the first to think of
UNBALANCED_WEIGHT = 0.1
YIELD_STRAIN = 2e-3  # the strain that no metal of a structure bears for long ...
DESIGN_STRAIN = 5e-4  # ... and that which structures are designed for, 100 N/mm^2 in steel


@dataclass(frozen=True)
class AxialForce(Searched, Effect):
    """A constant axial force N (tension > 0) in elements, on top of what loads and prestress bring: K += K_G(N).

    Beams have the consistent geometric stiffness of Euler-Bernoulli's theory, N int(w'^2) dx / 2 with the cubic shape
    functions; cables and springs N / L across their line. K_G acts on displacements from the drawn geometry and gets no
    damping. ``force`` is one for all elements, or one for each.
    """

    kind: ClassVar[str] = "axial_force"
    template: ClassVar[str] = "{place} carries an axial force of {force} that the model lacks (tension positive)"
    elements: tuple[int, ...]
    force: float | tuple[float, ...] = parameter("N")

    @property
    def forces(self) -> dict[int, float]:
        """The force (N) by number of the element."""
        return {number: value_of(self.force, position) for position, number in enumerate(self.elements)}

    def faults(self, structure: Structure) -> list[str]:
        """Return faults of the elements and forces, and elements on which an axial force has no effect."""
        faults = element_faults(structure, self.elements) + count_faults("force", self.force, self.elements)
        faults += self.number_faults()
        return faults or [fault for number in self.elements for fault in _inert_faults(structure, number)]

    @classmethod
    def candidates(cls, known: Known) -> list[ChangeCandidate]:
        """Return a force in each element, and in each group that is uncertain as a whole, that feels one."""
        found, structure = [], known.nominal.structure
        for numbers in known.element_groups:
            effect = cls(numbers, 1.0)
            if not effect.faults(structure):
                changes = known.nominal.changes_of(effect)
                own = [structure.elements[number - 1] for number in numbers]
                stretch = min(_axial_stiffness(element) for element in own)
                found.append(
                    ChangeCandidate(
                        kind=cls.kind,
                        location=effect.location,
                        names=("force",),
                        build=partial(cls, numbers),
                        neutral=(0.0,),
                        width=(min(_felt_force(known, changes[2]), DESIGN_STRAIN * stretch),),
                        lower=(-YIELD_STRAIN * stretch,),
                        upper=(YIELD_STRAIN * stretch,),
                        changes=changes,
                        weight=_weight(known.nominal.built, own),
                    )
                )
        return found


@dataclass(frozen=True)
class GeometricStiffness:
    """What an axial ``force`` (N) adds to one finite element with two nodes, a beam (``bending``) or a bar."""

    nodes: tuple[int] | tuple[int, int]
    force: float
    bending: bool


def geometric_stiffness(
    item: GeometricStiffness, directions: tuple[Direction, ...], vector: NDArray[np.float64]
) -> NDArray[np.float64]:
    """Return K_G (n, n) over the degrees of freedom of both nodes, for an element along ``vector`` (2,), in m.

    A bar: N / L (I - t t^T) on the difference of the translations, t the unit vector along it. A beam, across its line,
    with the dofs w1, r1, w2, r2: N / (30 L) [[36, 3L, -36, 3L], [3L, 4L^2, -3L, -L^2], ...].
    """
    L = hypot(*vector)
    c, s = vector / L
    across = np.array([-s, c])
    if item.bending:
        local = np.array(
            [
                [36.0, 3 * L, -36.0, 3 * L],
                [3 * L, 4 * L**2, -3 * L, -(L**2)],
                [-36.0, -3 * L, 36.0, -3 * L],
                [3 * L, -(L**2), -3 * L, 4 * L**2],
            ]
        ) * (item.force / (30 * L))
    else:
        local = np.zeros((4, 4))
        local[::2, ::2] = item.force / L * np.array([[1.0, -1.0], [-1.0, 1.0]])
    pick = np.zeros((2, len(directions)))  # of one node: (w, r) from its dofs
    for column, direction in enumerate(directions):
        pick[:, column] = {"x": (across[0], 0.0), "y": (across[1], 0.0), "rz": (0.0, 1.0)}[direction]
    both = np.kron(np.eye(2), pick)  # (4, n)
    return np.asarray(both.T @ local @ both)


def _inert_faults(structure: Structure, number: int) -> list[str]:
    """Return a fault where an axial force in element ``number`` would change nothing."""
    element = structure.elements[number - 1]
    if not structure.directions or not all(1 <= node <= len(structure.nodes) for node in element.nodes):
        return []  # faults of the structure and the element, which say so themselves
    if len(element.nodes) == 1:
        return [f"element {number} is a spring to the ground, without length: no axial force acts across it"]
    if isinstance(element, Spring) and element.direction == "rz":
        return [f"element {number} is a spring in rz: it carries no axial force"]
    vector = line_of(structure, element)
    if not vector.any():
        return [f"element {number} has no length: no axial force acts across it"]
    item = GeometricStiffness(element.nodes, 1.0, isinstance(element, Beam))
    stiffness = geometric_stiffness(item, structure.directions, vector)
    if abs(stiffness).max() * hypot(*vector) > 1e-9:  # of 1: only rounding is left
        return []
    can = ", ".join(structure.directions)
    return [f"element {number}: its nodes move in {can} only, along its line, where an axial force changes nothing"]


def axial_forces(structure: Structure) -> dict[int, float]:
    """Return the sum of the axial forces (N) that effects add, by number of the element."""
    total: dict[int, float] = {}
    for effect in structure.effects:
        if isinstance(effect, AxialForce):
            for number, force in effect.forces.items():
                total[number] = total.get(number, 0.0) + force
    return total


def _weight(built: Structure, elements: list[Element]) -> float:
    """Return how probable an axial force in these elements is, to another; several are what the user calls a member."""
    return 1.0 if len(elements) > 1 or is_borne(built, elements[0]) else UNBALANCED_WEIGHT


def _axial_stiffness(element: Element) -> float:
    """Return E A (N) of a beam or a cable; what has no section bears any force."""
    return np.inf if isinstance(element, Spring) else element.section.axial_stiffness


def _felt_force(known: Known, stiffness: csr_array) -> float:
    """Return the axial force (N) that changes the square of some mode's frequency by 30 %: a third of buckling."""
    omega, shapes = known.nominal.modes
    softened = np.abs(np.einsum("di,di->i", shapes, stiffness @ shapes))
    return PRIOR_FREQUENCY_SHARE * float(np.min(omega**2 / np.maximum(softened, 1e-12 * omega**2)))
