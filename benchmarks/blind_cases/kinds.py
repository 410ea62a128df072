"""Which causes a blind case may hide, by the structure and by what moves it."""

from typing import Literal

Excitation = Literal["free", "ambient", "measured", "base"]
StructureName = Literal["four_dof", "bridge"]
STRUCTURE_KINDS = (  # what acts on the structure: strong motion of its base is of interest for these
    "stiffness_change",
    "added_mass",
    "support_spring",
    "modal_damping",
    "point_damper",
    "quadratic_damper",
    "coulomb_friction",
    "cubic_spring",
    "gap_stop",
    "slack_cable",
)
KINDS = (
    *STRUCTURE_KINDS,
    "hysteretic_spring",
    "harmonic_force",
    "sensor_gain",
    "sensor_delay",
    "sensor_drift",
    "time_integration",
)
BRIDGE_KINDS = (*KINDS, "axial_force")
LOAD_KINDS = ("load_gain", "load_delay")  # faults of what recorded a known force
NOT_DRAWN = {
    "axial_force": "in a chain: it moves along its springs, where an axial force changes nothing",
    "mass_change": "of groups, whose factors every diagnosis estimates; tiers whose masses are off draw them",
    "quadratic_spring": "but under known forces and base motion: free vibration is drawn as it was before this cause",
    "load_gain": "but under known forces: elsewhere no load is recorded",
    "load_delay": "as load_gain",
    "dead_load": "blind structures move without weight or prestress; frames under both have tests of their own",
    "modal_model": "a wrong modal model is the user's input, not part of a structure; it has tests of its own",
}
"""Causes of the list that no case hides, or not every structure's, and why. Sizes go by what stands beside a cause in
the structure of a case, so that they are the generators' and not the cause's own."""
FAR_KINDS = ("stiffness_change", "added_mass", "support_spring", "axial_force")  # linear: modes alone tell them
AMBIENT_KINDS = (*FAR_KINDS, "point_damper", "sensor_gain")  # what modes tell, their damping included
BASE_KINDS = (*STRUCTURE_KINDS, "quadratic_spring")
OUTSIDE = ("drifting_stiffness", "swinging_stiffness", "creeping_spring")


def kinds_of(structure: StructureName, excitation: Excitation) -> tuple[str, ...]:
    """Return the causes that a structure's cases may hide."""
    kinds = BRIDGE_KINDS if structure == "bridge" else KINDS
    match excitation:
        case "free":
            return kinds
        case "ambient":
            return tuple(kind for kind in AMBIENT_KINDS if kind in kinds)
        case "measured":
            without = (kind for kind in kinds if kind != "hysteretic_spring")  # series alone tell causes, and no memory
            return (*without, "quadratic_spring", *LOAD_KINDS)
    return BASE_KINDS


def outside_of(excitation: Excitation) -> tuple[str, ...]:
    """Return what cases may hide that no cause of the list is: under unknown forces nothing, as these move modes alone
    in a linear structure.
    """
    return () if excitation == "ambient" else OUTSIDE
