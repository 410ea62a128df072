"""The field's library for ambient vibration, pyOMA2, on the same recordings: the same modes and standard deviations."""

import numpy as np
import pytest

from benchmarks.shear_frame import frame_modes, frame_recording
from hybrid.identification.ambient_modes import identify_ambient_modes

ssi = pytest.importorskip("pyoma2.functions.ssi", reason="pyOMA2 is not installed: it comes with the extra 'dev'")

RATE, ROWS, ORDER, SEGMENTS = 20.0, 15, 10, 100


def test_pyoma2_finds_the_same_with_about_the_same_deviations() -> None:
    """Its unweighted covariance-driven identification at the true order, which ours finds by itself."""
    true = frame_modes().frequencies
    for seed in range(3):
        data = frame_recording(seed)
        ours = identify_ambient_modes([data], RATE, float(true[0]), RATE / 2).modes
        hankel, spread = ssi.build_hank(data.T, data.T, ROWS, "cov", True, SEGMENTS)
        observed, transition, output, _ = ssi.SSI_fast(hankel, ROWS, ORDER)
        found = ssi.SSI_poles(
            observed, transition, output, ORDER, 1 / RATE, HC=False, calc_unc=True, H=hankel, T=spread
        )
        frequencies, ratios, deviations = found[0][:, -1], found[1][:, -1], found[4][:, -1]
        kept = [int(np.nanargmin(np.abs(frequencies - f))) for f in true]
        apart = ours.frequencies - frequencies[kept]
        # two estimates of one recording are nearer to each other than two recordings are
        assert np.abs(apart / deviations[kept]).max() < 3
        assert np.abs(ours.ratios - ratios[kept]).max() < 0.005
        # weights of canonical variates make ours the smaller ones, if anything
        size = ours.frequency_errors / deviations[kept]
        assert 0.6 < np.exp(np.mean(np.log(size))) < 1.2
