"""What frames of a user's own bring along: pins, cables' ends, coarse meshes, lone masses, sensors at inner nodes."""

from dataclasses import replace

import numpy as np
import pytest

from benchmarks.blind_cases import BlindConfig, blind_case
from fe_models.assembly import linearise
from fe_models.built_in.four_dof import four_dof
from fe_models.causes import AddedMass, SlackCable, StiffnessChange, SupportSpring
from fe_models.causes.candidate import SupportCandidate
from fe_models.errors import InputError
from fe_models.modes import natural_modes
from fe_models.recordings import Assumptions, Dataset, Recording, Sensor
from fe_models.sections import round_wire
from fe_models.simulation import FreeConfig, simulate_free
from fe_models.structure import Beam, Cable, Damping, PointMass, Spring, Structure, Support
from fe_models.uncertain_parts import uncertain_parts
from hybrid.diagnosis.contest.growing import fit_growing
from hybrid.diagnosis.contest.posterior import posterior_of
from hybrid.diagnosis.contest.setting import Setting, setting_of
from hybrid.diagnosis.fitting.least_squares import Fit, fit
from hybrid.diagnosis.next_measurement.measurements import possible_sensors
from hybrid.diagnosis.nominal.mesh_error import coarse_mesh
from hybrid.diagnosis.nominal.structure_model import nominal_model_of
from hybrid.diagnosis.outcome.verdict import Verdict
from hybrid.diagnosis.response.hypothesis import Hypothesis
from hybrid.diagnosis.screening.modal_scan import modal_scan
from hybrid.diagnosis.screening.screening import screen
from hybrid.diagnosis.series_diagnosis import diagnose_series as diagnose
from tests.frames import beam, gable, portal, vibrations
from tests.masts import TUBE, masts, recorded

ROPE = round_wire("rope", youngs_modulus=1.6e11, density=7850.0, diameter=0.005)


def bare_masts() -> Structure:
    """Masts without point masses: what moves with a node of their beams is a part of what the elements have there."""
    return replace(masts(), point_masses=())


def fitted(setting: Setting, hypothesis: Hypothesis) -> Fit:
    found = fit_growing(hypothesis, hypothesis.centre, setting.lengths, setting.searched)
    assert found is not None
    return found


@pytest.mark.slow
def test_pin_that_resists_rotation_is_named() -> None:
    stiffness = 2e5  # N m/rad, a third of E I over a storey's height
    given = recorded(portal().with_effects(SupportSpring(1, "rz", stiffness)))
    found = diagnose(replace(given, model=portal()))
    assert found.verdict is Verdict.EXPLAINED
    (finding,) = found.findings
    assert (finding.cause.kind, finding.cause.location) == ("support_spring", {"node": 1, "direction": "rz"})
    assert finding.parameters["stiffness"].value == pytest.approx(stiffness, rel=0.1)  # the contract's bound


def test_spring_that_a_pin_has_as_an_effect_may_be_softer_than_drawn() -> None:
    """Else a softer one was reported as a negative spring elsewhere and a softer element, together."""
    stiff = portal().with_effects(SupportSpring(1, "rz", 2e5))
    bounds = {
        c.location["node"]: c.lower
        for c in setting_of(recorded(stiff)).candidates()
        if c.kind == "support_spring" and c.location["direction"] == "rz" and not isinstance(c, SupportCandidate)
    }
    assert bounds == {1: (-2e5,), 4: (0.0,)}


