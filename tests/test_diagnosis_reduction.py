"""The reduced bridge against the whole one with the effect built in by Exudyn; modes that keep their meaning."""

from dataclasses import replace
from functools import cache

import numpy as np
import pytest
from scipy.linalg import eigh

from benchmarks.blind_cases import SENSORS as CHAIN_SENSORS
from benchmarks.blind_cases.bridge import SENSORS
from fe_models.arrays import FloatArray
from fe_models.assembly import linearise
from fe_models.built_in.bridge import bridge
from fe_models.built_in.four_dof import four_dof
from fe_models.causes import AddedMass, AxialForce, DeadLoad, Effect, StiffnessChange, SupportSpring
from fe_models.causes.candidate import Candidate, MatrixCandidate, SupportCandidate
from fe_models.causes.places import Motion
from fe_models.linear import ModalModel
from fe_models.modes import natural_modes
from fe_models.recordings import Dataset, Recording
from hybrid.diagnosis.nominal import basis as bases
from hybrid.diagnosis.nominal.candidates import all_candidates
from hybrid.diagnosis.nominal.config import NOMINAL
from hybrid.diagnosis.nominal.nominal_model import NominalModel
from hybrid.diagnosis.nominal.structure_model import nominal_model_of
from hybrid.diagnosis.response.eigenmodes import aligned_modes, eigenmodes
from hybrid.diagnosis.response.hypothesis import Hypothesis
from hybrid.diagnosis.response.reduction import basis_of

WHITE = np.random.default_rng(0).standard_normal((1, 200, 8))  # the nominal model only asks for sensors and rates
BRIDGE = Dataset(bridge(), 100.0, SENSORS, (Recording("r", 0 * WHITE),), 30.0)  # nothing fast behind its low-pass
CHAIN = Dataset(four_dof(), 10.0, CHAIN_SENSORS, (Recording("r", WHITE[..., :5]),))
MODES, KEPT, MORE = 10, 11, 15  # below the low-pass, up to where something passes it, and beyond them in the basis
DECK = tuple(range(1, 29))
TWINS = (7, 8)  # modes 8 and 9, from 0: the towers' at 20.01 and 20.29 Hz

# Each effect, its amount, and the largest relative error of a frequency; shapes are of first order where frequencies
# are of second. What few forces make is all but exact; what spreads is as good as the few of its forces that are taken.
EFFECTS: dict[str, tuple[Effect, float, float]] = {
    "cable": (StiffnessChange((57,), 0.3), 0.3, 1e-8),
    "deck element": (StiffnessChange((14,), 0.3), 0.3, 1e-5),
    "whole deck": (StiffnessChange(DECK, 0.3), 0.3, 2e-5),
    "mass": (AddedMass(12, 2.0), 2.0, 1e-7),
    "restraint": (SupportSpring(12, "y", 3e3), 3e3, 1e-8),
    "soft support": (SupportSpring(7, "y", 2e4), 1 / 2e4, 1e-3),
    "axial force": (AxialForce(DECK, -100.0), -100.0, 1e-7),
    "dead load": (DeadLoad(0.9), 0.9, 2e-5),
}
LOCAL = tuple(name for name in EFFECTS if name not in ("whole deck", "axial force", "dead load"))
ROUNDING = 5e-11  # of a frequency, in eigenvalues of such matrices: one machine leaves 9e-12, another less


def candidates_of(dataset: Dataset, nominal: NominalModel) -> tuple[Candidate, ...]:
    q = np.random.default_rng(1).standard_normal((2, 10, nominal.size))
    shapes = nominal.modes[1]
    measured = tuple(i for i, sensor in enumerate(dataset.sensors) if sensor.role == "measured")
    return all_candidates(nominal, dataset, Motion(q[0] @ shapes.T, q[1] @ shapes.T), measured)


@cache
def bridge_model(more: int = MORE) -> NominalModel:
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(bases, "NOMINAL", replace(NOMINAL, extra_modes=more))
        return nominal_model_of(BRIDGE)


@cache
def bridge_candidates() -> tuple[Candidate, ...]:
    return candidates_of(BRIDGE, bridge_model())


@cache
def whole(name: str) -> ModalModel:
    return natural_modes(linearise(bridge().with_effects(EFFECTS[name][0])), MODES)


def chosen(found: tuple[Candidate, ...], effect: Effect) -> Candidate:
    (candidate,) = (c for c in found if c.kind == effect.kind and c.location == effect.location)
    return candidate


def reduced_modes(nominal: NominalModel, candidate: Candidate, amount: float) -> tuple[FloatArray, FloatArray]:
    """Return natural frequencies (rad/s) and shapes (dof, mode) of the nominal model with a candidate."""
    hypothesis = Hypothesis(nominal, (candidate,))
    reduced = hypothesis.reduced(np.array([[0.0] * hypothesis.nuisances + [amount]]))
    omega2, vectors = eigh(reduced.stiffness[0], reduced.mass[0])
    return np.sqrt(omega2), reduced.shapes[0] @ vectors


