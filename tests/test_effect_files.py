"""Effects in structure files: every kind there and back, words and units of the contract, every fault at once."""

from dataclasses import replace
from pathlib import Path

import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from fe_models.built_in.bridge import bridge
from fe_models.built_in.four_dof import four_dof
from fe_models.causes import (
    CAUSES,
    AddedMass,
    AxialForce,
    Cause,
    CoulombFriction,
    CubicSpring,
    DeadLoad,
    Effect,
    GapStop,
    HarmonicForce,
    HystereticSpring,
    LoadDelay,
    LoadGain,
    MassChange,
    ModalDamping,
    PointDamper,
    QuadraticDamper,
    QuadraticSpring,
    SensorDelay,
    SensorDrift,
    SensorGain,
    SlackCable,
    StiffnessChange,
    SupportSpring,
    TimeIntegration,
    WrongModalModel,
    known_effects,
)
from fe_models.errors import InputError
from fe_models.files.structure_file import load_structure, save_structure, structure_from_text, structure_text
from fe_models.structure import Structure, Support
from fe_models.structure_checks import check_structure
from tests.problems import cantilever

# Each kind of the contract: an example, its location and its parameters with units.
WORDS: list[tuple[Cause, dict[str, object], dict[str, tuple[object, str]]]] = [
    (StiffnessChange((5,), 0.8), {"element": 5}, {"factor": (0.8, "1")}),
    (StiffnessChange((5, 6), (0.8, 0.9)), {"elements": [5, 6]}, {"factor": ([0.8, 0.9], "1")}),
    (AddedMass(3, -0.2), {"node": 3}, {"mass": (-0.2, "kg")}),
    (SupportSpring(4, "y", 1e5), {"node": 4, "direction": "y"}, {"stiffness": (1e5, "N/m")}),
    (SupportSpring(4, "rz", 1e5), {"node": 4, "direction": "rz"}, {"stiffness": (1e5, "N m/rad")}),
    (AxialForce((1,), 3.0), {"elements": [1]}, {"force": (3.0, "N")}),
    (DeadLoad(0.9), {}, {"share": (0.9, "1")}),
    (ModalDamping((1, 2), 0.02), {"modes": [1, 2]}, {"ratio": (0.02, "1")}),
    (PointDamper((3, 4), "y", 2.0), {"nodes": [3, 4], "direction": "y"}, {"coefficient": (2.0, "N s/m")}),
    (QuadraticDamper((3,), "y", 2.0), {"node": 3, "direction": "y"}, {"coefficient": (2.0, "N s^2/m^2")}),
    (CoulombFriction((3,), "x", 0.5, 2e-3), {"node": 3, "direction": "x"}, {"force": (0.5, "N")}),
    (CubicSpring((3,), "y", -2.0), {"node": 3, "direction": "y"}, {"stiffness": (-2.0, "N/m^3")}),
    (QuadraticSpring((3,), "y", -2.0), {"node": 3, "direction": "y"}, {"stiffness": (-2.0, "N/m^2")}),
    (
        GapStop((3, 5), "y", 1e-3, 1e5, -1),
        {"nodes": [3, 5], "direction": "y"},
        {"gap": (1e-3, "m"), "stiffness": (1e5, "N/m"), "side": (-1, "1")},
    ),
    (
        HystereticSpring((3,), "y", 1e5, 20.0, 3.0),
        {"node": 3, "direction": "y"},
        {"stiffness": (1e5, "N/m"), "force": (20.0, "N"), "sharpness": (3.0, "1")},
    ),
    (SlackCable(54, 12.0), {"element": 54}, {"pretension": (12.0, "N")}),
    (
        HarmonicForce(3, "y", 2.0, 1.5, 0.3),
        {"node": 3, "direction": "y"},
        {"amplitude": (2.0, "N"), "frequency": (1.5, "Hz"), "phase": (0.3, "rad")},
    ),
    (MassChange((1, 2, 3), 1.1), {"elements": [1, 2, 3]}, {"factor": (1.1, "1")}),
    (SensorGain("a1", 1.1), {"sensor": "a1"}, {"factor": (1.1, "1")}),
    (SensorDelay("a1", 0.01), {"sensor": "a1"}, {"delay": (0.01, "s")}),
    (LoadGain((2, "x"), 1.2), {"load": [2, "x"]}, {"factor": (1.2, "1")}),
    (LoadDelay("base", 0.01), {"load": "base"}, {"delay": (0.01, "s")}),
    (SensorDrift("a1", 0.1), {"sensor": "a1"}, {"slope": (0.1, "unit/s")}),
    (TimeIntegration(0.05), {}, {"step": (0.05, "s")}),
    (WrongModalModel(), {}, {}),
]
EXAMPLES = tuple(cause for cause, _, _ in WORDS if isinstance(cause, Effect))


