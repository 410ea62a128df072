"""The reduced model feels every effect as Exudyn does: from the same definition, in modal coordinates."""

from collections.abc import Iterator
from dataclasses import replace

import numpy as np
import pytest
import torch

from fe_models.assembly import linearise
from fe_models.built_in.bridge import bridge
from fe_models.built_in.four_dof import four_dof
from fe_models.causes import CoulombFriction, CubicSpring, Effect, GapStop, HarmonicForce, SlackCable
from fe_models.causes.laws import force_laws
from fe_models.errors import InputError
from fe_models.modes import natural_modes
from fe_models.simulation import FreeConfig, simulate_free
from fe_models.structure import Damping
from hybrid.neural_modal_ode.dynamics import effect_shape
from hybrid.neural_modal_ode.integrators import propagate
from tests.hybrid_problems import double_precision, dynamics_of, solved
from tests.test_force_laws import CHAIN_EFFECTS
from tests.test_linear_effects import CHAIN as LINEAR_EFFECTS

START = np.array([1.0, -0.6, 0.8, 0.5])
LAWS = {name: effect for name, effect in CHAIN_EFFECTS.items() if not isinstance(effect, HarmonicForce)}


@pytest.fixture(autouse=True)
def _double() -> Iterator[None]:
    with double_precision():
        yield


@pytest.mark.slow
@pytest.mark.parametrize("name", [*LAWS, *(name for name in LINEAR_EFFECTS if name != "damper")])
def test_all_modes_of_the_extended_chain_move_as_exudyn_s_run(name: str) -> None:
    """A damper at one point couples the modes, which the modal model leaves out; the others here keep them apart."""
    effect: Effect = {**LAWS, **LINEAR_EFFECTS}[name]
    structure = replace(four_dof(), dashpots=(), damping=Damping(modal_ratios=(0.02,))).with_effects(effect)
    modal = natural_modes(linearise(structure), 4)
    response = simulate_free(structure, START[None], np.zeros((1, 4)), FreeConfig(6.0, 10.0, 0.0025))
    dynamics = dynamics_of(modal, force_laws(structure))
    q0 = modal.shapes.T @ (linearise(structure).mass @ START)
    z = solved(dynamics, np.concatenate([q0, np.zeros(4)]), response.time)
    # Exact but for the jumps of a slope, at a stop or at v = 0 of drag, which Exudyn's fixed steps run over.
    np.testing.assert_allclose(z[:, :4] @ modal.shapes.T, response.displacement[0], atol=3e-6)
    np.testing.assert_allclose(z[:, 4:] @ modal.shapes.T, response.velocity[0], atol=3e-6)


@pytest.mark.slow
@pytest.mark.parametrize(
    "effect", [GapStop((4,), "x", 0.2, 2e3, 1), CoulombFriction((2,), "x", 0.3, 2e-3), SlackCable(2, 0.1)]
)
def test_steep_effects_get_the_substeps_that_they_need(effect: Effect) -> None:
    structure = four_dof().with_effects(effect)
    modal = natural_modes(linearise(four_dof()), 4)
    dynamics = dynamics_of(modal, force_laws(structure))
    z0 = torch.tensor(np.concatenate([modal.shapes.T @ (linearise(structure).mass @ START), np.zeros(4)]))[None]
    parts = dynamics.substeps(0.1)
    shape = effect_shape(modal, force_laws(structure)[0])
    stiffness, damping = force_laws(structure)[0].largest_slopes
    assert parts == np.ceil(0.1 * max(np.sqrt(stiffness * shape @ shape), damping * shape @ shape) / 0.25)
    assert parts > 1 or isinstance(effect, SlackCable)
    with torch.no_grad():
        found = propagate(dynamics, z0, 60 * parts + 1, 0.1 / parts)[0, ::parts, :4].numpy()
    exact = solved(dynamics, z0[0].numpy(), np.linspace(0.0, 6.0, 61))[:, :4]
    # Second order at a quarter of a radian a step, behind a kink first: 2 % while it stays stable, at all.
    assert np.abs(found - exact).max() < 0.03 * np.abs(exact).max()
    assert dynamics_of(modal, (CubicSpring((1,), "x", 1.0),)).substeps(0.1) == 1


def test_a_force_that_depends_on_time_is_refused() -> None:
    modal = natural_modes(linearise(four_dof()), 4)
    with pytest.raises(InputError, match="no force that depends on time, and the structure has harmonic_force"):
        dynamics_of(modal, (HarmonicForce(1, "x", 1.0, 1.0),))


def test_an_inclined_cable_s_shape_is_its_elongation() -> None:
    modal = natural_modes(linearise(bridge()), 3)
    (law,) = force_laws(bridge().with_effects(SlackCable(53, 10.0)))  # from node 1 to node 40
    line = np.subtract(bridge().nodes[39], bridge().nodes[0])
    along = line / np.hypot(*line)
    moved = modal.shapes[3 * 39 : 3 * 39 + 2] - modal.shapes[0:2]
    np.testing.assert_allclose(effect_shape(modal, law), along @ moved, atol=1e-15)
