"""The 4-DOF chain of the paper: four masses in a row, each tied to the one before, the first to the ground.

    M = diag(1, 2, 3, 4) kg, springs 1, 2, 3, 4 N/m from the ground outwards, a dashpot of 0.1 N s/m from every mass to
    the ground, and, where asked for, a cubic spring k_n u^3 from mass 1 to the ground.

Natural modes: omega = 0.2466, 1.0948, 1.7321, 2.1387 rad/s, damping ratios 7.0, 2.5, 1.6, 1.5 %.

Source: Lai et al., Data-Centric Engineering 3, e34, 2022. It prints the cubic force in the fourth equation; the
authors' program, and every result of theirs, has it in the first, as here.
"""

from fe_models.causes import CubicSpring
from fe_models.structure import Dashpot, PointMass, Spring, Structure

MASSES = (1.0, 2.0, 3.0, 4.0)  # kg
STIFFNESSES = (1.0, 2.0, 3.0, 4.0)  # N/m
DAMPING_COEFFICIENT = 0.1  # N s/m
PAPER_OMEGA = (0.2466, 1.0948, 1.7321, 2.1387)  # rad/s


def four_dof(cubic_stiffness: float = 0.0) -> Structure:
    """Return the chain; ``cubic_stiffness`` k_n (N/m^3) of the spring at node 1, which 0 leaves out."""
    nodes = range(1, 5)
    first, *others = STIFFNESSES
    springs = [Spring((1,), "x", first)]
    springs += [Spring((node - 1, node), "x", stiffness) for node, stiffness in zip(nodes[1:], others, strict=True)]
    chain = Structure(
        name="four_dof",
        nodes=tuple((float(node), 0.0) for node in nodes),
        elements=tuple(springs),
        point_masses=tuple(PointMass(node, mass) for node, mass in zip(nodes, MASSES, strict=True)),
        dashpots=tuple(Dashpot((node,), "x", DAMPING_COEFFICIENT) for node in nodes),
        directions=("x",),
    )
    return chain.with_effects(CubicSpring((1,), "x", cubic_stiffness)) if cubic_stiffness else chain
