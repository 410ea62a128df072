"""Blind cases that are far from their drawing, and causes that act in one training recording alone."""

import json
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from scipy.stats import ks_2samp

from benchmarks.blind.cases import NOTHING, default_words
from benchmarks.blind_cases import FAR_KINDS, Acts, BlindCase, BlindConfig, blind_case, save_case
from benchmarks.blind_cases.far import SPREADS, Spread, far_from
from fe_models.arrays import FloatArray
from fe_models.built_in.bridge import bridge
from fe_models.built_in.four_dof import four_dof
from fe_models.errors import InputError
from fe_models.recordings import Uncertainty
from fe_models.structure import Beam, Cable, Spring
from hybrid.diagnosis.modes_and_motion.modal_diagnosis import diagnose_modes

CHAIN = BlindConfig(train=3, test=2, duration=15.0)
BRIDGE = BlindConfig(structure="bridge", rich=False, train=2, test=1, duration=1.0)


ACTS: tuple[Acts, ...] = ("all", "one")


def recordings(case: BlindCase) -> FloatArray:
    return np.concatenate([recording.data for recording in case.dataset.recordings])


@pytest.mark.parametrize("spread", SPREADS.values(), ids=SPREADS.keys())
def test_draws_are_truncated(spread: Spread) -> None:
    """As a normal distribution is of which what lies beyond the ends is drawn again."""
    rng = np.random.default_rng(1)
    drawn, normal = spread.draw(20_000, rng), 1 + spread.std * rng.standard_normal(20_000)
    assert spread.least <= drawn.min()
    assert drawn.max() <= spread.most
    kept = normal[(normal >= spread.least) & (normal <= spread.most)]
    assert ks_2samp(drawn, kept).pvalue > 0.01


def test_deck_towers_and_pairs_of_cables_are_off_as_wholes() -> None:
    design = bridge().without_prestress()
    far = far_from(design, np.random.default_rng(3))
    stiffness, density = (
        np.array([getattr(b.section, word) / getattr(a.section, word) for a, b in both])
        for word in ("youngs_modulus", "density")
        if (both := _sectioned(design.elements, far.structure.elements))
    )
    groups = [range(1, 29), range(29, 41), range(41, 53), (53, 60), (54, 59), (55, 58), (56, 57)]
    for values in (stiffness, density[:52]):
        for numbers in groups:
            chosen = [values[number - 1] for number in numbers if number <= len(values)]
            np.testing.assert_allclose(chosen, chosen[0] if chosen else 1.0, rtol=1e-12)
    assert len({round(float(value), 9) for value in stiffness}) == len(groups)
    np.testing.assert_array_equal(density[52:], 1.0)  # wires: nothing feels their mass
    masses = [b.mass / a.mass for a, b in zip(design.point_masses, far.structure.point_masses, strict=True)]
    np.testing.assert_allclose(masses[:29], density[0], rtol=1e-12)  # those along the deck
    told = {(item.what, next(iter(item.location.values()))[0]): item.factor for item in far.factors}
    for numbers in groups:
        assert told["stiffness", numbers[0]] == pytest.approx(stiffness[numbers[0] - 1], rel=1e-12)
    for numbers in groups[:3]:
        assert told["mass", numbers[0]] == pytest.approx(density[numbers[0] - 1], rel=1e-12)
    assert [item.factor for item in far.factors if item.what == "damping"] == far.ratios.tolist()
    assert 0.3 <= far.ratios.min() < 0.7  # of 153 modes


def _sectioned(drawn: object, built: object) -> list[tuple[Beam | Cable, Beam | Cable]]:
    assert isinstance(drawn, tuple)
    assert isinstance(built, tuple)
    return [(a, b) for a, b in zip(drawn, built, strict=True) if not isinstance(a, Spring)]


def test_every_spring_and_mass_of_a_chain_is_off() -> None:
    design = four_dof()
    far = far_from(design, np.random.default_rng(3))
    springs = [b.stiffness / a.stiffness for a, b in zip(design.elements, far.structure.elements, strict=True)]  # type: ignore[union-attr]
    masses = [b.mass / a.mass for a, b in zip(design.point_masses, far.structure.point_masses, strict=True)]
    told = {what: [item.factor for item in far.factors if item.what == what] for what in ("stiffness", "mass")}
    np.testing.assert_allclose(told["stiffness"], springs)
    np.testing.assert_allclose(told["mass"], masses)
    assert len(far.ratios) == 4
    assert np.ptp(springs) > 0.1


@pytest.mark.parametrize(
    ("structure", "count"),
    [(CHAIN, 5), (BRIDGE, 3), pytest.param(BRIDGE, 20, marks=pytest.mark.slow)],
)
def test_no_motion_explodes(structure: BlindConfig, count: int) -> None:
    """In none of the cases does anything grow: with modes that are damped and a mass that is positive nothing can."""
    for seed in range(count):
        kind = FAR_KINDS[seed % 3]  # an axial force is the bridge's alone
        config = replace(structure, kinds=(kind,), tier="far", size=1.0, noise=0.0, train=1, test=1)
        data = recordings(blind_case(seed, replace(config, duration=3 * structure.campaign.duration)))
        assert np.isfinite(data).all()
        early, late = (np.abs(part).max() for part in np.array_split(data, 2, axis=1))
        assert late < 2 * early  # beats may gather a motion once more


