"""Force laws on a frame: what the modes that are not followed give way by, against the whole structure."""

import numpy as np
import pytest

from fe_models.assembly import linearise
from fe_models.blind.bridge import SENSORS
from fe_models.bridge import bridge
from fe_models.dofs import FloatArray
from fe_models.effects import SupportSpring
from fe_models.modes import natural_modes
from fe_models.recordings import Dataset, Recording
from hybrid.diagnosis.nominal.plant import plant_of
from hybrid.diagnosis.response.forces import yielding

NODE, SPRING = 8, 1e4  # where a fifth of the flexibility is that of modes above the low-pass; N/m, a third as stiff
HALF = 5  # modes below half the low-pass, far below those left out


def frequencies(flexibility: float) -> tuple[FloatArray, FloatArray]:
    """Of the bridge's ten first modes with a spring, as a law in those modes alone, and of the whole bridge (Hz)."""
    plant = plant_of(Dataset(bridge(), 100.0, SENSORS, (Recording("r", np.ones((1, 200, 8))),), 30.0))
    omega, shapes = plant.modes
    pull = np.eye(len(plant.dofs))[plant.dofs.row(NODE, "y")]
    law = yielding(lambda u, v: SPRING * u, flexibility * plant.flexibility(pull))
    felt = float(law(np.ones((1, 1)), np.zeros((1, 1)))[0, 0])
    own = np.linalg.eigvalsh(np.diag(omega**2) + felt * np.outer(pull @ shapes, pull @ shapes))
    whole = natural_modes(linearise(bridge().with_effects(SupportSpring(NODE, "y", SPRING))), len(omega))
    return np.sqrt(own) / (2 * np.pi), whole.frequencies


def test_law_in_few_modes_feels_the_flexibility_of_the_others() -> None:
    error = [np.abs(own / whole - 1)[:HALF] for own, whole in (frequencies(1.0), frequencies(0.0))]
    assert np.all(error[0] < 0.1 * error[1])  # what is left is the inertia of the other modes
    assert error[0].max() < 1e-4


def test_contact_behind_a_spring_is_softer_beyond_the_same_gap() -> None:
    gap, stiffness, flexibility = 0.5, 3.0, 0.4
    u = np.linspace(-1, 2, 301)
    felt = yielding(lambda u, v: stiffness * np.maximum(u - gap, 0.0), flexibility)(u, np.zeros_like(u))
    exact = stiffness / (1 + stiffness * flexibility) * np.maximum(u - gap, 0.0)
    within = u - flexibility * stiffness * (u - gap) >= gap  # one step of Aitken's stays in contact
    assert felt[(u <= gap) | within] == pytest.approx(exact[(u <= gap) | within], abs=1e-12)


def test_nothing_yields_to_a_force_that_is_none() -> None:
    felt = yielding(lambda u, v: 0.0 * u, 0.4)(np.ones((2, 3)), np.ones((2, 3)))
    assert np.all(felt == 0.0)
