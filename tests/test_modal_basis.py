"""A bridge much softer than its drawing: modes that the drawing has beyond the band are in it, and are followed."""

import numpy as np

from fe_models.assembly import linearise
from fe_models.built_in.bridge import bridge
from fe_models.modes import natural_modes
from fe_models.recordings import Dataset, Recording, Sensor
from fe_models.structure import Structure
from fe_models.uncertain_parts import uncertain_parts
from hybrid.diagnosis.modal.measured_modes import MeasuredModes
from hybrid.diagnosis.modal.modal_data import ModalData
from hybrid.diagnosis.modal.nominal_fit import NominalFit, null_fit
from hybrid.diagnosis.modes_and_motion.look import rebased
from hybrid.diagnosis.nominal.nominal_model import nominal_model_of

RATE, HIGHEST = 80.0, 30.0  # Hz
ERROR = 1e-3  # of frequencies, ratios over their size, and shapes' entries
FACTOR = 0.6  # of deck and towers: frequencies fall by a fifth
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


def modes_in_band(structure: Structure) -> MeasuredModes:
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
        "r", np.log(modal.omega[:count][seen]), ratio, shapes + 0j, np.tile(np.diag(variances), (seen.sum(), 1, 1))
    )


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
