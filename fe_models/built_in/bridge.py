"""The cable-stayed bridge of the paper: a plane laboratory model of 55 nodes and 60 elements, 153 free dofs.

Source: Lai et al., Data-Centric Engineering 3, e34, 2022, and the simulation published with it. Natural frequencies of
the undeformed, unloaded state: 1.6387 3.4529 6.3668 11.2515 13.6057 14.7337 18.7283 20.0070 20.2884 26.3396 Hz.
"""

from dataclasses import dataclass
from itertools import accumulate

from fe_models.damping import rayleigh_damping
from fe_models.sections import Section, round_wire, square_tube
from fe_models.structure import Beam, Cable, PointMass, Structure, Support

PAPER_FREQUENCIES = (1.6387, 3.4529, 6.3667, 11.2516, 13.605, 14.734, 18.729, 20.010, 20.290, 26.338)
"""Hz, of the authors' model: cables there have a beam's mass, and the towers' element masses are left unrotated."""

ALUMINIUM = {"youngs_modulus": 7.2e10, "density": 2799.673269}
STEEL = {"youngs_modulus": 1.9e11, "density": 8015.111293}
DECK = square_tube("deck tube", **ALUMINIUM, side=0.015, wall=0.0012)
TOWER = square_tube("tower tube", **ALUMINIUM, side=0.015, wall=0.002)
THICK_WIRE = round_wire("wire 0.22 mm", **STEEL, diameter=0.22e-3)
THIN_WIRE = round_wire("wire 0.16 mm", **STEEL, diameter=0.16e-3)

DECK_LENGTHS = (0.2,) * 8 + (0.3, 0.2, 0.2, 0.3) + (0.2,) * 4 + (0.3, 0.2, 0.2, 0.3) + (0.2,) * 8
DECK_MASS = 0.5  # kg added to each deck element, half of it at each end
TOWER_MASSES = (0.4,) * 8 + (0.2,) * 4  # kg added to each tower element, from the base up
ROLLERS = (1, 4, 7, 23, 26, 29)  # deck nodes held in y; in x only the cables hold the deck: mode 1 is its sway
TOWER_NODES = 13


@dataclass(frozen=True)
class Stay:
    """A cable of the left half: its end nodes, its section, and the tension (N) that keeps the deck level."""

    nodes: tuple[int, int]
    mirrored: tuple[int, int]
    section: Section
    tension: float


STAYS = (
    Stay((1, 40), (53, 29), THICK_WIRE, 38.6),
    Stay((4, 38), (51, 26), THIN_WIRE, 25.5),
    Stay((38, 10), (20, 51), THIN_WIRE, 23.8),
    Stay((40, 13), (17, 53), THICK_WIRE, 37.0),
)

# The authors' own simulation of recording 1 decays with 0.30 % in its first two modes and with more above them, as
# Rayleigh damping does; the recordings themselves show 0.2 to 0.4 % in their first modes.
DAMPING = rayleigh_damping(ratio=0.003, first=1.6387, second=3.4529)


def bridge() -> Structure:
    """Return the bridge: nodes 1-29 deck, 30-42 and 43-55 towers; elements 1-28, 29-40, 41-52, then cables 53-60."""
    deck = range(1, len(DECK_LENGTHS) + 2)
    left, right = range(30, 30 + TOWER_NODES), range(43, 43 + TOWER_NODES)
    # Rounded to the micrometre, lest the sums of lengths leave 1e-16 between equal elements and their mirror images.
    nodes = [(round(x, 6), 0.0) for x in accumulate(DECK_LENGTHS, initial=-3.0)]
    nodes += [(x, round(-0.2 + 0.1 * i, 6)) for x in (-1.8, 1.8) for i in range(TOWER_NODES)]
    elements: list[Beam | Cable] = []
    for members, section, group in (
        (deck, DECK, "deck"),
        (left, TOWER, "left tower"),
        (right, TOWER, "right tower"),
    ):
        elements += [Beam((i, i + 1), section, group) for i in members[:-1]]
    elements += [Cable(stay.nodes, stay.section, stay.tension) for stay in STAYS]
    elements += [Cable(stay.mirrored, stay.section, stay.tension) for stay in reversed(STAYS)]
    masses = [PointMass(node, mass) for node, mass in _halves(deck, (DECK_MASS,) * len(DECK_LENGTHS))]
    for tower in (left, right):
        masses += [PointMass(node, mass) for node, mass in _halves(tower, TOWER_MASSES)]
    return Structure(
        name="bridge",
        nodes=tuple(nodes),
        elements=tuple(elements),
        point_masses=tuple(masses),
        supports=(
            *(Support(node, ("y",)) for node in ROLLERS),
            *(Support(tower[0], ("x", "y", "rz")) for tower in (left, right)),
        ),
        damping=DAMPING,
    )


def _halves(nodes: range, element_masses: tuple[float, ...]) -> list[tuple[int, float]]:
    """Return each node of a member with half the mass of the elements to its left and right (kg)."""
    before, after = (0.0, *element_masses), (*element_masses, 0.0)
    return [(node, (a + b) / 2) for node, a, b in zip(nodes, before, after, strict=True)]