@pytest.mark.slow
def test_what_one_sensor_cannot_distinguish_by_one_mode_is_all_reported() -> None:
    """A mass on top moves one frequency, as softer columns do. Supports that give way bring a mode of their own to each
    segment, which takes up noise: by that they were ahead, and what shares the mode's shape was given up.
    """
    frame = Structure(
        "portal",
        ((0.0, 0.0), (0.0, 3.0), (4.0, 3.0), (4.0, 0.0)),
        tuple(Beam((i, i + 1), TUBE) for i in (1, 2, 3)),
        (PointMass(2, 50.0),),
        supports=(Support(1, ("x", "y", "rz")), Support(4, ("x", "y"))),
        damping=Damping(modal_ratios=(0.01,)),
    )
    rng, modal = np.random.default_rng(3), natural_modes(linearise(frame), 1)
    shape = modal.shapes[modal.dofs.free, 0]
    start = rng.standard_normal((4, 1)) * 0.003 * shape / np.abs(shape).max()
    truth, config = frame.with_effects(AddedMass(2, 15.0)), FreeConfig(4.0, 100.0, 2.5e-4)
    sensor = Sensor("a", 2, "x", "acceleration", "m/s^2")
    clean = simulate_free(truth, start, 0 * start, config, progress=False).channel(2, "x", "acceleration")[..., None]
    data = clean + 0.05 * clean.std() * rng.standard_normal(clean.shape)
    recordings = tuple(Recording(f"r{i}", part[None], "test" if i == 3 else "train") for i, part in enumerate(data))
    found = diagnose(Dataset(frame, 100.0, (sensor,), recordings))
    (finding,) = found.findings
    reported = [(finding.cause.kind, finding.cause.location), *((a.kind, a.location) for a in finding.alternatives)]
    for wanted in (("added_mass", {"node": 2}), ("stiffness_change", {"element": 1})):
        assert wanted in reported
    assert finding.probability < 0.5


@pytest.mark.slow
def test_modes_of_a_support_gone_soft_keep_the_damping_ratios_of_their_numbers() -> None:
    """As in the extended structure. The matrix of the held structure's ratios damps another mode than that, which was
    mended by a negative damper.
    """
    stiffness = 5e4  # N/m: takes a quarter off the second natural frequency
    sensors = tuple(Sensor(f"y{node}", node, "y", "acceleration", "m/s^2") for node in (2, 3, 5))
    found = diagnose(vibrations(beam(), beam().with_effects(SupportSpring(7, "y", stiffness)), sensors, 2))
    assert found.verdict is Verdict.EXPLAINED
    (finding,) = found.findings
    assert (finding.cause.kind, finding.cause.location) == ("support_spring", {"node": 7, "direction": "y"})
    assert finding.parameters["stiffness"].value == pytest.approx(stiffness, rel=0.1)  # the contract's bound
    true = natural_modes(linearise(beam().with_effects(SupportSpring(7, "y", stiffness))), 2)
    extended = natural_modes(linearise(found.extended), 2)
    np.testing.assert_allclose(extended.damping_ratio, true.damping_ratio, rtol=0.03)  # its nominal ones are certain
    np.testing.assert_allclose(found.observations.observed.frequencies[:2], true.frequencies, rtol=2e-3)


@pytest.mark.slow
@pytest.mark.parametrize("stiffness", [2.5e5, 4e5])
def test_support_that_gives_a_little_is_distinguished_from_the_softer_element_beside_it(stiffness: float) -> None:
    """The mode that it brings hardly moves. Coordinates with a part of all modes do, and were charged for it: far more
    than what the element leaves, which was reported at 0.94.
    """
    sensors = tuple(Sensor(f"y{node}", node, "y", "acceleration", "m/s^2") for node in (2, 3, 5))
    found = diagnose(vibrations(beam(), beam().with_effects(SupportSpring(7, "y", stiffness)), sensors, 2))
    (finding,) = found.findings
    assert (finding.cause.kind, finding.cause.location) == ("support_spring", {"node": 7, "direction": "y"})
    assert finding.probability > 0.9


@pytest.mark.slow
def test_tie_that_loses_half_its_stiffness_between_recordings_is_named() -> None:
    """First steps from what all recordings share, which is neither of the two structures, led nowhere."""
    x3, x5 = (Sensor(f"x{node}", node, "x", "acceleration", "m/s^2") for node in (3, 5))
    sensors = (x3, Sensor("y4", 4, "y", "acceleration", "m/s^2"), x5)
    before, after = (
        vibrations(gable(), truth, sensors, 4) for truth in (gable(), gable().with_effects(StiffnessChange((7,), 0.5)))
    )
    found = diagnose(replace(before, recordings=(*before.recordings[:1], *after.recordings[1:])))
    assert found.verdict is Verdict.EXPLAINED
    (finding,) = found.findings
    assert (finding.cause.kind, finding.cause.location) == ("stiffness_change", {"element": 7})
    assert finding.parameters["factor"].value == pytest.approx(0.5, rel=0.1)  # the contract's bound
    assert finding.recordings == ("r1", "r2", "r3")


