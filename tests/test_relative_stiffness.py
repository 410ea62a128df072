"""Stiffnesses beside one another: what modes tell of them though a factor of all is a factor of all masses, too."""

import numpy as np

import fe_models as fe
from hybrid.diagnosis.modal.unsure_sizes import with_unsure_sizes
from hybrid.diagnosis.modes_and_motion.look import look_at
from hybrid.diagnosis.modes_and_motion.notes import note_on_ratios
from hybrid.diagnosis.modes_and_motion.relative_stiffness import relatively_off
from tests.test_modal_evidence import SENSORS, chain

ERROR = 1e-3  # of frequencies


def test_one_spring_of_five_is_stiffer_than_the_others_by_a_known_factor() -> None:
    """All are up by a fifth, the third by twice as much again; of that fifth nobody knows whether masses have it."""
    truth = chain(np.array([1.2, 1.2, 1.2 * 1.5, 1.2, 1.2]))
    modal = fe.natural_modes(truth)
    modes = tuple(
        fe.ModeEstimate("now", frequency, ERROR * frequency, None, None, shape, 0.01 * np.abs(shape).max())
        for frequency, shape in zip(modal.frequencies, modal.shapes.T, strict=True)
    )
    look = look_at(fe.Dataset(chain(), np.inf, SENSORS, (), modes=modes), lambda stage: None)
    fit = with_unsure_sizes(look.measured, look.drawn)
    (third,) = relatively_off(look.measured, fit)
    assert look.measured.nominal.parts[third.part].location == {"element": 3}
    assert abs(third.factor - 1.5) < 3 * third.error
    own = np.sqrt(fit.covariance[third.part, third.part])
    assert third.error / third.factor < 0.5 * own  # the ratio is known, the factor is not
    (note,) = note_on_ratios(look.measured, [third])
    assert f"element 3 {third.factor:.2f} +- " in note
