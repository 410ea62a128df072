"""What is left of modes is told over the same modes, whichever of them a structure still has."""

from dataclasses import replace

import numpy as np

from fe_models.arrays import FloatArray
from fe_models.recordings import Dataset
from hybrid.diagnosis.modal.error_sizes import ErrorSizes
from hybrid.diagnosis.modal.evidence import ModalFit, Start, fit_claim
from hybrid.diagnosis.modal.misfit import misfit_of
from hybrid.diagnosis.modal.modal_data import ModalData
from hybrid.diagnosis.modal.nominal_fit import null_fit
from tests.test_modal_evidence import COUNT, chain, dataset, measured_of, modes_of

__all__ = ["dataset"]  # a fixture


def fitted(dataset: Dataset) -> tuple[ModalData, ModalFit]:
    measured = measured_of(dataset, modes_of(chain(), "r", np.random.default_rng(0)))
    found = fit_claim(measured, Start(measured.null, np.zeros(len(measured.nominal.spread)), ErrorSizes()))
    assert found is not None
    return measured, found


def softer(measured: ModalData, factor: float) -> FloatArray:
    """All springs times a factor, all else as drawn."""
    theta = -measured.offset.copy()
    for number, part in enumerate(measured.nominal.parts):
        theta[number] += np.log(factor) * (part.quantity == "stiffness")
    return theta


def test_modes_that_are_lost_are_left_in_the_misfit(dataset: Dataset) -> None:
    """Beyond 0.3 in the logarithm no frequency is paired: what is not paired is no better than what hardly is."""
    measured, best = fitted(dataset)
    near, hardly, none = (
        misfit_of(measured, replace(best, theta=softer(measured, factor)), best) for factor in (1.0, 0.6, 0.4)
    )
    own = misfit_of(measured, best, best)
    assert own < len(best.residual) * 1.5
    assert own < near * 1.01 < hardly
    assert np.isfinite(none)
    # every frequency off by a tenth at least, in units of 3e-4 and what recordings differ by, 3e-4 again
    assert none > COUNT * 0.1**2 / (2 * 3e-4**2)


def test_a_sensor_that_fails_takes_no_mode_along(dataset: Dataset) -> None:
    """The second sensor shows nothing, where the second mode moves most: over that entry no shape can be taken."""
    measured = measured_of(dataset, modes_of(chain(), "r", np.random.default_rng(0)))
    own = measured.recordings[0]
    most = int(np.argmax(np.abs(own.shapes[1])))
    shapes = own.shapes.copy()
    shapes[:, most] = 0.0
    found = null_fit(replace(measured, recordings=(replace(own, shapes=shapes),)))
    assert found is not None
    assert np.isfinite(found.evidence) and np.isfinite(found.residual).all()
    assert 1 not in found.pairs.measured
    assert len(found.pairs) >= 2