@pytest.mark.slow
@pytest.mark.parametrize("reversed_one", range(3))
def test_sensor_mounted_the_wrong_way_round_is_named(reversed_one: int) -> None:
    """What the others tell of it was tried beside a calibration that had gone far astray."""
    frame = replace(portal(), supports=tuple(Support(node, ("x", "y", "rz")) for node in (1, 4)))
    sensors = tuple(Sensor(f"a{node}", node, "x", "acceleration", "m/s^2") for node in (2, 3, 5))
    given = vibrations(frame, frame, sensors, 3)
    sign = np.where(np.arange(3) == reversed_one, -1.0, 1.0)
    found = diagnose(replace(given, recordings=tuple(replace(r, data=sign * r.data) for r in given.recordings)))
    assert found.verdict is Verdict.EXPLAINED
    (finding,) = found.findings
    assert (finding.cause.kind, finding.cause.location) == ("sensor_gain", {"sensor": sensors[reversed_one].name})
    assert finding.parameters["factor"].value == pytest.approx(-1, abs=0.03)
    true = natural_modes(linearise(frame), 3).frequencies
    np.testing.assert_allclose(found.observations.observed.frequencies[:3], true, rtol=5e-3)


@pytest.mark.slow
@pytest.mark.parametrize("ratios", [(0.01,), (0.01, 0.012), 0.01])
def test_modes_that_the_recordings_show_are_followed_whatever_the_simulation_keeps(
    ratios: float | tuple[float],
) -> None:
    """A simulation of fewer was called wrong in a stiffness: an element so soft that it brought the others."""
    count = len(ratios) if isinstance(ratios, tuple) else 2
    given = replace(recorded(portal()), assumptions=Assumptions(damping_ratio=ratios, modes=count))
    setting = setting_of(given)
    assert setting.nominal.size == 3
    assert setting.nominal.ratios[2] == (ratios[-1] if isinstance(ratios, tuple) else ratios)
    assert any(
        note.startswith(f"the simulation keeps {count} modes, and the recordings can show 3") for note in setting.notes
    )


@pytest.mark.slow
def test_a_cable_goes_slack_by_the_stiffness_that_the_structures_effects_give_it() -> None:
    sensors = tuple(Sensor(f"x{node}", node, "x", "displacement", "m") for node in (1, 2, 3, 4))
    rng, half = np.random.default_rng(2), StiffnessChange((3,), 0.5)
    drawn = four_dof()
    third = drawn.elements[2]
    assert isinstance(third, Spring)
    softer = replace(third, stiffness=third.stiffness / 2)
    truth = replace(drawn, elements=(*drawn.elements[:2], softer, drawn.elements[3])).with_effects(SlackCable(3, 1.0))
    position, velocity = rng.standard_normal((2, 4, 4))
    motion = simulate_free(truth, position, velocity, FreeConfig(20.0, 10.0), progress=False)
    data = np.stack([motion.channel(s.node, "x", "displacement") for s in sensors], axis=-1)
    data = data + 0.02 * data.std(axis=(0, 1)) * rng.standard_normal(data.shape)
    recordings = tuple(Recording(f"r{i}", part[None], "test" if i == 3 else "train") for i, part in enumerate(data))
    (finding,) = diagnose(Dataset(drawn.with_effects(half), 10.0, sensors, recordings)).findings
    assert (finding.cause.kind, finding.cause.location) == ("slack_cable", {"element": 3})
    assert finding.parameters["pretension"].value == pytest.approx(1.0, rel=0.1)  # the contract's bound


def test_nodes_of_a_chain_that_have_no_mass_are_refused() -> None:
    light = replace(four_dof(), point_masses=tuple(m for m in four_dof().point_masses if m.node != 2))
    sensors = (Sensor("x1", 1, "x", "displacement", "m"),)
    with pytest.raises(InputError, match="node 2 has no mass"):
        nominal_model_of(Dataset(light, 10.0, sensors, (Recording("r", np.ones((1, 100, 1))),)))


