"""Where forces are looked for on a frame: at its nodes, and between parts that stand side by side."""

from dataclasses import replace
from typing import Any

import numpy as np
import pytest

from fe_models.assembly import linearise
from fe_models.bridge import bridge
from fe_models.effects import CoulombFriction, Effect, GapStop
from fe_models.modes import natural_modes
from fe_models.recordings import Assumptions, Dataset, Recording, Sensor
from fe_models.sections import square_tube
from fe_models.simulate import FreeConfig, simulate_free
from fe_models.structure import Beam, Damping, PointMass, Spring, Structure, Support
from hybrid.diagnosis.diagnosis import diagnose
from hybrid.diagnosis.places import Motion, places_of
from hybrid.diagnosis.plant import plant_of
from hybrid.diagnosis.verdict import Verdict

TUBE = square_tube("tube", youngs_modulus=2.1e11, density=7850.0, side=0.1, wall=0.005)
APART = 0.05  # m, between two masts
COUNT = 4
SENSORS = tuple(Sensor(f"a{node}", node, "x", "acceleration", "m/s^2") for node in (2, 3, 5, 6))
RATE, DURATION = 100.0, 5.0
NOISE = 0.02  # of each channel's rms
MOVING = 4  # modes below a quarter of the sampling rate


def masts(apart: float = APART) -> Structure:
    """Two masts side by side, nodes 1-3 and 4-6 from the ground up, the second with heavier storeys."""
    nodes = tuple((x, y) for x in (0.0, apart) for y in (0.0, 2.0, 4.0))
    elements = tuple(Beam((i, i + 1), TUBE) for i in (1, 2, 4, 5))
    masses = tuple(PointMass(node, mass) for node, mass in ((2, 200.0), (3, 150.0), (5, 320.0), (6, 300.0)))
    supports = tuple(Support(node, ("x", "y", "rz")) for node in (1, 4))
    damping = Damping(modal_ratios=(0.01,))
    return Structure("masts", nodes, elements, masses, supports=supports, damping=damping)


def recorded(structure: Structure, *effects: Effect) -> Dataset:
    """The ``structure``'s recordings with ``effects``, in its modes that move, with noise."""
    rng = np.random.default_rng(11)
    modal = natural_modes(linearise(structure), MOVING)
    begun = rng.standard_normal((2, COUNT, MOVING))  # modal velocities of 1 m kg^0.5 / s: centimetres at the tops
    shapes = modal.shapes[modal.dofs.free].T
    start = (begun[0] / modal.omega) @ shapes, begun[1] @ shapes
    # A step of 0.5 ms, a 70th of the period of the highest mode that moves.
    motion = simulate_free(
        structure.with_effects(*effects), start[0], start[1], FreeConfig(DURATION, RATE, 5e-4), progress=False
    )
    clean = np.stack([motion.channel(s.node, s.direction, s.quantity) for s in SENSORS], axis=-1)
    data = clean + NOISE * clean.std(axis=(0, 1)) * rng.standard_normal(clean.shape)
    parts = tuple(Recording(f"r{i}", data[i : i + 1], "train" if i < COUNT - 1 else "test") for i in range(COUNT))
    return Dataset(structure, RATE, SENSORS, parts, assumptions=Assumptions())


def pairs_of(structure: Structure) -> list[Any]:
    """The pairs of nodes between which forces are looked for."""
    rng = np.random.default_rng(0)
    recording = Recording("r", rng.standard_normal((1, 200, len(SENSORS))))
    plant = plant_of(Dataset(structure, RATE, SENSORS, (recording,)))
    motion = Motion.of_states(rng.standard_normal((50, 2 * plant.size)), plant)
    return [(place.location["nodes"], place.direction) for place in places_of(plant, motion) if len(place.nodes) == 2]


def test_nodes_of_parts_side_by_side_are_pairs() -> None:
    assert pairs_of(masts()) == [([2, 5], "x"), ([3, 6], "x")]  # along the masts nothing moves


def test_what_is_far_apart_or_joined_by_a_beam_is_no_pair() -> None:
    assert pairs_of(masts(apart=2.0)) == []
    joined = masts()
    assert ([3, 6], "x") not in pairs_of(replace(joined, elements=(*joined.elements, Beam((3, 6), TUBE))))


def test_ends_of_a_spring_are_a_pair_however_far_apart() -> None:
    far = masts(apart=3.0)
    assert pairs_of(replace(far, elements=(*far.elements, Spring((6, 3), "x", 1e3)))) == [([3, 6], "x")]


def test_deck_and_tower_of_the_bridge_are_a_pair_where_they_cross() -> None:
    structure = bridge()
    crossing = [(structure.nodes[i - 1], structure.nodes[j - 1]) for i, j in ((7, 32), (23, 45))]
    assert all(one == other for one, other in crossing)
    assert {tuple(pair) for pair, _ in pairs_of(structure)} == {(7, 32), (23, 45)}


@pytest.mark.parametrize(
    "effect", [GapStop((3, 6), "x", 0.005, 2e5, 1), CoulombFriction((3, 6), "x", 15.0, 1e-3)], ids=lambda e: e.kind
)
def test_masts_that_knock_or_rub_are_told(effect: GapStop | CoulombFriction) -> None:
    found = diagnose(recorded(masts(), effect))
    assert found.verdict is Verdict.EXPLAINED
    (finding,) = found.findings
    assert (finding.cause.kind, finding.cause.location) == (effect.kind, effect.location)
    assert finding.probability > 0.9
    word = "gap" if isinstance(effect, GapStop) else "force"
    value = finding.parameters[word]
    assert value.value == pytest.approx(effect.parameters[word], rel=0.1)  # the contract's bound
    assert found.scores["extended"]["measured"] == pytest.approx(found.noise_floor, rel=0.05)
