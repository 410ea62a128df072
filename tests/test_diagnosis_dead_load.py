"""Weight that a structure feels and its drawn modes do not: hidden by Exudyn's gravity, found as a dead load."""

from dataclasses import replace
from functools import cache

import numpy as np
import pytest

from fe_models.causes import DeadLoad, Effect, PointDamper
from fe_models.causes.known import Known
from fe_models.causes.places import Motion
from fe_models.measurement import lowpassed
from fe_models.recordings import Dataset, Recording, Sensor
from fe_models.sections import square_tube
from fe_models.simulation import ReleaseConfig, simulate_release
from fe_models.statics import PointLoad
from fe_models.structure import Beam, Damping, PointMass, Structure, Support
from hybrid.diagnosis.nominal.structure_model import nominal_model_of
from hybrid.diagnosis.outcome.conclusion import Diagnosis
from hybrid.diagnosis.outcome.verdict import Verdict
from hybrid.diagnosis.series_diagnosis import diagnose_series as diagnose

TUBE = square_tube("tube", youngs_modulus=2.1e11, density=7850.0, side=0.1, wall=0.005)
HEAD = 600.0  # kg, a tenth of what would buckle the mast
SENSORS = tuple(Sensor(f"a{node}", node, "x", "acceleration", "m/s^2") for node in (2, 3, 4, 5))
RATE, CUTOFF = 100.0, 30.0
PULLS = ({5: 60.0}, {3: 150.0}, {4: -90.0, 2: 200.0}, {5: -40.0, 3: 100.0})  # N, by node; the last for testing


def mast() -> Structure:
    """Five nodes from the ground up, masses at each, the heaviest on top."""
    nodes = tuple((0.0, 1.5 * i) for i in range(5))
    masses = tuple(PointMass(node, 60.0) for node in (2, 3, 4))
    return Structure(
        "mast",
        nodes,
        tuple(Beam((i, i + 1), TUBE) for i in range(1, 5)),
        (*masses, PointMass(5, HEAD)),
        supports=(Support(1, ("x", "y", "rz")),),
        damping=Damping(modal_ratios=(0.01,)),
        divisions=2,
    )


@cache
def recorded(gravity: float, *effects: Effect) -> Dataset:
    """Releases of the mast under ``gravity`` (m/s^2), measured with 2 % noise."""
    rng, config = np.random.default_rng(3), ReleaseConfig(12.0, 500.0, 5e-4, gravity)
    parts = []
    for number, pull in enumerate(PULLS):
        loads = tuple(PointLoad(node, "x", force) for node, force in pull.items())
        motion = simulate_release(mast().with_effects(*effects), loads, config, progress=False)
        fine = np.stack([motion.shown(s) for s in SENSORS], axis=-1)
        clean = lowpassed(fine, 500.0, CUTOFF)[100::5]  # what the jump of the release leaves has died down
        data = clean + 0.02 * clean.std(axis=0) * rng.standard_normal(clean.shape)
        parts.append(Recording(f"r{number}", data[None], "train" if number < len(PULLS) - 1 else "test"))
    return Dataset(mast(), RATE, SENSORS, tuple(parts), lowpass=CUTOFF)


@cache
def under_gravity() -> Diagnosis:
    return diagnose(recorded(9.81))


@pytest.mark.slow
def test_weight_that_modes_lack_is_named_with_its_share() -> None:
    found = under_gravity()
    assert found.verdict is Verdict.EXPLAINED
    (finding,) = found.findings
    assert finding.cause.kind == "dead_load"
    assert finding.cause.location == {}
    assert finding.probability > 0.7  # compression of all elements is nearly the same
    share = finding.parameters["share"]
    assert abs(share.value - 1.0) < 2 * share.std < 0.2
    before, after = (found.scores[name]["measured"] for name in ("baseline", "extended"))
    assert before is not None and after is not None
    assert after < 1.1 * found.noise_floor < 0.2 * before
    assert finding.sentence.startswith("The structure feels its own weight and prestress (P-delta), ")


@pytest.mark.slow
def test_extended_structure_feels_its_weight() -> None:
    (effect,) = under_gravity().extended.effects
    assert isinstance(effect, DeadLoad)
    again = nominal_model_of(replace(recorded(9.81), model=under_gravity().extended)).modes[0][0]
    shown = under_gravity().observations.observed.frequencies[0] * 2 * np.pi
    assert again == pytest.approx(shown, rel=1e-3)
    assert again < 0.97 * nominal_model_of(recorded(9.81)).modes[0][0]


@pytest.mark.slow
def test_a_third_of_its_weight_is_another_cause() -> None:
    """A part stands for something else: here for compression, as by a push from above."""
    found = diagnose(recorded(9.81 / 3))
    (finding,) = found.findings
    assert (finding.cause.kind, finding.cause.location) == ("axial_force", {"elements": [1, 2, 3, 4]})
    assert all(rival.kind != "dead_load" for rival in finding.alternatives)


@pytest.mark.slow
def test_mast_without_weight_is_not_said_to_feel_it() -> None:
    found = diagnose(recorded(0.0))
    assert found.verdict is Verdict.NOTHING_WRONG


@pytest.mark.slow
def test_damper_beside_weight_is_named_with_it() -> None:
    found = diagnose(recorded(9.81, PointDamper((3,), "x", 100.0)))
    assert found.verdict is Verdict.EXPLAINED
    weight, damper = sorted(found.findings, key=lambda finding: finding.cause.kind)
    assert (weight.cause.kind, damper.cause.kind) == ("dead_load", "point_damper")
    assert damper.cause.location == {"node": 3, "direction": "x"}
    assert damper.parameters["coefficient"].value == pytest.approx(100.0, rel=0.1)  # the contract's bound


def dead_loads(structure: Structure) -> list[str]:
    given = replace(recorded(0.0), model=structure)
    nominal = nominal_model_of(given)
    still = Motion(np.zeros((2, len(nominal.dofs))), np.zeros((2, len(nominal.dofs))))
    return [c.kind for c in DeadLoad.candidates(Known(nominal, still))]


@pytest.mark.slow
def test_dead_load_is_asked_where_it_may_be_felt() -> None:
    assert dead_loads(mast()) == ["dead_load"]
    assert dead_loads(mast().with_effects(DeadLoad())) == []  # it has it already
    light = tuple(PointMass(node, 0.01) for node in (2, 3, 4, 5))
    assert dead_loads(replace(mast(), point_masses=light, nodes=tuple((0.0, 0.2 * i) for i in range(5)))) == []
    heavy = tuple(PointMass(node, 1e4) for node in (2, 3, 4, 5))
    assert dead_loads(replace(mast(), point_masses=heavy)) == []  # it would fall
