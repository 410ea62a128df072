"""Channels as sums of exponentials, and their slopes, against central differences and against samples."""

from dataclasses import replace
from functools import cache
from typing import Literal

import numpy as np
import pytest
from scipy.linalg import expm

from benchmarks.blind_cases import BlindConfig, blind_case
from fe_models.arrays import FloatArray
from fe_models.causes.candidate import HarmonicCandidate
from fe_models.lowpass import LowPass
from hybrid.diagnosis.contest.setting import Setting, setting_of
from hybrid.diagnosis.fitting.linearisation import Linearisation, linearise_batch
from hybrid.diagnosis.recorded.batches import Batch
from hybrid.diagnosis.response.exponentials import Exponentials, exponentials
from hybrid.diagnosis.response.hypothesis import Hypothesis
from hybrid.diagnosis.response.system import System, linear_channels

STEP, SAMPLES = 0.02, 300
KINDS = ["stiffness_change", "added_mass", "support_spring", "modal_damping", "harmonic_force"]
KINDS += ["sensor_gain", "sensor_delay", "sensor_drift"]


def oscillators(omega: list[float], ratio: list[float]) -> FloatArray:
    """Return A (state, state) of oscillators that do not couple."""
    n, w, xi = len(omega), np.array(omega), np.array(ratio)
    return np.block([[np.zeros((n, n)), np.eye(n)], [-np.diag(w**2), -np.diag(2 * xi * w)]])


APART = oscillators([3.0, 7.5, 20.0], [0.01, 0.05, 0.02])
EQUAL = oscillators([3.0, 3.0, 20.0], [0.02, 0.02, 0.02])  # roots in pairs, each with eigenvectors of its own
SLOW = oscillators([0.0, 1.0, 20.0], [0.0, 2.0, 0.02])  # moved freely by a change of stiffness, and two real roots
SLOW[3, 0], SLOW[3, 3] = -0.5, -1e-3


def system_of(A: FloatArray, size: float = 0.0, lowpass: LowPass | None = None) -> System:
    """Return a system whose matrices, gains and delays are so far off, each in a direction of its own."""
    rng = np.random.default_rng(3)
    dA, dC = rng.standard_normal(A.shape), rng.standard_normal((2, 6))
    dA[:3] = 0.0  # velocities stay velocities
    C = rng.standard_normal((2, 6)) + size * dC
    gain, delay = 1.0 + size * np.array([[0.0, 0.3]]), 0.01 + size * np.array([[0.02, 0.0]])
    nothing = np.zeros((1, 2))
    none = np.zeros((1, 6, 0)), np.zeros((1, 2, 0)), np.zeros((1, 0, 6))
    return System(
        (A + size * dA)[None], none[0], C[None], none[1], none[2], (), gain, delay, nothing, STEP, None, None, lowpass
    )


def both(A: FloatArray, size: float, lowpass: LowPass | None) -> System:
    """Return the system and, as a second variant, the one that is so far off."""
    first, second = system_of(A, 0.0, lowpass), system_of(A, size, lowpass)
    A, B, C, D, G, gain, delay = (
        np.concatenate([getattr(first, name), getattr(second, name)])
        for name in ("A", "B", "C", "D", "G", "gain", "delay")
    )
    slope = np.array([[0.0, 0.0], [0.0, 0.5 * size]])
    return replace(first, A=A, B=B, C=C, D=D, G=G, gain=gain, delay=delay, slope=slope)


def found(system: System) -> Exponentials:
    item = exponentials(system)
    assert item is not None
    return item


@pytest.mark.parametrize("A", [APART, EQUAL, SLOW], ids=["apart", "equal roots", "real roots"])
def test_exponentials_are_the_motion(A: FloatArray) -> None:
    item = found(replace(system_of(A), delay=np.zeros((1, 2))))
    y = np.einsum("tf,fsn->tsn", item.table(SAMPLES), item.of_states())
    C = item.system.C[0]
    exact = np.stack([C @ expm(A * STEP * k) for k in range(SAMPLES)])
    assert np.abs(y - exact).max() < 1e-10 * np.abs(exact).max()  # rounding, over 120 radians


