"""The modes of a bridge: those that come into the band where it is much softer, and what a support that gives does."""

import numpy as np
import pytest

from fe_models.assembly import linearise
from fe_models.built_in.bridge import bridge
from fe_models.causes import StiffnessChange, SupportSpring
from fe_models.causes.candidate import SupportCandidate
from fe_models.causes.places import Motion
from fe_models.modes import natural_modes
from fe_models.recordings import Dataset, Recording, Sensor
from fe_models.structure import Structure
from fe_models.uncertain_parts import uncertain_parts
from hybrid.diagnosis.modal.evidence import with_errors
from hybrid.diagnosis.modal.measured_modes import MeasuredModes
from hybrid.diagnosis.modal.modal_data import ModalData
from hybrid.diagnosis.modal.nominal_fit import NominalFit, null_fit
from hybrid.diagnosis.modal.scan import scan_claims
from hybrid.diagnosis.modes_and_motion.look import rebased
from hybrid.diagnosis.nominal.candidates import all_candidates
from hybrid.diagnosis.nominal.structure_model import nominal_model_of

RATE, HIGHEST = 80.0, 30.0  # Hz
ERROR = 1e-3  # of frequencies, ratios over their size, and shapes' entries
FACTOR = 0.6  # of deck and towers: frequencies fall by a fifth
GIVING = 23  # the node of a roller, which gives
SMALL = 0.01  # of the prior standard deviation of its compliance: a twentieth of the bridge's own there
NODES = (3, 6, 9, 13, 17, 20, 24, 27)
SENSORS = tuple(Sensor(f"y{node}", node, "y", "displacement", "m") for node in NODES)


def drawn() -> Structure:
    """Return the bridge as drawn, without weight."""
    return bridge().without_prestress()


def softer() -> Structure:
    """Return the bridge with softer beams."""
    built = drawn()
    for part in uncertain_parts(built):
        if part.quantity == "stiffness" and len(part.elements) > 1:
            built = part.scaled(built, FACTOR)
    return built


def modes_in_band(structure: Structure, name: str = "r") -> MeasuredModes:
    """Return the modes below the highest frequency, as an identification with small errors gives them."""
    modal = natural_modes(linearise(structure), 20)
    count = int(np.sum(modal.frequencies < HIGHEST))
    rows = [modal.dofs.row(node, "y") for node in NODES]
    shapes = modal.shapes[rows, :count].T
    seen = np.abs(shapes).max(axis=1) > 0.1 * np.abs(modal.shapes[:, :count]).max(axis=0)  # not the towers' own
    shapes = shapes[seen] / np.abs(shapes[seen]).max(axis=1, keepdims=True)
    ratio = modal.damping_ratio[:count][seen]
    variances = [ERROR**2, (ERROR * float(ratio.max())) ** 2, *[ERROR**2] * (2 * len(SENSORS))]
    return MeasuredModes(
        name, np.log(modal.omega[:count][seen]), ratio, shapes + 0j, np.tile(np.diag(variances), (seen.sum(), 1, 1))
    )


@pytest.mark.slow
def test_modes_that_a_drawing_has_beyond_the_band_are_followed() -> None:
    still = np.random.default_rng(0).standard_normal((1, 400, len(SENSORS)))
    dataset = Dataset(drawn(), RATE, SENSORS, (Recording("r", still),), lowpass=HIGHEST)
    nominal, modes = nominal_model_of(dataset).undispersed, modes_in_band(softer())
    measured = ModalData(nominal, np.zeros(len(nominal.spread)), SENSORS, RATE, (modes,))
    null = null_fit(measured)
    assert null is not None
    found = rebased(dataset, NominalFit(measured, null))
    assert found.measured.nominal.size > nominal.size
    assert len(found.fit.pairs) == modes.count


@pytest.mark.slow
def test_a_support_that_gives_a_little_in_one_recording_is_what_its_modes_ask_for_first() -> None:
    still = np.random.default_rng(0).standard_normal((1, 400, len(SENSORS)))
    recordings = (Recording("before", still), Recording("after", still))
    dataset = Dataset(drawn(), RATE, SENSORS, recordings, lowpass=HIGHEST)
    nominal = nominal_model_of(dataset).undispersed
    moved = np.random.default_rng(1).standard_normal((50, nominal.size))
    omega, shapes = nominal.modes
    candidates = all_candidates(nominal, dataset, Motion((moved / omega) @ shapes.T, moved @ shapes.T), (0,))
    supports = [own for own in candidates if isinstance(own, SupportCandidate) and own.location["direction"] == "y"]
    (right,) = (own for own in supports if own.location["node"] == GIVING)
    compliance = SMALL * right.width[0]
    structures = (drawn(), drawn().with_effects(SupportSpring(GIVING, "y", 1 / compliance)))
    modes = tuple(modes_in_band(own, item.name) for own, item in zip(structures, recordings, strict=True))
    measured = ModalData(nominal, np.zeros(len(nominal.spread)), SENSORS, RATE, modes)
    null = null_fit(measured)
    assert null is not None
    rivals = [own for own in candidates if own.kind in (SupportSpring.kind, StiffnessChange.kind)]
    first = scan_claims(measured, with_errors(measured, null, null.sizes.as_usual), rivals, [(0,), (1,), (0, 1)])[0]
    assert (first.candidate.key, first.acts) == (right.key, (1,))
    assert first.size == pytest.approx(compliance, rel=0.5)  # one step of least squares, its effect saturates
