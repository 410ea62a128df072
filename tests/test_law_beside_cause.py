"""A force law with another cause at its very place is rather one thing that is not on the list."""

import numpy as np
import pytest

from fe_models.causes import AddedMass, Cause, CubicSpring, PointDamper
from fe_models.causes.candidate import Candidate, LawCandidate
from fe_models.causes.places import Motion
from fe_models.recordings import Dataset
from hybrid.diagnosis.modal.claim import Claim
from hybrid.diagnosis.modal.error_sizes import ErrorSizes
from hybrid.diagnosis.modal.evidence import ModalFit, Start, fit_claim
from hybrid.diagnosis.modal.modal_data import ModalData
from hybrid.diagnosis.modes_and_motion.modal_findings import depending_on, probability_of_two
from hybrid.diagnosis.nominal.candidates import all_candidates
from hybrid.diagnosis.outcome.findings import NOT_ON_THE_LIST
from tests.blind_results import HEAVY, WEAK_2, finding
from tests.test_modal_evidence import COUNT, chain, dataset, measured_of, modes_of

__all__ = ["dataset"]  # a fixture


@pytest.mark.parametrize(
    ("other", "node", "meets"), [(PointDamper, 2, True), (AddedMass, 2, True), (AddedMass, 4, False)]
)
def test_a_law_and_a_cause_seldom_meet(dataset: Dataset, other: type[Cause], node: int, meets: bool) -> None:
    measured = measured_of(dataset, modes_of(chain(), "r", np.random.default_rng(0)))
    moved = np.random.default_rng(1).standard_normal((50, COUNT)) @ measured.nominal.modes[1].T
    every = all_candidates(measured.nominal, dataset, Motion(moved, moved), tuple(range(COUNT)))

    def at(kind: str, place: int) -> Candidate:
        return next(one for one in every if one.kind == kind and one.location.get("node") == place)

    law, own = at(CubicSpring.kind, 2), at(other.kind, node)
    assert isinstance(law, LawCandidate)
    share = probability_of_two(measured, fitted(measured, own), law)
    assert share < 0.2 if meets else share == 1.0


def fitted(measured: ModalData, own: Candidate) -> ModalFit:
    claim = Claim(measured.null.hypothesis.adding(own), ((0,),))
    theta = np.append(np.zeros(len(measured.nominal.spread)), own.neutral)
    found = fit_claim(measured, Start(claim, theta, ErrorSizes()), 1, errors_too=False)
    assert found is not None
    return found


def test_what_hangs_on_something_else_gives_its_share_to_what_is_not_on_the_list() -> None:
    sure = finding(WEAK_2, 0.8, 0.0, 0.01, HEAVY)  # with a rival of 0.1
    found = depending_on(sure, 0.5)
    assert found.probability == pytest.approx(0.4)
    assert {own.kind: own.probability for own in found.alternatives} == pytest.approx(
        {HEAVY.kind: 0.05, NOT_ON_THE_LIST: 0.55}
    )
    assert depending_on(sure, 1.0) is sure
