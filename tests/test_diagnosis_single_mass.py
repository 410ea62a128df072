"""One mass under a known random force, thousands of samples with little noise: its spring's law, louder forecasts."""

from functools import cache
from typing import Literal

import numpy as np
import pytest
from scipy.signal import butter, sosfiltfilt

from fe_models.arrays import FloatArray
from fe_models.causes import CubicSpring, QuadraticSpring
from fe_models.recordings import Dataset, Load, Quantity, Recording, Sensor
from fe_models.structure import Damping, PointMass, Spring, Structure
from hybrid.diagnosis.diagnosis import diagnose
from hybrid.diagnosis.outcome.conclusion import Diagnosis
from hybrid.diagnosis.outcome.verdict import Verdict

RATE, FINE = 610.0, 20  # Hz; values of the force to a sample, two to a step of the solver
MASS, OMEGA, RATIO = 2.0, 2 * np.pi * 70.0, 0.03
STIFFNESS = MASS * OMEGA**2
RMS = 1e-3  # m, about that of the softer recording
CUBIC = 0.05 * STIFFNESS / (3 * RMS**2)  # N/m^3: stiffens by 5 % on average
NOISE = 1e-3
UNITS: dict[Quantity, str] = {"displacement": "m", "acceleration": "m/s^2"}


def force(seed: int, samples: int, size: float) -> FloatArray:
    """Return a random force (fine time,) up to 0.3 times the sampling rate, N."""
    white = np.random.default_rng(seed).standard_normal(samples * FINE + 1)
    passed = sosfiltfilt(butter(4, 0.3 * RATE, fs=RATE * FINE, output="sos"), white)
    return np.asarray(size * passed / passed.std())


def moved(course: FloatArray, quadratic: float) -> FloatArray:
    """Return displacement, velocity and acceleration (sample, 3) by the classical method of order 4."""
    h, u, v = 2 / (RATE * FINE), 0.0, 0.0
    found: list[tuple[float, float, float]] = []

    def accelerated(u: float, v: float, f: float) -> float:
        return float((f - 2 * RATIO * OMEGA * MASS * v - STIFFNESS * u - quadratic * u * u - CUBIC * u**3) / MASS)

    values = course.tolist()
    for step in range(len(values) // 2):
        f0, f1, f2 = values[2 * step : 2 * step + 3]
        a0 = accelerated(u, v, f0)
        if step % (FINE // 2) == 0:
            found.append((u, v, a0))
        v1, a1 = v + h / 2 * a0, accelerated(u + h / 2 * v, v + h / 2 * a0, f1)
        v2, a2 = v + h / 2 * a1, accelerated(u + h / 2 * v1, v + h / 2 * a1, f1)
        v3, a3 = v + h * a2, accelerated(u + h * v2, v + h * a2, f2)
        u, v = u + h / 6 * (v + 2 * v1 + 2 * v2 + v3), v + h / 6 * (a0 + 2 * a1 + 2 * a2 + a3)
    return np.array(found)


@cache
def diagnosed(quantity: Quantity, samples: int, quadratic: float = 0.0) -> tuple[Diagnosis, float]:
    """Return the diagnosis of one recording to fit and one half as loud again, and what noise leaves of the latter."""
    sensor = Sensor("y", 1, "x", quantity, UNITS[quantity])
    size = 2.0 * RATIO * STIFFNESS * RMS * 4  # about what moves it by that
    recordings, sigma, floor = [], 0.0, 0.0
    for seed, (name, louder) in enumerate((("train", 1.0), ("test", 1.5)), start=1):
        course = force(seed, samples, louder * size)
        shown = moved(course, quadratic * STIFFNESS / RMS)[:, [0 if quantity == "displacement" else 2]]
        sigma = sigma or NOISE * float(shown.std())  # the sensor's: no more where it is louder
        noise = sigma * np.random.default_rng(seed + 10).standard_normal(shown.shape)
        floor = float(np.std(noise) / np.ptp(shown + noise))
        load = Load(1, "x", course[: len(shown) * FINE : FINE])
        role: Literal["train", "test"] = "train" if name == "train" else "test"
        recordings.append(Recording(name, (shown + noise)[None], role, (load,), excitation="measured"))
    mass = Structure(
        name="mass",
        nodes=((0.0, 0.0),),
        directions=("x",),
        elements=(Spring((1,), "x", STIFFNESS),),
        point_masses=(PointMass(1, MASS),),
        damping=Damping(modal_ratios=(RATIO,)),
    )
    answer = diagnose(Dataset(mass, RATE, (sensor,), tuple(recordings)))
    assert isinstance(answer, Diagnosis)  # by time series, as forces are known
    return answer, floor


def test_a_cubic_spring_is_named_and_louder_motion_forecast() -> None:
    found, floor = diagnosed("acceleration", 4000)
    (finding,) = found.findings
    assert isinstance(finding.cause, CubicSpring)
    assert finding.probability >= 0.95
    assert finding.cause.stiffness == pytest.approx(CUBIC, rel=0.01)
    assert found.verdict is Verdict.EXPLAINED
    extended = found.scores["extended"]["measured"]
    assert extended is not None
    assert extended < 2 * floor
    # The harmonics that the nominal model leaves are no noise: what is left with the cause tells it, to some per cent.
    assert found.noise_floor == pytest.approx(floor, rel=0.2)


@pytest.mark.slow
def test_an_asymmetric_spring_is_named_as_well() -> None:
    found, floor = diagnosed("displacement", 4000, 0.05)
    named = {type(finding.cause): finding for finding in found.findings}
    assert set(named) == {CubicSpring, QuadraticSpring}
    assert min(finding.probability for finding in found.findings) >= 0.95
    quadratic = named[QuadraticSpring].cause
    assert isinstance(quadratic, QuadraticSpring)
    assert quadratic.stiffness == pytest.approx(0.05 * STIFFNESS / RMS, rel=0.02)
    extended = found.scores["extended"]["measured"]
    assert extended is not None
    assert extended < 2 * floor
