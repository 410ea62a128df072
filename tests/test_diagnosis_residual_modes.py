"""Residual coordinates: what a frame gives way by to force laws, in the modes that are not followed."""

from dataclasses import replace
from typing import Any

import numpy as np
import pytest

from fe_models.arrays import FloatArray
from fe_models.assembly import linearise
from fe_models.built_in.bridge import bridge
from fe_models.causes import CoulombFriction, CubicSpring, SupportSpring
from fe_models.causes.candidate import Candidate
from fe_models.measurement import lowpassed
from fe_models.modes import natural_modes
from hybrid.diagnosis.fitting.driven import forces_along, motion_of
from hybrid.diagnosis.nominal.nominal_model import NominalModel
from hybrid.diagnosis.response import marching
from hybrid.diagnosis.response.config import MARCHING
from hybrid.diagnosis.response.hypothesis import Hypothesis
from hybrid.diagnosis.response.marching import respond
from hybrid.diagnosis.response.residual_modes import residual_modes_of
from hybrid.diagnosis.response.residual_states import with_residual_states
from hybrid.diagnosis.response.state_space import system_of
from tests.test_diagnosis_left_out import OUTPUTS, RATE, SAMPLES, chosen, model_with

NODE, SPRING = 8, 1e4  # where a fifth of the flexibility is that of modes above the low-pass; N/m, a third as stiff
HALF = 5  # modes below half the low-pass, far below those left out
STICKING = 0.5  # N, at a tower's node that this friction mostly holds
CREEP = 1e-4  # m/s, a hundredth of what the node would move at
STARTS = 0.02, 0.015, 0.004  # m kg^0.5, of the lowest modes, which are let go at rest


def pull_at(nominal: NominalModel, node: int, direction: str) -> FloatArray:
    return np.eye(len(nominal.dofs))[nominal.dofs.row(node, direction)]


def test_residual_coordinates_are_statically_exact() -> None:
    nominal = model_with(None)
    pulls = [pull_at(nominal, *place) for place in ((NODE, "y"), (46, "x"), (46, "y"))]  # the last is far stiffer
    residual = residual_modes_of(nominal, pulls)
    assert residual is not None
    bent = np.stack([nominal.left_out(pull) for pull in pulls], axis=1)
    given = residual.shapes @ (residual.pulled / residual.omega[:, None] ** 2)
    for law in range(len(pulls)):
        assert given[:, law] == pytest.approx(bent[:, law], abs=1e-6 * np.abs(bent[:, law]).max())  # rounding


def test_laws_at_one_place_share_a_coordinate() -> None:
    nominal = model_with(None)
    residual = residual_modes_of(nominal, 2 * [pull_at(nominal, NODE, "y")])
    assert residual is not None
    assert residual.pulled.shape == (1, 2)


def test_a_stiff_place_is_slowed_but_no_softer() -> None:
    nominal, pull = model_with(None), pull_at(model_with(None), 46, "y")  # along a tower
    residual = residual_modes_of(nominal, [pull])
    assert residual is not None
    shape = residual.shapes[:, 0]
    assert residual.omega[0] < np.pi * 1.2 * RATE  # of half the sampling rate, nearly
    assert shape @ (nominal.mass @ shape) < 0.1  # of the mass that it moves with
    assert 2 * residual.ratio * residual.omega == pytest.approx(shape @ (nominal.damping @ shape))
    assert residual.pulled[0, 0] ** 2 / residual.omega[0] ** 2 == pytest.approx(pull @ nominal.left_out(pull))


def errors_with_spring(forget: bool) -> FloatArray:
    """How far natural frequencies are off, (mode,), of the bridge with a spring that its few modes feel as a law."""
    nominal = model_with(None)
    omega, shapes = nominal.modes
    pull = pull_at(nominal, NODE, "y")
    residual = residual_modes_of(nominal, [pull])
    assert residual is not None
    squares, felt = np.append(omega, residual.omega) ** 2, np.append(pull @ shapes, residual.pulled)
    if forget:
        squares, felt = squares[:-1], felt[:-1]
    own = np.sqrt(np.linalg.eigvalsh(np.diag(squares) + SPRING * np.outer(felt, felt))) / (2 * np.pi)
    whole = natural_modes(linearise(bridge().with_effects(SupportSpring(NODE, "y", SPRING))), HALF).frequencies
    return np.abs(own[:HALF] / whole - 1)


def test_law_in_few_modes_feels_the_flexibility_of_the_others() -> None:
    error, without = errors_with_spring(forget=False), errors_with_spring(forget=True)
    assert np.all(error < 0.01 * without)  # what is left is how the inertia of the other modes is shared out
    assert error.max() < 1e-5  # a hundredth of what uncertain stiffnesses do