@pytest.mark.parametrize(("cause", "location", "parameters"), WORDS)
def test_words_and_units_are_the_contract_s(
    cause: Cause, location: dict[str, object], parameters: dict[str, tuple[object, str]]
) -> None:
    assert CAUSES[cause.kind] is type(cause)
    assert cause.location == location
    assert cause.parameters == {name: value for name, (value, _) in parameters.items()}
    assert cause.units == {name: unit for name, (_, unit) in parameters.items()}


def test_every_kind_has_an_example_here() -> None:
    assert {cause.kind for cause, _, _ in WORDS} == set(CAUSES)
    assert {effect.kind for effect in EXAMPLES} == set(known_effects())
    assert len(CAUSES) == 23


def test_all_effects_together_come_back_equal(tmp_path: Path) -> None:
    structure = bridge().with_effects(*EXAMPLES)
    assert check_structure(structure) == []
    save_structure(structure, tmp_path / "extended.toml")
    again = load_structure(tmp_path / "extended.toml")
    assert again == structure
    assert again.effects == EXAMPLES


numbers = st.floats(-1e30, 1e30)
sizes = st.floats(0, 1e30)
nodes = st.integers(1, 55)
pairs = st.lists(nodes, min_size=1, max_size=2, unique=True).map(tuple)
directions = st.sampled_from(["x", "y", "rz"])


def several(places: st.SearchStrategy[int], values: st.SearchStrategy[float]) -> st.SearchStrategy[tuple[object, ...]]:
    """Places, and one value for all or one for each."""
    return st.lists(places, min_size=1, max_size=4, unique=True).flatmap(
        lambda some: st.tuples(
            st.just(tuple(some)), values | st.lists(values, min_size=len(some), max_size=len(some)).map(tuple)
        )
    )


effects = st.one_of(
    several(st.integers(1, 60), sizes).map(lambda two: StiffnessChange(*two)),  # type: ignore[arg-type]
    several(st.integers(1, 60), numbers).map(lambda two: AxialForce(*two)),  # type: ignore[arg-type]
    several(st.integers(1, 400), st.floats(0, 0.99)).map(lambda two: ModalDamping(*two)),  # type: ignore[arg-type]
    st.builds(DeadLoad, sizes),
    st.builds(AddedMass, nodes, numbers),
    st.builds(SupportSpring, nodes, directions, sizes),
    st.builds(PointDamper, pairs, directions, numbers),
    st.builds(QuadraticDamper, pairs, directions, sizes),
    st.builds(CoulombFriction, pairs, directions, sizes, st.floats(1e-9, 1e9)),
    st.builds(CubicSpring, pairs, directions, numbers),
    st.builds(QuadraticSpring, pairs, directions, numbers),
    st.builds(GapStop, pairs, directions, sizes, sizes, st.sampled_from([1, -1])),
    st.builds(SlackCable, st.integers(53, 60), sizes),
    st.builds(HarmonicForce, nodes, directions, numbers, st.floats(1e-9, 1e9), numbers),
)


