"""What the effects of a structure amount to: plain parts for the linear model, and force laws on top of it."""

from dataclasses import replace

from fe_models.causes.base import Effect, Part
from fe_models.causes.force_law import ForceLaw
from fe_models.structure import Structure


def effects_of(structure: Structure) -> tuple[Effect, ...]:
    """Return the effects that a structure carries."""
    return tuple(effect for effect in structure.effects if isinstance(effect, Effect))


def with_parts(structure: Structure) -> Structure:
    """Return the structure with those effects that are springs, masses or dashpots (`Part`) built in as such.

    Its elements keep their numbers; the springs of `SupportSpring` follow after them. It is for computing with: its
    masses and stiffnesses may be negative. All other effects stay.
    """
    whole = structure
    for effect in structure.effects:
        whole = effect.extend(whole)
    return replace(whole, effects=tuple(effect for effect in whole.effects if not isinstance(effect, Part)))


def force_laws(structure: Structure) -> tuple[ForceLaw, ...]:
    """Return the forces that the structure's effects add to its linear model."""
    whole = with_parts(structure)
    laws = (effect.law(whole) for effect in effects_of(whole))
    return tuple(law for law in laws if law is not None)