def test_end_of_a_cable_that_is_held_from_turning_is_no_support_that_gives() -> None:
    guyed = portal()
    anchor = len(guyed.nodes) + 1
    guyed = replace(
        guyed,
        nodes=(*guyed.nodes, (-4.0, 0.0)),
        elements=(*guyed.elements, Cable((anchor, 3), ROPE, 1e3)),
        supports=(*guyed.supports, Support(anchor, ("x", "y", "rz"))),
    )
    held = {
        c.location["direction"]
        for c in setting_of(recorded(guyed)).candidates()
        if c.kind == "support_spring" and c.location["node"] == anchor
    }
    assert held == {"x", "y"}


@pytest.mark.slow
def test_no_more_mass_is_taken_off_a_node_than_moves_with_it() -> None:
    """M - m e e' has mass in every motion while m < 1 / (e' M^-1 e)."""
    setting = setting_of(recorded(bare_masts(), step=1e-4))
    taken = next(c for c in setting.candidates() if c.kind == "added_mass" and c.location == {"node": 2})
    hypothesis = setting.nominal_hypothesis.adding(taken)
    (change,) = hypothesis.basis.changes
    assert change is not None
    rows = np.linalg.eigh(change[0])  # two directions
    moved = rows.eigenvectors[:, -2:] * np.sqrt(rows.eigenvalues[-2:])
    most = 1 / np.linalg.eigvalsh(moved.T @ np.linalg.inv(hypothesis.basis.mass) @ moved)[-1]
    thetas = np.repeat(hypothesis.centre[None], 2, axis=0)
    thetas[:, -1] = -0.99 * most, -1.01 * most
    assert hypothesis.weighs(thetas).tolist() == [True, False]
    assert -1.01 * most > taken.lower[0]  # so that the search would try it


@pytest.mark.slow
def test_nothing_is_reported_of_a_cause_whose_shapes_have_no_mass_left() -> None:
    """A fit may have taken off as much as its own shapes bear; those that another cause adds bear less."""
    setting = setting_of(blind_case(1, BlindConfig(train=2, duration=3.0, structure="bridge", rich=False)).dataset)
    causes = {(c.kind, str(c.location)): c for c in setting.candidates()}
    taken, force = (causes[key] for key in (("added_mass", "{'node': 54}"), ("axial_force", "{'elements': [52]}")))
    hypothesis = setting.nominal_hypothesis.adding(taken)
    thetas = np.repeat(hypothesis.centre[None], 1000, axis=0)
    thetas[
        :, [i for i, part in enumerate(setting.nominal.parts) if part.quantity == "mass"]
    ] = -0.1  # and lighter beams
    thetas[:, -1] = np.linspace(taken.lower[0], 0, 1000)
    borne = hypothesis.weighs(thetas) & ~hypothesis.adding(force).weighs(np.pad(thetas, ((0, 0), (0, 1))))
    start = setting.short
    begun = fit(hypothesis, thetas[borne][0], start.batches, setting.searched, start.states, iterations=0)
    assert begun is not None
    assert [trial.gain for trial in screen(begun, (force,), setting.searched)] == [0.0]


@pytest.mark.slow
def test_modes_are_scanned_where_hardly_any_mass_can_be_taken_off() -> None:
    setting = setting_of(recorded(bare_masts(), step=1e-4))
    item = fitted(setting, setting.nominal_hypothesis)
    found = modal_scan(item, setting.candidates(), setting.searched, item)
    assert any(trial.candidate.kind == "added_mass" for trial in found)
    assert np.isfinite([trial.gain for trial in found]).all()


@pytest.mark.slow
@pytest.mark.parametrize("soft", [False, True])
def test_support_is_a_hypothesis_only_where_it_is_distinguished_from_a_rigid_one(soft: bool) -> None:
    spring = (SupportSpring(1, "rz", 5e6),) if soft else ()
    setting = setting_of(replace(recorded(masts().with_effects(*spring)), model=masts()))
    foot = {"node": 1, "direction": "rz"}
    gives = next(c for c in setting.candidates() if c.kind == "support_spring" and c.location == foot)
    hypothesis = setting.nominal_hypothesis.adding(gives)
    theta = hypothesis.centre
    theta[-1] = gives.first_starts[0][0]
    item = fit_growing(hypothesis, theta, setting.lengths, setting.searched)
    assert item is not None
    kept = posterior_of((fitted(setting, setting.nominal_hypothesis), item), setting.candidates()).fits
    assert (item in kept) is soft


