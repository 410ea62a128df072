"""What is found of frames under known loads that were recorded behind a low-pass."""

import pytest

from fe_models.causes import StiffnessChange
from hybrid.diagnosis.outcome.verdict import Verdict
from hybrid.diagnosis.series_diagnosis import diagnose_series as diagnose
from tests.shaken_mast import recorded


@pytest.mark.slow
def test_nothing_is_wrong_with_a_mast_whose_fast_modes_a_shaker_keeps_ringing() -> None:
    """With cubic splines, and without the mode beyond the low-pass, a machine at 47.8 Hz was named (0.85)."""
    found = diagnose(recorded())
    assert found.verdict is Verdict.NOTHING_WRONG
    assert found.findings == ()


@pytest.mark.slow
def test_a_soft_element_is_named_under_a_shaker() -> None:
    found = diagnose(recorded(StiffnessChange((2,), 0.85)))
    (finding,) = found.findings
    assert (finding.cause.kind, finding.cause.location) == ("stiffness_change", {"element": 2})
    (size,) = finding.parameters.values()
    assert abs(size.value - 0.85) < 3 * size.std
    # near half the sampling rate a spline loses a quarter of a load: that much is left
    assert finding.probability > 0.8
    assert found.verdict is Verdict.EXPLAINED
