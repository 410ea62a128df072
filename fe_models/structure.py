"""A plane structure as plain, frozen data: nodes, elements, masses, dashpots, supports and the effects placed on it.

Nodes and elements are numbered from 1 in the order given. A variant is made by `dataclasses.replace`.
"""

from abc import ABC, abstractmethod
from dataclasses import dataclass, field, replace
from math import hypot
from typing import ClassVar, Literal

from fe_models.errors import raise_faults
from fe_models.one_node import node_or_nodes
from fe_models.sections import Section

Direction = Literal["x", "y", "z", "rx", "ry", "rz"]
"""Axes and rotations about them; structures are plane, and have those of `PLANE_FRAME` alone, matrices all."""
TRANSLATIONS: tuple[Direction, ...] = ("x", "y", "z")
ROTATIONS: tuple[Direction, ...] = ("rx", "ry", "rz")
PLANE_FRAME: tuple[Direction, ...] = ("x", "y", "rz")


@dataclass(frozen=True)
class Beam:
    """An Euler-Bernoulli beam between two nodes, rigidly joined at both; consistent mass.

    ``group``: the name of the elements, of any kind, whose stiffness and mass are uncertain as a whole
    (`uncertain_parts`); None where none is given.
    """

    nodes: tuple[int, int]
    section: Section
    group: str | None = None


@dataclass(frozen=True)
class Cable:
    """A straight cable or bar: axial stiffness E A / L, consistent mass of a bar, no bending stiffness.

    ``prestress`` is its tension (N) in the drawn geometry; ``tension_only`` lets it go slack in nonlinear simulations.
    """

    nodes: tuple[int, int]
    section: Section
    prestress: float = 0.0
    tension_only: bool = True
    group: str | None = None


@node_or_nodes
@dataclass(frozen=True)
class Spring:
    """A massless spring (N/m, or N m/rad for "rz") in one direction between two nodes, or one node and ground."""

    nodes: tuple[int] | tuple[int, int]
    direction: Direction
    stiffness: float
    group: str | None = None


Element = Beam | Cable | Spring


def group_name(element: Element) -> str:
    """Return the name of an element's group, that of its kind where none is given."""
    return type(element).__name__.lower() if element.group is None else element.group


@dataclass(frozen=True)
class PointMass:
    """A mass (kg) at a node, felt by its translations only."""

    node: int
    mass: float


@node_or_nodes
@dataclass(frozen=True)
class Dashpot:
    """A linear damper (N s/m, or N m s/rad for "rz") in one direction between two nodes, or one node and ground."""

    nodes: tuple[int] | tuple[int, int]
    direction: Direction
    coefficient: float


@dataclass(frozen=True)
class Support:
    """A node held rigidly in the given directions."""

    node: int
    directions: tuple[Direction, ...]


@dataclass(frozen=True)
class Damping:
    """Damping that belongs to the structure as a whole: C = mass_factor M + stiffness_factor K + modal part.

    ``mass_factor`` (1/s) and ``stiffness_factor`` (s) are Rayleigh's. ``modal_ratios`` are damping ratios of the first
    modes (1 = critical); the last number goes on for all higher modes, so that one number stands for all. A negative
    one takes away from what dashpots and Rayleigh's factors give.
    """

    mass_factor: float = 0.0
    stiffness_factor: float = 0.0
    modal_ratios: tuple[float, ...] = ()


class Carried(ABC):
    """What a structure carries beside its parts; `causes` says what there is, each of it an effect."""

    kind: ClassVar[str]

    @abstractmethod
    def type_faults(self) -> list[str]:
        """Return what no structure could have, such as words for numbers, a line each."""

    @abstractmethod
    def extend(self, structure: "Structure") -> "Structure":
        """Return ``structure`` with what of this can be said in plain parts."""

    @abstractmethod
    def faults(self, structure: "Structure") -> list[str]:
        """Return what does not fit ``structure``, a line each; places are checked against its nodes and elements."""


@dataclass(frozen=True, repr=False)
class Structure:
    """A plane frame, truss or chain.

    ``nodes``: (x, y) in m. ``directions``: the degrees of freedom that every node carries, ("x",) for a chain; they
    stand in the order of `PLANE_FRAME`, in whatever order they are given. ``divisions``: each beam is split into that
    many equal finite elements; numbers of nodes and elements stay.
    """

    name: str
    nodes: tuple[tuple[float, float], ...]
    elements: tuple[Element, ...]
    point_masses: tuple[PointMass, ...] = ()
    dashpots: tuple[Dashpot, ...] = ()
    supports: tuple[Support, ...] = ()
    directions: tuple[Direction, ...] = PLANE_FRAME
    damping: Damping = field(default_factory=Damping)
    effects: tuple[Carried, ...] = ()
    divisions: int = 1

    def __post_init__(self) -> None:
        known = dict(zip(PLANE_FRAME, range(len(PLANE_FRAME)), strict=True))
        ordered = sorted(self.directions, key=lambda direction: known.get(direction, len(known)))
        object.__setattr__(self, "directions", tuple(ordered))

    def __repr__(self) -> str:
        counts = {"node": len(self.nodes)}
        for kind in (Beam, Cable, Spring):
            counts[kind.__name__.lower()] = sum(isinstance(element, kind) for element in self.elements)
        counts |= {"support": len(self.supports), "effect": len(self.effects)}
        parts = [f"{count} {word}{'s' * (count > 1)}" for word, count in counts.items() if count]
        return f"Structure({self.name!r}: {', '.join(parts)})"

    @property
    def is_chain(self) -> bool:
        """Whether all is springs and masses in one direction."""
        return all(isinstance(element, Spring) for element in self.elements) and len(self.directions) == 1

    def with_effects(self, *effects: Carried) -> "Structure":
        """Return the structure with ``effects`` added to those it has; `InputError` with all that are none.

        Whether their places are in the structure is checked where it is used.
        """
        faults = list[str]()
        for number, effect in enumerate(effects, start=1):
            if isinstance(effect, Carried):
                faults += [f"{type(effect).__name__}: {fault}" for fault in effect.type_faults()]
            else:
                faults.append(f"effect {number} is {effect!r}; expected one such as AddedMass(node=1, mass=2.0)")
        raise_faults(faults)
        return replace(self, effects=self.effects + effects)

    def refined(self, divisions: int) -> "Structure":
        """Return the structure with each beam split into ``divisions`` finite elements."""
        return replace(self, divisions=divisions)

    def without_prestress(self) -> "Structure":
        """Return the structure with cables as linear models have them: bars that carry nothing at rest."""
        elements = tuple(
            replace(element, prestress=0.0, tension_only=False) if isinstance(element, Cable) else element
            for element in self.elements
        )
        return replace(self, elements=elements)

    def length(self, element: Beam | Cable) -> float:
        """Return the distance (m) between the element's nodes in the drawn geometry."""
        (x1, y1), (x2, y2) = (self.nodes[node - 1] for node in element.nodes)
        return hypot(x2 - x1, y2 - y1)