@settings(deadline=None, max_examples=60, suppress_health_check=[HealthCheck.too_slow])
@given(st.lists(effects, max_size=4))
def test_any_effects_come_back_with_every_digit(some: list[Effect]) -> None:
    structure = bridge().with_effects(*some)
    soft = any(isinstance(effect, SupportSpring) for effect in some)  # may leave a piece without support
    if not soft:
        assert repr(structure_from_text(structure_text(structure), "s.toml").effects) == repr(structure.effects)
    assert soft or check_structure(structure) == []


def faults_of(kind_and_keys: str) -> tuple[str, ...]:
    """The faults of the bridge's file with one effect written as given, without their common beginning."""
    text = structure_text(bridge()) + f"\n[[effects]]\n{kind_and_keys}\n"
    with pytest.raises(InputError) as caught:
        structure_from_text(text, "s.toml")
    return tuple(fault.removeprefix("s.toml: effects[1]") for fault in caught.value.faults)


@pytest.mark.parametrize(
    ("table", "fault"),
    [
        ('kind = "stifness_change"', ".kind: \"stifness_change\" is unknown; did you mean 'stiffness_change'?"),
        ('kind = "sensor_gain"\nsensor = "a1"\nfactor = 2', '.kind: "sensor_gain" is unknown'),
        ('kind = "stiffness_change"\nelement = 3', ".factor: missing; expected a number or [a number, ...]"),
        (
            'kind = "stiffness_change"\nelement = 61\nfactor = 0.5',
            ": element 61 does not exist; the elements are 1 to 60",
        ),
        ('kind = "stiffness_change"\nelements = []\nfactor = 0.5', ": elements: there are none; give their numbers"),
        ('kind = "stiffness_change"\nelements = [3, 3]\nfactor = 0.5', ": element 3 is given 2 times"),
        ('kind = "stiffness_change"\nelements = [3, 4]\nfactor = [0.5]', ": factor lists 1 values for 2 places"),
        ('kind = "stiffness_change"\nelement = 3\nfactor = -0.5', ": factor = -0.5; must not be negative"),
        ('kind = "stiffness_change"\nelement = 3\nfactr = 0.5', ".factr: unknown key; did you mean 'factor'?"),
        ('kind = "stiffness_change"\nelement = 3\nelements = [4]\nfactor = 0.5', ".element: unknown key; did you mean"),
        ('kind = "added_mass"\nnode = 56\nmass = 1.0', ": node 56 does not exist; the nodes are 1 to 55"),
        ('kind = "added_mass"\nnode = 5\nmass = nan', ".mass: expected a number, found NaN"),
        ('kind = "added_mass"\nnode = 5\ndirection = "x"\nmass = 1.0', ".direction: unknown key"),
        ('kind = "support_spring"\nnode = 4\ndirection = "y"\nstiffness = -1.0', ": stiffness = -1.0; must not be"),
        (
            'kind = "support_spring"\nnode = 4\ndirection = "z"\nstiffness = 1.0',
            ": direction 'z' is not among those of the nodes, x, y, rz",
        ),
        (
            'kind = "axial_force"\nelements = [3]\nforce = "big"',
            '.force: expected a number or [a number, ...], found "big"',
        ),
        ('kind = "dead_load"\nshare = -1.0', ": share = -1.0; must not be negative (1 is the weight as drawn)"),
        ('kind = "dead_load"\nnode = 3', ".node: unknown key"),
        ('kind = "modal_damping"\nmodes = [0]\nratio = 0.01', ": mode 0 does not exist; modes are numbered from 1"),
        ('kind = "modal_damping"\nmodes = [2, 2]\nratio = 0.01', ": modes = [2, 2]: give each mode once"),
        ('kind = "modal_damping"\nmodes = [2]\nratio = 1.5', ": ratio = 1.5; expected 0 <= ratio < 1"),
        ('kind = "point_damper"\nnodes = [3, 3]\ndirection = "y"\ncoefficient = 1.0', ": joins node 3 to itself"),
        ('kind = "quadratic_damper"\nnode = 3\ndirection = "y"\ncoefficient = -1.0', ": coefficient = -1.0; must not"),
        ('kind = "coulomb_friction"\nnode = 3\ndirection = "y"', ".force: missing; expected a number"),
        ('kind = "coulomb_friction"\nnode = 3\ndirection = "y"\nfriction = 1.0', ".friction: unknown key"),
        ('kind = "coulomb_friction"\nnode = 3\ndirection = "y"\nforce = -1.0', ": force = -1.0; must not be negative"),
        (
            'kind = "coulomb_friction"\nnode = 3\ndirection = "y"\nforce = 1.0\nregularisation = 0.0',
            ": regularisation = 0.0; must be positive",
        ),
        (
            'kind = "gap_stop"\nnode = 3\ndirection = "y"\ngap = 0.1\nstiffness = 1.0\nside = 2',
            ".side: expected 1 or -1",
        ),
        (
            'kind = "gap_stop"\nnode = 3\ndirection = "y"\ngap = -0.1\nstiffness = 1.0\nside = 1',
            ": gap = -0.1; must not",
        ),
        ('kind = "slack_cable"\nelement = 3\npretension = 1.0', ": element 3 is a beam; expected a cable or a spring"),
        ('kind = "slack_cable"\nelement = 54\npretension = -1.0', ": pretension = -1.0; must not be negative"),
        ('kind = "slack_cable"\nelements = [54]\npretension = 1.0', ".elements: unknown key; did you mean 'element'?"),
        (
            'kind = "harmonic_force"\nnode = 3\ndirection = "y"\namplitude = 1.0\nfrequency = 0',
            ": frequency = 0.0 Hz; must",
        ),
    ],
)
def test_a_fault_is_named_with_its_place(table: str, fault: str) -> None:
    found = faults_of(table)
    assert any(line.startswith(fault) for line in found), found


