"""What is uncertain of a structure as a whole, where anything feels it."""

from dataclasses import replace

from scipy.sparse import csr_array

from fe_models.assembly import unsupported
from fe_models.causes import DeadLoad
from fe_models.structure import Structure
from fe_models.uncertain_parts import UncertainPart, uncertain_parts
from hybrid.diagnosis.nominal.config import NOMINAL


def felt_parts(structure: Structure) -> tuple[tuple[UncertainPart, ...], tuple[csr_array, ...]]:
    """Return the uncertain parts and what doubling each adds to M or K, less those whose mass nothing feels.

    A dead load takes no part: what a heavier part makes of it is of second order.
    """
    effects = tuple(effect for effect in structure.effects if not isinstance(effect, DeadLoad))
    structure = replace(structure, effects=effects)
    mass, _, stiffness = unsupported(structure)
    parts, changes = [], []
    for part in uncertain_parts(structure):
        doubled = unsupported(part.scaled(structure, 2.0))
        change = csr_array(doubled[0] - mass if part.quantity == "mass" else doubled[2] - stiffness)
        if part.quantity == "stiffness" or change.diagonal().sum() > NOMINAL.min_mass_share * mass.diagonal().sum():
            parts.append(part)
            changes.append(change)
    return tuple(parts), tuple(changes)