@pytest.mark.parametrize("lowpass", [None, LowPass(4.0)], ids=["plain", "low-pass"])
@pytest.mark.parametrize("A", [APART, EQUAL, SLOW], ids=["apart", "equal roots", "real roots"])
def test_slopes_are_what_differences_tend_to(A: FloatArray, lowpass: LowPass | None) -> None:
    z = np.random.default_rng(1).standard_normal((2, 6))
    size = 1e-6
    item = found(both(A, size, lowpass))
    coefficients = item.changes(z, np.array([size]))[:, 0]  # (function, recording, sensor)
    slopes = np.einsum("tf,frs->rts", item.table(SAMPLES), coefficients)
    drift = 0.5 * STEP * np.arange(SAMPLES)  # of the second sensor
    errors = []
    for h in (1e-3, 1e-4):
        ahead, back = (linear_channels(system_of(A, side * h, lowpass), z[None], SAMPLES)[0] for side in (1, -1))
        central = (ahead - back) / (2 * h)
        central[..., 1] += drift
        errors.append(np.abs(slopes - central).max() / np.abs(central).max())
    assert errors[1] < 1e-4  # size itself, which stands for the slope of the matrices, and rounding over h
    assert errors[1] < errors[0] / 20  # central differences are of order 2: a hundredth, but for what size leaves


Built = Literal["four_dof", "bridge"]


@cache
def setting(structure: Built) -> Setting:
    return setting_of(blind_case(7, BlindConfig(kinds=("stiffness_change",), tier="off", structure=structure)).dataset)


def trial(own: Setting, kind: str) -> tuple[Hypothesis, FloatArray]:
    """Return a hypothesis with a cause of one kind, and a theta that is off in everything."""
    of_kind = [c for c in own.candidates() if c.kind == kind]
    hypothesis = own.nominal_hypothesis.adding(of_kind[len(of_kind) // 2])
    (cause,) = hypothesis.candidates
    rng = np.random.default_rng(5)
    theta = 0.5 * hypothesis.width * rng.standard_normal(len(hypothesis.width))
    theta[hypothesis.nuisances :] = np.array(cause.neutral) + 0.02 * np.array(cause.width)
    if isinstance(cause, HarmonicCandidate):
        theta[-1] = 0.37 * own.noise_model.rate / 10  # Hz
    return hypothesis, theta


def both_ways(own: Setting, kind: str, batch: Batch) -> tuple[Linearisation, Linearisation, FloatArray]:
    hypothesis, theta = trial(own, kind)
    by_samples, brief = (
        linearise_batch(hypothesis, theta, batch, own.noise_model, None, brief=way) for way in (False, True)
    )
    assert by_samples is not None and brief is not None and brief.frame is not None
    return by_samples, brief, hypothesis.width


@pytest.mark.slow
@pytest.mark.parametrize(("kind", "uneven"), [*((kind, False) for kind in KINDS), (KINDS[0], True)])
@pytest.mark.parametrize("segments", [0, -1], ids=["segments", "whole"])
@pytest.mark.parametrize("structure", ["four_dof", "bridge"])
def test_condensed_recordings_ask_for_the_same_step(structure: Built, kind: str, segments: int, uneven: bool) -> None:
    own = setting(structure)
    batch = own.lengths.cut[segments][0]
    if uneven:
        noise = np.random.default_rng(2).uniform(0.5, 2.0, (len(batch.names), batch.data.shape[2]))
        batch = replace(batch, noise=noise)
    by_samples, brief, width = both_ways(own, kind, batch)
    assert brief.slopes.shape[2] < by_samples.slopes.shape[2]
    for name in ("states", "state_errors", "raw"):  # the same algebra, in other coordinates
        one, other = getattr(by_samples, name), getattr(brief, name)
        assert np.abs(one - other).max() < 1e-6 * np.abs(one).max(), name  # a harmonic force's columns: rounding
    normal, gradient = [], []
    for part in (by_samples, brief):
        J = part.slopes.reshape(len(width), -1) * width[:, None]
        normal.append(J @ J.T)
        gradient.append(J @ part.residual.ravel())
    scale = np.sqrt(np.diag(normal[0]) + 1.0)  # beside the prior, which counts one
    # Differences by a millionth of a width, where rounding shows: 3e-4 to 1.1e-3, as the processor sums.
    assert np.abs((normal[0] - normal[1]) / np.outer(scale, scale)).max() < 3e-3
    size = np.linalg.norm(by_samples.residual)
    assert np.abs((gradient[0] - gradient[1]) / scale).max() < 3e-3 * size  # those of the samples are one-sided
    moved = np.abs(by_samples.state_slopes - brief.state_slopes).max(axis=(0, 1))
    assert (moved < 1e-3 * np.abs(by_samples.state_slopes).max(axis=(0, 1))).all()