def test_coarse_mesh_is_reported_with_one_that_is_fine_enough() -> None:
    dataset = recorded(bare_masts(), step=1e-4)
    coarse = nominal_model_of(dataset)
    all_moved = np.ones(coarse.size, dtype=bool)
    (note,) = coarse_mesh(coarse, all_moved)
    assert coarse_mesh(coarse, ~all_moved) == []
    enough = int(note.split("divisions = ")[1].split()[0])
    fine = nominal_model_of(replace(dataset, model=bare_masts().refined(enough)))
    assert coarse_mesh(fine, all_moved) == []
    assert coarse_mesh(nominal_model_of(replace(dataset, model=masts().refined(8))), all_moved) == []


def test_bars_of_a_group_with_a_name_are_off_together_and_cables_without_one_each_by_itself() -> None:
    braces = tuple(Cable(pair, ROPE, tension_only=False, group="braces") for pair in ((1, 6), (4, 3)))
    guys = (Cable((2, 6), ROPE), Cable((5, 3), ROPE))
    braced = replace(portal(), elements=(*portal().elements, *braces, *guys))
    stiffnesses = [part for part in uncertain_parts(braced) if part.quantity == "stiffness"]
    assert [part.elements for part in stiffnesses] == [(1, 2, 3, 4, 5), (6, 7), (8,), (9,)]
    stiffer = stiffnesses[1].scaled(braced, 1.1).elements
    assert isinstance(stiffer[5], Cable)
    assert isinstance(stiffer[7], Cable)
    assert stiffer[5].section.youngs_modulus == pytest.approx(1.1 * ROPE.youngs_modulus)
    assert stiffer[7].section == ROPE


def test_lone_mass_is_uncertain_by_itself_and_masses_along_beams_with_them() -> None:
    head = replace(masts(), point_masses=(PointMass(3, 80.0),))
    masses = [part for part in uncertain_parts(head) if part.quantity == "mass"]
    assert [(part.elements, part.nodes) for part in masses] == [((1, 2, 3, 4), ()), ((), (3,))]
    (along,) = [part for part in uncertain_parts(masts()) if part.quantity == "mass"]
    assert along.nodes == (2, 3, 5, 6)


def test_sensors_are_offered_at_nodes_that_the_user_has() -> None:
    dataset = replace(recorded(masts()), model=masts().refined(3))
    nodes = {sensor.node for sensor in possible_sensors(nominal_model_of(dataset), ())}
    assert nodes == {2, 3, 5, 6}


@pytest.mark.parametrize("law", [False, True])
def test_motion_that_no_sensor_feels_stays_at_rest(law: bool) -> None:
    """Masts on springs bounce, of which sensors across show 1e-15: rounding.

    Free vibrations do not distinguish masses and stiffnesses all off alike; the prior alone does.
    """
    springs = tuple(Spring((node,), "y", 2e6) for node in (1, 4))  # N/m: they bounce at 11 Hz
    supports = tuple(Support(node, ("x", "rz")) for node in (1, 4))
    bouncing = replace(masts(), elements=(*masts().elements, *springs), supports=supports)
    setting = setting_of(replace(recorded(bouncing), assumptions=Assumptions(damping_ratio=0.01)))
    hypothesis, plain = setting.nominal_hypothesis, fitted(setting, setting.nominal_hypothesis)
    theta, states = hypothesis.centre, plain.states
    if law:
        across = (c for c in setting.candidates() if c.kind == "cubic_spring" and c.location["direction"] == "x")
        hypothesis = hypothesis.adding(next(across))
        theta = np.append(theta, hypothesis.candidates[0].first_starts[0])
    item = fit(hypothesis, theta, setting.lengths.whole, setting.searched, states)
    assert item is not None
    moved = np.abs(np.concatenate(item.states)[:, : hypothesis.size]).max(axis=0)
    assert np.sum(moved < 1e-9 * moved.max()) == len(springs)
    alike = np.zeros(len(item.theta))
    alike[: len(setting.nominal.parts)] = 1.0
    reported = alike @ np.linalg.solve(item.covariance, alike)
    assert reported == pytest.approx(alike @ (hypothesis.precision * alike), rel=0.1)  # differences leave a hundredth
