"""Dashpots on a bridge in few modes, against the decaying oscillations of the whole one that Exudyn assembles."""

from dataclasses import replace

import numpy as np
import pytest
from scipy.linalg import eig

from benchmarks.blind_cases.bridge import SENSORS
from fe_models.arrays import ComplexArray
from fe_models.assembly import linearise
from fe_models.built_in.bridge import bridge
from fe_models.causes import AxialForce, PointDamper
from fe_models.damping import full_damping
from fe_models.recordings import QUANTITIES
from fe_models.structure import Structure
from hybrid.diagnosis.nominal.nominal_model import NominalModel
from hybrid.diagnosis.nominal.structure_model import nominal_model_of
from hybrid.diagnosis.recorded.sensor_outputs import SensorOutputs
from hybrid.diagnosis.response.hypothesis import Hypothesis
from hybrid.diagnosis.response.state_space import system_of
from tests.test_diagnosis_reduction import BRIDGE, bridge_candidates, bridge_model, chosen

PLACE = PointDamper((9,), "y", 15.0)  # N s/m: damping ratios of up to 3 %
SHOWN = tuple(
    replace(sensor, name=f"{sensor.name} {quantity}", quantity=quantity, unit="1")
    for sensor in SENSORS
    for quantity in QUANTITIES
)
MODES = 9  # of whose frequencies the highest is 20.3 Hz; the band of the recordings ends at 30


def of_the_whole(structure: Structure) -> tuple[ComplexArray, ComplexArray]:
    """Return roots (mode,), 1/s, and what sensors show of each (sensor, mode), from all degrees of freedom."""
    linear = linearise(structure)
    M, K, C = (np.asarray(matrix.toarray()) for matrix in (linear.mass, linear.stiffness, linear.damping))
    C = full_damping(linear) if linear.has_modal_damping else C
    inverse = np.linalg.inv(M)
    size = len(M)
    A = np.block([[np.zeros((size, size)), np.eye(size)], [-inverse @ K, -inverse @ C]])
    roots, vectors = eig(A)
    lowest = np.argsort(np.where(roots.imag > 0, np.abs(roots), np.inf))[:MODES]
    roots, moved = roots[lowest], vectors[:size, lowest]
    q = linear.dofs.expand(moved.real) + 1j * linear.dofs.expand(moved.imag)
    rows = [linear.dofs.row(sensor.node, str(sensor.direction)) for sensor in SHOWN]
    return roots, q[rows] * np.array([roots ** QUANTITIES.index(sensor.quantity) for sensor in SHOWN])


def of_few_modes(nominal: NominalModel, damper: PointDamper | None) -> tuple[ComplexArray, ComplexArray]:
    """Return the same of the diagnosis' own system: all its roots."""
    causes = () if damper is None else (chosen(bridge_candidates(), damper),)
    own = Hypothesis(nominal, causes)
    theta = np.append(np.zeros(own.nuisances), [] if damper is None else damper.coefficient)[None]
    system = system_of(own, theta, SensorOutputs.faultless(SHOWN, 100.0))
    roots, vectors = np.linalg.eig(system.A[0])
    return roots, system.C[0] @ vectors


def errors(few: tuple[ComplexArray, ComplexArray], whole: tuple[ComplexArray, ComplexArray]) -> tuple[float, float]:
    """Return the largest relative error of a root, and of what sensors of one quantity show of its oscillation."""
    of_roots, of_shapes = [], []
    for root, shape in zip(whole[0], whole[1].T, strict=True):
        nearest = int(np.argmin(np.abs(few[0] - root)))
        of_roots.append(abs(few[0][nearest] / root - 1))
        found = few[1][:, nearest]
        found = found * (np.vdot(found, shape) / np.vdot(found, found))
        for number in range(len(QUANTITIES)):
            own = slice(number, None, len(QUANTITIES))
            of_shapes.append(np.linalg.norm((found - shape)[own]) / np.linalg.norm(shape[own]))
    return max(of_roots), float(max(of_shapes))


@pytest.mark.parametrize(("coefficient", "of_roots", "of_shapes"), [(15.0, 1e-7, 1e-5), (60.0, 1e-5, 1e-4)])
def test_a_damper_shows_what_it_does_to_the_whole_bridge(coefficient: float, of_roots: float, of_shapes: float) -> None:
    """Measured: 3e-9 and 9e-7 at 15 N s/m, 2e-6 and 1e-5 at 60; rounding leaves 1e-10 of a root."""
    damper = replace(PLACE, coefficient=coefficient)
    found = errors(of_few_modes(bridge_model(), damper), of_the_whole(bridge().with_effects(damper)))
    assert found[0] < of_roots
    assert found[1] < of_shapes


def test_the_structures_own_dashpots_are_felt_alike() -> None:
    """Ten times as well as without (measured: twenty); the basis holds nothing bent by them, as it does by a cause."""
    own = bridge().with_effects(PLACE)
    found = of_few_modes(nominal_model_of(replace(BRIDGE, model=own)), None)
    assert max(errors(found, of_the_whole(own))) < 7e-4


@pytest.mark.parametrize("coefficient", [300.0, 3e3, 3e5])
def test_a_damper_that_all_but_holds_its_place_stays_stable(coefficient: float) -> None:
    roots, _ = of_few_modes(bridge_model(), replace(PLACE, coefficient=coefficient))
    assert roots.real.max() < 0


def test_a_step_of_a_search_into_buckling_is_of_numbers_still() -> None:
    """The deck pressed so hard that more modes buckle than are followed: no motion, but a sum of squares too large."""
    pressed = AxialForce(tuple(range(1, 29)), -1e6)  # N
    own = Hypothesis(bridge_model(), tuple(chosen(bridge_candidates(), cause) for cause in (PLACE, pressed)))
    theta = np.append(np.zeros(own.nuisances), [PLACE.coefficient, pressed.force])[None]
    reduced = own.reduced(theta)
    assert reduced.trailing is not None
    assert reduced.trailing.square.min() < 0
    assert np.isfinite(system_of(own, theta, SensorOutputs.faultless(SHOWN, 100.0)).A).all()