def test_all_faults_come_out_at_once() -> None:
    table = 'kind = "gap_stop"\nnodes = [3, 77]\ndirection = "y"\ngap = -0.1\nstiffness = -2.0\nside = 1'
    assert len(faults_of(table)) == 3
    table = 'kind = "gap_stop"\nnode = 3\ndirection = "y"\ngap = true\nstifness = -2.0'
    assert len(faults_of(table)) == 4  # gap, an unknown key, and two that are missing


@pytest.mark.parametrize(
    ("structure", "effect", "fault"),
    [
        (
            four_dof(),
            AxialForce((2,), 1.0),
            "element 2: its nodes move in x only, along its line, where an axial force",
        ),
        (four_dof(), AxialForce((1,), 1.0), "element 1 is a spring to the ground, without length"),
        (four_dof(), CubicSpring((1,), "y", 1.0), "direction 'y' is not among those of the nodes, x"),
        (four_dof(), CubicSpring((1,), "x", float("inf")), "stiffness = inf; must be finite"),
        (four_dof(), AddedMass(1, float("nan")), "mass = nan; must be finite"),
        (four_dof(), StiffnessChange((1, 2), (1.0, float("nan"))), "factor = (1.0, nan); must be finite"),
    ],
)
def test_faults_of_effects_made_in_python(structure: Structure, effect: Effect, fault: str) -> None:
    assert any(line.startswith(f"effects[1]: {fault}") for line in check_structure(structure.with_effects(effect)))


def test_a_restraint_that_is_an_effect_holds_what_would_turn() -> None:
    pinned = replace(cantilever(), supports=(Support(1, ("x", "y")),))
    assert check_structure(pinned) == [
        "nodes 1, 2: held too little, free to turn about a point as a rigid body; add a support"
    ]
    assert check_structure(pinned.with_effects(SupportSpring(1, "rz", 100.0))) == []