def frequency_error(name: str, more: int = MORE) -> float:
    effect, amount, _ = EFFECTS[name]
    omega, _ = reduced_modes(bridge_model(more), chosen(bridge_candidates(), effect), amount)
    return float(np.abs(omega[:MODES] / whole(name).omega - 1).max())


@pytest.mark.parametrize("name", EFFECTS)
def test_frequencies_and_shapes_are_those_of_the_whole_bridge(name: str) -> None:
    effect, amount, error = EFFECTS[name]
    nominal = bridge_model()
    assert nominal.size == KEPT
    omega, shapes = reduced_modes(nominal, chosen(bridge_candidates(), effect), amount)
    assert np.abs(whole(name).omega / nominal.modes[0][:MODES] - 1).max() > 0.04  # the effect is large
    assert len(omega) == KEPT + (name == "soft support")  # which brings one more below the low-pass
    assert np.abs(omega[:MODES] / whole(name).omega - 1).max() < error
    rows = nominal.rows(SENSORS)
    found, true = rows @ shapes[:, :MODES], rows @ whole(name).shapes  # (sensor, mode), both normalised by mass
    found = found * np.sign(np.sum(found * true, axis=0))
    assert np.abs(found - true).max() < np.sqrt(error) * np.abs(true).max()


@pytest.mark.parametrize("name", EFFECTS)
def test_error_falls_with_the_modes_in_the_basis(name: str) -> None:
    few, usual, many = (frequency_error(name, more) for more in (3, MORE - 1, 2 * MORE - 1))
    if name == "soft support":  # whose own inertia counts, too: nothing but rounding is left
        assert usual < 0.1 * few
        assert max(usual, many) < 1e-6
    elif name in LOCAL:
        assert usual < 0.1 * few
        assert many < max(0.01 * usual, ROUNDING)
    else:  # of the forces that these bring on each mode only those count that matter
        assert usual < 0.5 * few
        assert max(usual, many) < 2e-5


@pytest.mark.parametrize("name", LOCAL)
def test_modes_without_static_responses_are_far_worse(name: str) -> None:
    effect, amount, _ = EFFECTS[name]
    nominal, candidate = bridge_model(), chosen(bridge_candidates(), effect)
    assert isinstance(candidate, MatrixCandidate)
    size = float(candidate.amount(np.array([amount]))[0])
    M, K = (
        nominal.basis.T @ ((matrix + size * change) @ nominal.basis)
        for matrix, change in ((nominal.mass, candidate.changes[0]), (nominal.stiffness, candidate.changes[2]))
    )
    omega = np.sqrt(eigh(K, M, eigvals_only=True)[:MODES])
    bare = float(np.abs(omega / whole(name).omega - 1).max())
    assert bare > 1e-4  # at 20 Hz the phase slips by 0.04 turns within 20 s
    assert frequency_error(name) < 0.01 * bare


@pytest.mark.parametrize("name", ["cable", "restraint", "soft support"])
def test_what_an_effect_stiffens_it_damps_as_exudyn_does(name: str) -> None:
    effect, amount, _ = EFFECTS[name]
    hypothesis = Hypothesis(bridge_model(), (chosen(bridge_candidates(), effect),))
    reduced = hypothesis.reduced(np.array([[0.0] * hypothesis.nuisances + [amount]]))
    omega2, vectors = eigh(reduced.stiffness[0], reduced.mass[0])
    ratios = np.einsum("vm,vw,wm->m", vectors, reduced.damping[0], vectors) / (2 * np.sqrt(omega2))
    true = natural_modes(linearise(bridge().with_effects(effect)), len(ratios)).damping_ratio
    assert np.abs(ratios / true - 1).max() < 1e-3  # Rayleigh's: twice a frequency's error, 5e-4 of the soft support


