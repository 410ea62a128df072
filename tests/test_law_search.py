"""Force laws in recordings of a chain of two masses, whose free decay is known in closed form."""

from dataclasses import replace
from functools import cache

import numpy as np
import pytest
from scipy.integrate import solve_ivp

import fe_models as fe
from fe_models.arrays import FloatArray
from fe_models.causes.candidate import LawCandidate
from fe_models.causes.known import Channel
from fe_models.causes.places import Motion
from hybrid.diagnosis.contest.odds import Odds
from hybrid.diagnosis.discrepancy.law_fit import LawFit
from hybrid.diagnosis.discrepancy.law_search import LawSearch, with_probabilities
from hybrid.diagnosis.discrepancy.laws_in_recordings import fitted_to_whole, without_law
from hybrid.diagnosis.discrepancy.recorded_motions import track_of
from hybrid.diagnosis.discrepancy.size import Discrepancy
from hybrid.diagnosis.discrepancy.tracking import Track, shortened
from hybrid.diagnosis.modal.all_candidates import all_candidates_of
from hybrid.diagnosis.modal.error_sizes import ErrorSizes
from hybrid.diagnosis.modal.evidence import Start, fit_claim
from hybrid.diagnosis.modal.measured_modes import MeasuredModes
from hybrid.diagnosis.modal.modal_data import ModalData
from hybrid.diagnosis.modal.mode_values import value_count
from hybrid.diagnosis.nominal.structure_model import nominal_model_of

RATE, NOISE = 25.0, 1e-5  # Hz, m
MASSES, CUBIC = 2, 3e4  # N/m^3 at the first mass, where springs have 1000 N/m and move by a twentieth of a metre
SAMPLES = (160, 240)  # of the first recording and of the second
SENSORS = tuple(fe.Sensor(f"x{node}", node, "x", "displacement", "m") for node in range(1, MASSES + 1))


def chain() -> fe.Structure:
    """Return two masses of 2 kg on two springs of 1000 N/m."""
    return fe.Structure(
        "chain of two",
        tuple((float(node), 0.0) for node in range(MASSES)),
        (fe.Spring((1,), "x", 1000.0), fe.Spring((1, 2), "x", 1000.0)),
        point_masses=tuple(fe.PointMass(node, 2.0) for node in range(1, MASSES + 1)),
        directions=("x",),
        damping=fe.Damping(modal_ratios=(0.01,)),
    )


@cache
def decays(cubic: float) -> tuple[FloatArray, ...]:
    """Return displacements (time, mass) of each recording with a cubic spring at the first mass, without noise."""
    modal, found = fe.natural_modes(chain(), MASSES), []
    omega, ratio, shapes = modal.omega, modal.damping_ratio, modal.shapes
    for samples, begun in zip(SAMPLES, ([0.08, 0.05], [0.03, -0.07]), strict=True):

        def rate(_: float, x: FloatArray) -> FloatArray:
            q, v = x[:MASSES], x[MASSES:]
            force = cubic * (shapes[0] @ q) ** 3
            return np.concatenate([v, -(omega**2) * q - 2 * ratio * omega * v - shapes[0] * force])

        times = np.arange(samples) / RATE
        start = np.concatenate([begun, np.zeros(MASSES)])
        solved = solve_ivp(rate, (0.0, times[-1]), start, "DOP853", times, rtol=1e-7, atol=1e-9)
        found.append(solved.y[:MASSES].T @ shapes.T)
    return tuple(found)


@pytest.fixture(scope="module")
def dataset() -> fe.Dataset:
    """Two recordings of unlike lengths under a cubic spring, held against the chain without it."""
    rng = np.random.default_rng(1)
    noisy = [own + NOISE * rng.standard_normal(own.shape) for own in decays(CUBIC)]
    return fe.Dataset(chain(), RATE, SENSORS, tuple(fe.Recording(f"r{n}", own[None]) for n, own in enumerate(noisy)))


@pytest.fixture(scope="module")
def track(dataset: fe.Dataset) -> Track:
    """The motions as the chain's own modes expect them."""
    modal, size = fe.natural_modes(chain(), MASSES), value_count(MASSES)
    covariance = np.tile(1e-6 * np.eye(size), (MASSES, 1, 1))
    nominal = nominal_model_of(dataset).undispersed
    modes = [
        MeasuredModes(name, np.log(modal.omega), modal.damping_ratio, modal.shapes.T.astype(np.complex128), covariance)
        for name in ("r0", "r1")
    ]
    measured = ModalData(nominal, np.zeros(len(nominal.spread)), SENSORS, RATE, tuple(modes))
    null = fit_claim(measured, Start(measured.null, np.zeros(len(nominal.spread)), ErrorSizes()), 2, errors_too=False)
    assert null is not None
    found = track_of(dataset, measured, null)
    assert found is not None
    return found


def cubic_springs(track: Track) -> list[LawCandidate]:
    """Return a cubic spring to the ground at each mass."""
    states = 0.05 * np.random.default_rng(0).standard_normal((50, MASSES)) @ track.spaces[0].shapes.T
    channels = tuple(Channel(sensor.name, 1.0, 1.0) for sensor in SENSORS)
    every = all_candidates_of(track.nominal, Motion(states, states), channels)
    found = [own for own in every if own.kind == "cubic_spring" and isinstance(own, LawCandidate)]
    return sorted((own for own in found if "node" in own.location), key=lambda own: own.location["node"])


def test_a_law_that_was_found_in_the_first_parts_is_taken_out_of_all_of_unlike_recordings(
    dataset: fe.Dataset, track: Track
) -> None:
    """What is left is the free decay from the same beginning. The shorter recording was searched whole, the longer one
    in part: lengths of the first alone do not tell that.
    """
    law, short = cubic_springs(track)[0], shortened(track, 340)
    assert short.motions[0].samples == SAMPLES[0]
    assert short.motions[1].samples < SAMPLES[1]
    named = LawFit(law, np.array([0.9 * CUBIC]), np.eye(1), short.evidence, short)
    found = fitted_to_whole(LawSearch(short, (named,), np.ones(1), 0.0, 0.0), track)
    assert found.named is not None
    assert [own.samples for own in found.named.track.motions] == list(SAMPLES)
    # with four samples a cycle of the second mode the force is known to a hundredth along the motion
    assert found.named.theta[0] == pytest.approx(CUBIC, rel=0.02)
    left = without_law(dataset, found)
    for recording, own, free, bent in zip(left.recordings, dataset.recordings, decays(0.0), decays(CUBIC), strict=True):
        assert recording.data.shape == own.data.shape
        done = np.abs(bent - free).max()
        assert np.abs(recording.data[0] - free).max() < 0.05 * done


def test_laws_are_named_by_their_probability_rather_than_by_their_evidence(track: Track) -> None:
    """A law follows the motion slightly better, but leaves as much as one that only resembles another; the other
    leaves what any right model does.
    """
    first, second = cubic_springs(track)
    before = replace(track, discrepancy=Discrepancy(0.06, 1e-3))

    def fit(law: LawCandidate, gained: float, left: float) -> LawFit:
        item = replace(track, discrepancy=Discrepancy(left, 1e-3))
        return LawFit(law, np.ones(1), np.eye(1), before.evidence + gained, item)

    alike, right = fit(first, 100.01, 0.02), fit(second, 100.0, 0.001)
    found = with_probabilities(before, [alike, right], Odds.among([first, second], 1.0))
    assert found.fits == (right, alike)
    assert found.named is right
    assert found.probabilities[0] > found.probabilities[1]
    assert found.probabilities.sum() + found.none + found.other == pytest.approx(1.0)