@pytest.mark.parametrize("structure", [BRIDGE, CHAIN], ids=lambda config: config.structure)
def test_a_cause_in_one_recording_changes_the_last_for_training_alone(structure: BlindConfig) -> None:
    config = replace(structure, kinds=("added_mass",), tier="far", size=1.0, noise=0.0, acts="one")
    train = config.campaign.train
    case = blind_case(4, config)
    assert case.recordings == (f"r{train:02d}",)
    everywhere = blind_case(4, replace(config, acts="all"))
    before = blind_case(4, replace(config, acts="all", changed=train))  # no training recording has it, all others have
    assert case.truth == everywhere.truth == before.truth
    assert case.factors == everywhere.factors
    own, everywhere_data, without = recordings(case), recordings(everywhere), recordings(before)
    size = own.std()
    np.testing.assert_allclose(own[: train - 1], without[: train - 1], rtol=0, atol=1e-9 * size)
    np.testing.assert_allclose(own[train - 1], everywhere_data[train - 1], rtol=0, atol=1e-9 * size)
    for number in range(config.campaign.count):
        told = np.abs(own[number] - (without if number == train - 1 else everywhere_data)[number]).max()
        assert told > 0.1 * size, number


def test_noise_is_the_same_whatever_acts_where() -> None:
    config = replace(CHAIN, kinds=("stiffness_change",), tier="far", size=1.0)
    noise = []
    for acts in ACTS:
        noisy, clean = (recordings(blind_case(4, replace(config, acts=acts, noise=share))) for share in (0.03, 0.0))
        noise.append((noisy - clean) / clean.std(axis=(0, 1)))
    np.testing.assert_allclose(noise[0], noise[1], rtol=0, atol=1e-9)


def test_a_sensor_fault_in_one_recording() -> None:
    config = replace(CHAIN, kinds=("sensor_gain",), size=1.0, noise=0.0, acts="one")
    everywhere, own = (recordings(blind_case(4, replace(config, acts=acts))) for acts in ACTS)
    assert [bool((a != b).any()) for a, b in zip(own, everywhere, strict=True)] == [True, True, False, True, True]


@pytest.mark.parametrize("structure", [BRIDGE, CHAIN], ids=lambda config: config.structure)
def test_seeds_reproduce_and_the_dataset_states_what_is_usual(structure: BlindConfig) -> None:
    config = replace(structure, kinds=("support_spring",), tier="far")
    first, again, other = (blind_case(seed, config) for seed in (5, 5, 6))
    np.testing.assert_array_equal(recordings(first), recordings(again))
    assert (first.truth, first.factors) == (again.truth, again.factors)
    assert all(a.factor != b.factor for a, b in zip(first.factors, other.factors, strict=True))
    assert first.dataset.assumptions.uncertainty == Uncertainty(0.01, 0.01, 0.1)
    assert first.dataset.model == (bridge() if config.structure == "bridge" else four_dof())


def test_true_factors_are_saved_with_the_truth(tmp_path: Path) -> None:
    case = blind_case(5, replace(CHAIN, tier="far"))
    save_case(case, tmp_path)
    told = json.loads((tmp_path / "truth.json").read_text())["factors"]
    assert told[0] == {"what": "stiffness", "location": {"element": 1}, "factor": case.factors[0].factor}
    assert [item["what"] for item in told] == ["stiffness"] * 4 + ["mass"] * 4 + ["damping"] * 4
    assert blind_case(5, CHAIN).factors == ()


def test_what_cannot_act_in_one_recording_is_refused() -> None:
    with pytest.raises(InputError) as caught:
        blind_case(0, replace(CHAIN, kinds=("time_integration",), acts="one", changed=1))
    begun, shared = caught.value.faults
    assert begun.startswith("changed = 1: what acts in one recording has no beginning")
    assert shared.startswith("time_integration is in the simulation")
    with pytest.raises(InputError, match="train = 0: nothing can act in the last training recording"):
        blind_case(0, replace(CHAIN, train=0, acts="one"))


def test_far_cases_hide_linear_kinds_by_default() -> None:
    assert default_words(replace(BRIDGE, tier="far")) == FAR_KINDS
    assert default_words(replace(CHAIN, tier="far")) == FAR_KINDS[:3]
    exact, one = (set(default_words(replace(CHAIN, acts=acts))) for acts in ACTS)
    assert exact - one == {"time_integration"}
    assert NOTHING in one


@pytest.mark.slow
@pytest.mark.parametrize(
    ("seed", "kind", "location"),
    [
        (1792000, "stiffness_change", {"element": 48}),  # a tower that lost most of itself: modes change places
        (1790001, "added_mass", {"node": 42}),  # of which a scan promises a third of what it gains
    ],
)
def test_a_cause_that_scans_hardly_promise_is_found_far_from_the_drawing(
    seed: int, kind: str, location: dict[str, object]
) -> None:
    """Of those that the modes tell by 30 nats and more: nothing that the search may miss."""
    case = blind_case(seed, BlindConfig((kind,), structure="bridge", tier="far"))
    found = diagnose_modes(case.dataset)
    first = found.findings[0]
    assert (first.cause.kind, first.cause.location) == (kind, location)
    assert first.probability > 0.5