@pytest.mark.parametrize(
    ("effect", "amount", "error"),
    [
        (StiffnessChange((3,), 0.05), 0.05, 1e-5),  # what it lacks, it lacks of an element that is off itself
        (SupportSpring(29, "y", 1.3e4), 1 / 1.3e4, 1e-5),
        (SupportSpring(12, "y", 3e3), 3e3, 1e-5),
    ],
    ids=["lost element", "soft support", "restraint"],
)
@pytest.mark.parametrize("turning", [False, True], ids=["damping stays", "damping turns"])
def test_frequencies_and_damping_of_an_off_structure_are_those_that_exudyn_gives_it(
    effect: Effect, amount: float, error: float, turning: bool
) -> None:
    """Every part off by several times the usual, and each damping ratio: of the modes without the effect or with it,
    which they are for a support that gives way in any case.
    """
    nominal = bridge_model()
    candidate = chosen(bridge_candidates(), effect)
    lost = replace(candidate, brings=1) if effect.kind == StiffnessChange.kind else candidate  # as the search has it
    hypothesis = Hypothesis(nominal, (lost,))
    rng, theta = np.random.default_rng(5), np.append(np.zeros(hypothesis.nuisances), amount)
    theta[: nominal.factors] = 3 * nominal.spread[: nominal.factors] * rng.standard_normal(nominal.factors)
    theta[nominal.values] = 1.0 if turning else -1.0
    built = bridge()
    for part, factor in zip(nominal.parts, np.exp(theta[: nominal.factors]), strict=False):
        built = part.scaled(built, float(factor))
    reduced = hypothesis.reduced(theta[None])
    omega2, vectors = eigh(reduced.stiffness[0], reduced.mass[0])
    model = linearise(built.with_effects(effect))
    true = natural_modes(model, len(omega2))
    assert np.abs(np.sqrt(omega2) / true.omega - 1).max() < error
    ratios = np.einsum("vm,vw,wm->m", vectors, reduced.damping[0], vectors) / (2 * np.sqrt(omega2))
    before = true if turning or isinstance(lost, SupportCandidate) else natural_modes(linearise(built), len(omega2))
    factors = np.exp(theta[len(nominal.parts) : nominal.factors])[: len(before.omega)]
    more = np.where(before.frequencies[: len(factors)] < 30, factors - 1, 0.0)  # beyond the low-pass as drawn
    added = 2 * before.damping_ratio[: len(factors)] * before.omega[: len(factors)] * more
    now, then = (modes.shapes[model.dofs.free] for modes in (true, before))
    turned = now.T @ (model.mass @ then[:, : len(factors)])
    expected = true.damping_ratio + turned**2 @ added / (2 * true.omega)
    assert np.abs(ratios / expected - 1).max() < 100 * error


def varied_deck(part: int, grid: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Return M and K (variant, vector, vector) with one uncertain part's log stiffness on a grid."""
    basis = Hypothesis(bridge_model()).basis
    K = basis.stiffness + (np.exp(grid) - 1)[:, None, None] * basis.parts[part]
    return np.repeat(basis.mass[None], len(grid), axis=0), K


@pytest.mark.parametrize("elements", [29, 57], ids=["left tower", "cable 57"])
def test_coordinates_keep_their_meaning_while_modes_mix(elements: int) -> None:
    parts = bridge_model().parts
    (part,) = (i for i, p in enumerate(parts) if p.quantity == "stiffness" and elements in p.elements)
    grid = np.linspace(-0.1, 0.1, 41)
    M, K = varied_deck(part, grid)
    T = aligned_modes(eigenmodes(M, K), MODES)
    assert np.abs(T.transpose(0, 2, 1) @ M @ T - np.eye(MODES)).max() < 1e-12  # rounding
    assert np.abs(T[20] - np.eye(len(M[0]))[:, :MODES]).max() < 1e-12  # as drawn: the modes themselves
    own = np.array([eigh(k, m)[1][:, :MODES] for m, k in zip(M, K, strict=True)])
    inside = T @ (T.transpose(0, 2, 1) @ M @ own)
    assert np.abs(inside - own).max() < 1e-10  # the same space as the lowest modes'
    own = own * np.sign(own[:, range(MODES), range(MODES)])[:, None]  # as smooth as signs can make them
    steps, mixed = (np.abs(np.diff(shapes, axis=0)).max(axis=(1, 2)) for shapes in (T, own))
    assert mixed[19:21].max() > 0.005  # modes 8 and 9 turn into one another, where the bridge is as drawn
    assert steps.max() < 2e-4  # of what a step of 0.5 % of a part may do
    assert steps.max() < 1.5 * steps.min()  # at one pace all along


def test_turned_modes_follow_the_nearly_equal_frequencies() -> None:
    omega, _ = bridge_model().modes
    first, last = omega[list(TWINS)] / (2 * np.pi)
    assert (first, last) == pytest.approx((20.007, 20.288), abs=1e-3)


@pytest.mark.parametrize(
    "effect", [StiffnessChange((2,), 0.3), AddedMass(3, 2.0), SupportSpring(4, "x", 0.5)], ids=lambda item: item.kind
)
def test_chain_is_taken_as_it_is(effect: Effect) -> None:
    nominal = nominal_model_of(CHAIN)
    candidate = chosen(candidates_of(CHAIN, nominal), effect)
    assert basis_of(nominal, (candidate,)).shapes is nominal.basis
    (amount,) = (value for value in effect.parameters.values() if isinstance(value, float))
    omega, _ = reduced_modes(nominal, candidate, amount)
    exact = natural_modes(linearise(four_dof().with_effects(effect)), 4).omega
    assert omega == pytest.approx(exact, rel=1e-10)  # rounding: nothing is left out
