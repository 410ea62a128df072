"""What the effects of a structure amount to: plain parts for the linear model, and force laws on top of it."""

from dataclasses import replace

from fe_models.effects.axial_force import AxialForce
from fe_models.effects.base import ForceLaw
from fe_models.effects.dead_load import DeadLoad
from fe_models.effects.modal_damping import ModalDamping
from fe_models.effects.parts import AddedMass, PointDamper, StiffnessChange, SupportSpring
from fe_models.structure import Structure

PARTS = (StiffnessChange, AddedMass, SupportSpring, PointDamper)


def with_parts(structure: Structure) -> Structure:
    """Return the structure with those effects that are springs, masses or dashpots built in as such.

    Its elements keep their numbers; the springs of `SupportSpring` follow after them. It is for computing with: its
    masses and stiffnesses may be negative. All other effects stay.
    """
    whole = structure
    for effect in structure.effects:
        whole = effect.extend(whole)
    return replace(whole, effects=tuple(effect for effect in whole.effects if not isinstance(effect, PARTS)))


def force_laws(structure: Structure) -> tuple[ForceLaw, ...]:
    """Return the forces that the structure's effects add to its linear model."""
    whole = with_parts(structure)
    laws = (effect.law(whole) for effect in whole.effects)
    return tuple(law for law in laws if law is not None)


def axial_forces(structure: Structure) -> dict[int, float]:
    """Return the sum of the axial forces (N) that effects add, by number of the element."""
    total: dict[int, float] = {}
    for effect in structure.effects:
        if isinstance(effect, AxialForce):
            for number, force in effect.forces.items():
                total[number] = total.get(number, 0.0) + force
    return total


def dead_load_share(structure: Structure) -> float:
    """Return the sum of the shares of dead load that effects bring to small motions, 0 without any."""
    return sum((effect.share for effect in structure.effects if isinstance(effect, DeadLoad)), 0.0)


def replaced_ratios(structure: Structure) -> tuple[tuple[int, float], ...]:
    """Return number and damping ratio of each mode that has its own; of two for one mode the later."""
    return tuple(sorted({m: r for e in structure.effects if isinstance(e, ModalDamping) for m, r in e.ratios}.items()))