def shown(nominal: NominalModel, law: Candidate, values: tuple[float, ...], forget: bool = False) -> FloatArray:
    """Accelerations (time, sensor) behind a low-pass of a motion under the law, but for its ends."""
    hypothesis = Hypothesis(nominal, (law,))
    if forget:
        vars(hypothesis)["residual"] = None
    states = np.zeros(2 * nominal.size)
    states[: len(STARTS)] = STARTS
    theta = np.append(np.zeros(hypothesis.nuisances), values)[None]
    y = respond(system_of(hypothesis, theta, OUTPUTS), states[None, None], 2 * SAMPLES)[0, 0]
    return lowpassed(y, RATE, 30.0)[20:-20]


@pytest.mark.slow
@pytest.mark.parametrize(
    ("kind", "place", "values", "left"),
    [
        # The cubic force's harmonics come near the next mode, at 33 Hz.
        (CubicSpring.kind, {"node": 10, "direction": "y"}, None, 0.15),
        (CoulombFriction.kind, {"node": 34, "direction": "x"}, (STICKING, CREEP), 0.25),
    ],
)
def test_motion_in_few_modes_is_that_in_many(
    kind: str, place: dict[str, Any], values: tuple[float, ...] | None, left: float
) -> None:
    few, law = model_with(None), chosen(kind, **place)
    values = values or (3 * law.width[0],)
    expected = shown(model_with(30), chosen(kind, 30, **place), values)
    error, without = (np.sqrt(np.mean((shown(few, law, values, forget) - expected) ** 2)) for forget in (False, True))
    assert error < left * without


def test_residual_coordinates_begin_where_a_spring_holds_them() -> None:
    nominal, law = model_with(None), chosen("gap_stop", node=NODE, direction="y", side=1)
    hypothesis = Hypothesis(nominal, (law,))
    gap, states = 1e-9, np.zeros((1, 1, 2 * nominal.size))
    theta = np.append(np.zeros(hypothesis.nuisances), (10 * SPRING, gap))[None]
    system = system_of(hypothesis, theta, OUTPUTS)
    states[..., : len(STARTS)] = np.sign(system.G[0, 0, : len(STARTS)]) * STARTS  # against the stop
    whole = with_residual_states(system, states)
    u, r = (float(x) for x in (system.G[0, 0] @ states[0, 0], whole[0, 0, 2 * nominal.size]))
    assert system.residual_flexibility is not None
    residual = system.residual_flexibility.residual
    pulled, omega = float(residual.pulled[0, 0]), float(residual.omega[0])
    force = 10 * SPRING * (u + pulled * r - gap)
    assert force * pulled == pytest.approx(-(omega**2) * r, rel=1e-4)  # the stop sets in smoothly
    assert -pulled * r > 0.1 * u  # it gives way


def friction_at(substeps: int | None, monkeypatch: pytest.MonkeyPatch) -> FloatArray:
    """The force of friction (time,) that holds a tower's node, by a number of substeps; None: as many as are usual."""
    nominal, law = model_with(None), chosen(CoulombFriction.kind, node=34, direction="x")
    hypothesis = Hypothesis(nominal, (law,))
    theta = np.append(np.zeros(hypothesis.nuisances), (STICKING, CREEP / 2))[None]
    states = np.zeros((1, 1, 2 * nominal.size))
    states[..., : len(STARTS)] = STARTS
    with monkeypatch.context() as patch:
        if substeps is not None:
            other = replace(
                MARCHING,
                min_substeps=substeps,
                max_substeps=substeps,
                max_sharp_substeps=1,
                max_stabilising_substeps=1,
            )
            patch.setattr(marching, "MARCHING", other)
        marched = marching.march(system_of(hypothesis, theta, OUTPUTS), states, SAMPLES)
    assert marched is not None
    return marched.forces[0, 0, :, 0]


def test_friction_that_holds_its_place_is_stepped_stably(monkeypatch: pytest.MonkeyPatch) -> None:
    fine = friction_at(320, monkeypatch)
    own, rough = (
        np.sqrt(np.mean((friction_at(count, monkeypatch) - fine) ** 2) / np.mean(fine**2)) for count in (None, 8)
    )
    assert own < 1e-3  # far below noise; ten times what the scheme leaves
    assert rough > 0.02  # eight substeps, too few, hunt about the place that is held


def test_forces_along_a_motion_are_those_that_acted() -> None:
    nominal, law = model_with(None), chosen(CoulombFriction.kind, node=34, direction="x")
    hypothesis = Hypothesis(nominal, (law,))
    theta = np.append(np.zeros(hypothesis.nuisances), (STICKING, CREEP))[None]
    system = system_of(hypothesis, theta, OUTPUTS)
    states = np.zeros((1, 2 * nominal.size))
    states[:, : len(STARTS)] = STARTS
    motion, marched = motion_of(system, states, SAMPLES), marching.march(system, states[None], SAMPLES)
    assert motion is not None
    assert marched is not None
    (force,) = forces_along(system, motion)
    assert force.now[:, 0] == pytest.approx(marched.forces[0, 0, :, 0], abs=0.01 * STICKING)  # a table against its law
