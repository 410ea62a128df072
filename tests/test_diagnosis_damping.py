"""Uncertain damping ratios: what their factors add to C, with and without a cause that turns the modes."""

import numpy as np
import pytest
from scipy.linalg import eigh

from benchmarks.blind_cases import SENSORS as CHAIN_SENSORS
from benchmarks.blind_cases.bridge import SENSORS
from fe_models.arrays import FloatArray
from fe_models.built_in.bridge import bridge
from fe_models.built_in.four_dof import four_dof
from fe_models.causes import ModalDamping
from fe_models.causes.candidate import Candidate, SupportCandidate
from fe_models.causes.places import Motion
from fe_models.recordings import Dataset, Recording
from hybrid.diagnosis.nominal.candidates import all_candidates
from hybrid.diagnosis.nominal.nominal_model import NominalModel
from hybrid.diagnosis.nominal.structure_model import nominal_model_of
from hybrid.diagnosis.response.hypothesis import Hypothesis
from hybrid.diagnosis.response.reduced_model import ReducedModel

WHITE = np.random.default_rng(0).standard_normal((1, 200, 8))  # a nominal model only asks for sensors and rates
CHAIN = Dataset(four_dof(), 10.0, CHAIN_SENSORS, (Recording("r", WHITE[..., :5]),))
BRIDGE = Dataset(bridge(), 100.0, SENSORS, (Recording("r", WHITE),), 30.0)
MORE = 1.3  # times the first mode's damping ratio
LOST = 0.4  # of a spring's stiffness


def candidate(nominal: NominalModel, dataset: Dataset, kind: str, **where: object) -> Candidate:
    q = np.random.default_rng(1).standard_normal((2, 10, nominal.size))
    shapes = nominal.basis[:, : nominal.size]
    measured = tuple(i for i, sensor in enumerate(dataset.sensors) if sensor.role == "measured")
    found = all_candidates(nominal, dataset, Motion(q[0] @ shapes.T, q[1] @ shapes.T), measured)
    return next(c for c in found if c.kind == kind and where.items() <= c.location.items())


def reduced(hypothesis: Hypothesis, factor: float, *values: float, turning: float = -1.0) -> ReducedModel:
    """With a factor of the first mode's damping ratio, which stays or turns, and the candidates' parameters."""
    theta = np.concatenate([np.zeros(hypothesis.nuisances), values])
    theta[len(hypothesis.nominal.parts)] = np.log(factor)
    theta[hypothesis.nominal.values] = turning
    return hypothesis.reduced(theta[None])


def own_damping(found: ReducedModel) -> FloatArray:
    """2 xi omega (mode,)."""
    phi = eigh(found.stiffness[0], found.mass[0])[1]
    return np.einsum("di,de,ei->i", phi, found.damping[0], phi)


def test_damping_beyond_the_nominal_stays_where_a_cause_turns_the_modes() -> None:
    nominal = nominal_model_of(CHAIN)
    spring = Hypothesis(nominal, (candidate(nominal, CHAIN, "stiffness_change", element=2),))
    added = [
        reduced(h, MORE, *v).damping - reduced(h, 1.0, *v).damping
        for h, v in ((Hypothesis(nominal), ()), (spring, (LOST,)))
    ]
    usual = reduced(Hypothesis(nominal), 1.0)
    M, phi = usual.mass[0], eigh(usual.stiffness[0], usual.mass[0])[1][:, :1]
    wanted = (MORE - 1) * own_damping(usual)[0] * M @ phi @ phi.T @ M
    for found in added:
        np.testing.assert_allclose(found[0], wanted, atol=1e-12)  # rounding
    turned = eigh(reduced(spring, 1.0, LOST).stiffness[0], M)[1][:, 0]
    assert abs(turned @ M @ phi[:, 0]) < 0.999  # turned by 3 degrees, so the test can tell the two apart


@pytest.mark.parametrize(
    ("kind", "where", "amount"), [("stiffness_change", {"element": 2}, LOST), ("added_mass", {"node": 3}, 0.5)]
)
def test_damping_beyond_the_nominal_may_turn_with_the_modes_in_part_or_wholly(
    kind: str, where: dict[str, int], amount: float
) -> None:
    nominal = nominal_model_of(CHAIN)
    cause = Hypothesis(nominal, (candidate(nominal, CHAIN, kind, **where),))
    turning, half, staying = (reduced(cause, MORE, amount, turning=share).damping for share in (1.0, 0.0, -1.0))
    np.testing.assert_allclose(half, (turning + staying) / 2, atol=1e-12)  # rounding
    usual, more = (own_damping(reduced(cause, factor, amount, turning=1.0)) for factor in (1.0, MORE))
    np.testing.assert_allclose(more / usual, [MORE, 1, 1, 1])


def test_ratio_that_a_cause_replaces_is_what_it_says_whatever_the_factor() -> None:
    nominal = nominal_model_of(CHAIN)
    mode = Hypothesis(nominal, (candidate(nominal, CHAIN, "modal_damping", modes=[1]),))
    found = reduced(mode, MORE, 0.05)
    omega = np.sqrt(eigh(found.stiffness[0], found.mass[0], eigvals_only=True)[0])
    assert own_damping(found)[0] == pytest.approx(2 * 0.05 * omega)


def test_support_that_gives_way_has_its_own_modes_damped() -> None:
    nominal = nominal_model_of(BRIDGE)
    support = candidate(nominal, BRIDGE, "support_spring", node=7, direction="y")
    assert isinstance(support, SupportCandidate)
    loose = Hypothesis(nominal, (support,))
    values = (1 / 2e4,)  # m/N: so soft that a mode more comes into the band
    usual, more = (own_damping(reduced(loose, factor, *values)) for factor in (1.0, MORE))
    np.testing.assert_allclose(more / usual, [MORE] + [1.0] * (len(usual) - 1), rtol=1e-3)  # the basis has more modes


def test_no_search_ends_at_a_damping_that_no_effect_may_have() -> None:
    """Where nothing fits, more damping may always do a little better."""
    hypothesis = Hypothesis(nominal_model_of(CHAIN))
    most = hypothesis.adding(candidate(hypothesis.nominal, CHAIN, "modal_damping", modes=[1])).upper[-1]
    assert ModalDamping((1,), float(most)).faults(four_dof()) == []
