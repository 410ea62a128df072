"""What to measure next by the search by modes: entries of shapes at a further sensor."""

from dataclasses import replace

import numpy as np
import pytest

from fe_models.assembly import linearise
from fe_models.causes import AddedMass
from fe_models.modes import natural_modes
from fe_models.recordings import Dataset
from hybrid.diagnosis.modal.claim import Claim
from hybrid.diagnosis.modal.error_sizes import ErrorSizes
from hybrid.diagnosis.modal.evidence import ModalFit, Start, fit_claim
from hybrid.diagnosis.modal.measured_modes import MeasuredModes
from hybrid.diagnosis.modal.modal_data import ModalData
from hybrid.diagnosis.modal.mode_values import FREQUENCY, RATIO, shape_parts
from hybrid.diagnosis.next_measurement.by_modes import Shared, _entries, _offered, next_by_modes
from tests.test_modal_evidence import COUNT, SENSORS, chain, dataset, measured_of, modes_of, search_of

assert dataset  # a fixture

FEW = SENSORS[:2]
MASS = 1.5  # kg, where 2 kg are drawn


def fits_of(dataset: Dataset, *nodes: int) -> tuple[ModalData, list[ModalFit]]:
    """Return the modes that two sensors show of a chain with a mass at its end, and the claims of one at each node."""
    whole = modes_of(chain().with_effects(AddedMass(COUNT, MASS)), "before", np.random.default_rng(0))
    seen = [FREQUENCY, RATIO, *(part.start + sensor for part in shape_parts(COUNT) for sensor in range(len(FEW)))]
    covariance = whole.covariance[:, seen][:, :, seen]
    few = MeasuredModes("before", whole.log_omega, whole.ratios, whole.shapes[:, :2], covariance)
    every = measured_of(dataset, whole)
    measured = replace(every, sensors=FEW, recordings=(few,))
    candidates = {candidate.key: candidate for candidate in search_of(dataset, every).candidates}
    found = []
    for node in nodes:
        claim = Claim(measured.null.hypothesis.adding(candidates[f"added_mass {{'node': {node}}}"]), ((0,),))
        fit = fit_claim(measured, Start(claim, np.append(np.zeros(claim.hypothesis.nuisances), MASS), ErrorSizes()))
        assert fit is not None
        found.append(fit)
    return measured, found


def test_expected_entries_are_those_of_the_structure_that_is_claimed(dataset: Dataset) -> None:
    """Against natural modes by an independent solver, at the claim's own values; of displacements and accelerations."""
    measured, (fit,) = fits_of(dataset, COUNT)
    mass = float(fit.theta[-1])
    bare = replace(fit, theta=np.append(np.zeros(fit.nuisances), mass))
    shared = Shared.of([bare])
    shapes = natural_modes(linearise(chain().with_effects(AddedMass(COUNT, mass))), COUNT).shapes  # (node, mode)
    accelerometers = tuple(replace(sensor, name="new", quantity="acceleration") for sensor in SENSORS[2:])
    for added, sign in ((SENSORS[2:], 1.0), (accelerometers, -1.0)):
        entries = _entries(measured, bare, added, shared, 0)
        assert entries is not None
        for row, (mode, reference) in enumerate(zip(shared.mode[0], shared.reference, strict=True)):
            expected = sign * shapes[2:, mode] / shapes[reference, mode]
            np.testing.assert_allclose(entries.mean[row, 0], expected, rtol=1e-3)  # damping of 1 % turns s by 1e-2
            assert np.abs(entries.mean[row, 1]).max() < 0.03 * np.abs(expected).max()


def test_only_places_without_a_sensor_are_offered(dataset: Dataset) -> None:
    measured, _ = fits_of(dataset)
    assert [(sensor.node, sensor.quantity) for sensor in _offered(measured, FEW)] == [
        (node, "displacement") for node in (3, 4, 5)
    ]


def test_masses_at_neighbouring_nodes_are_told_by_a_sensor_between_them_and_the_end(dataset: Dataset) -> None:
    """Two sensors at the support hardly tell one place from the other; shapes bend where the mass is."""
    measured, fits = fits_of(dataset, 5, 4)
    found = next_by_modes(measured, fits, np.array([0.6, 0.4]), FEW)
    assert found is not None
    assert found.options
    assert found.options[0].measurement.node in (4, 5)
    assert found.options[0].probability > 0.7
    assert all(option.measurement.kind == "sensor" for option in found.options)
    assert next_by_modes(measured, fits, np.array([0.999, 0.001]), FEW) is None


def test_no_sensor_is_advised_where_one_is_held_out(dataset: Dataset) -> None:
    """And where none is left to add, no more is said of than was looked at."""
    measured, fits = fits_of(dataset, 5, 4)
    weights = np.array([0.6, 0.4])
    best = next_by_modes(measured, fits, weights, FEW)
    assert best is not None
    taken = best.options[0].measurement.node
    held_out = replace(SENSORS[taken - 1], name="apart", role="held_out")
    found = next_by_modes(measured, fits, weights, (*FEW, held_out))
    assert found is not None
    assert taken not in [option.measurement.node for option in found.options]
    none = next_by_modes(measured, fits, weights, SENSORS)
    assert none is not None
    assert none.options == ()
    assert none.sentences[-1].startswith("no added sensor tells the added mass at node 5 from ")


def test_nothing_wrong_leaves_nothing_to_measure(dataset: Dataset) -> None:
    measured, _ = fits_of(dataset)
    null = fit_claim(measured, Start(measured.null, np.zeros(len(measured.nominal.spread)), ErrorSizes()), 2)
    assert null is not None
    assert next_by_modes(measured, [null], np.ones(1), FEW) is None


@pytest.mark.parametrize("weight", [0.5, 0.8])
def test_probability_now_is_that_of_the_best_claim(dataset: Dataset, weight: float) -> None:
    measured, fits = fits_of(dataset, 5, 4)
    found = next_by_modes(measured, fits, np.array([weight, 1 - weight]), FEW)
    assert found is not None
    assert found.now == pytest.approx(weight)
