"""Motions under force laws: against an independent solver, for every law, and where motions grow beyond all bounds."""

from dataclasses import replace

import numpy as np
import pytest
from scipy.integrate import solve_ivp

from fe_models.arrays import FloatArray
from fe_models.lowpass import LowPass
from fe_models.measurement import lowpassed
from hybrid.diagnosis.config import THREADS
from hybrid.diagnosis.response.marching import march, respond
from hybrid.diagnosis.response.stepping import LANES
from hybrid.diagnosis.response.system import Force, System

STEP = 0.1  # s


def two_masses(*forces: Force, damping: float = 0.02) -> System:
    """Two unit masses on springs of 1 N/m; every law acts between the first one and the ground, or the second one."""
    n, laws = 2, len(forces)
    K = np.array([[2.0, -1.0], [-1.0, 1.0]])
    A = np.block([[np.zeros((n, n)), np.eye(n)], [-K, -damping * K]])
    pulls = np.eye(n)[[number % n for number in range(laws)]]  # (law, mass)
    B = np.concatenate([np.zeros((n, laws)), pulls.T])
    G = np.block([[pulls, np.zeros((laws, n))], [np.zeros((laws, n)), pulls]])
    C, D = np.eye(2 * n), np.zeros((2 * n, laws))
    unit, nothing = np.ones((1, 2 * n)), np.zeros((1, 2 * n))
    return System(A[None], B[None], C[None], D[None], G[None], forces, unit, nothing, nothing, STEP)


def cubic(u: FloatArray, v: FloatArray) -> FloatArray:
    return np.asarray(0.8 * u**3)


def stop(u: FloatArray, v: FloatArray) -> FloatArray:
    return np.asarray(3.0 * np.maximum(u - 0.5, 0.0))


def drag(u: FloatArray, v: FloatArray) -> FloatArray:
    return np.asarray(0.3 * v * np.abs(v))


def friction(u: FloatArray, v: FloatArray) -> FloatArray:
    return np.asarray(0.05 * v / np.sqrt(v**2 + 0.01**2))


def reference(system: System, start: FloatArray, samples: int) -> FloatArray:
    """States (time, state) by Dormand and Prince's scheme of order 8, at a tight tolerance."""
    laws = len(system.forces)

    def rate(_t: float, z: FloatArray) -> FloatArray:
        seen = system.G[0] @ z
        pull = [float(f(seen[i], seen[laws + i])) for i, f in enumerate(system.forces)]
        return np.asarray(system.A[0] @ z - system.B[0] @ np.array(pull))

    time = STEP * np.arange(samples)
    # no step longer than a sample's fifth: it must not miss where a contact sets in
    done = solve_ivp(rate, (0, time[-1]), start, "DOP853", time, rtol=1e-10, atol=1e-12, max_step=STEP / 5)
    return np.asarray(done.y.T)


@pytest.mark.parametrize(
    ("forces", "error"),  # fourth order for smooth laws; less where a slope, or nearly the force itself, jumps
    [((cubic,), 2e-6), ((drag,), 2e-5), ((cubic, drag), 2e-5), ((stop,), 2e-3), ((friction,), 2e-3)],
    ids=["cubic", "drag", "both", "stop", "friction"],
)
def test_motion_is_that_of_an_independent_solver(forces: tuple[Force, ...], error: float) -> None:
    system, start = two_masses(*forces), np.array([1.0, 0.4, -0.3, 0.7])
    marched = march(system, start[None, None], 200)
    assert marched is not None
    expected = reference(system, start, 200)
    assert np.abs(marched.watched[0, 0] - expected).max() < error * np.abs(expected).max()
    seen = expected @ system.G[0].T
    pulls = np.stack([-f(seen[:, i], seen[:, len(forces) + i]) for i, f in enumerate(forces)], axis=-1)
    assert np.abs(marched.forces[0, 0] - pulls).max() < 100 * error  # friction turns within a hundredth of the rates


@pytest.mark.parametrize(("force", "error"), [(drag, 2e-5), (stop, 2e-3)], ids=["drag", "stop"])  # as above
def test_body_that_nothing_holds_is_followed(force: Force, error: float) -> None:  # its eigenvectors fall together
    system, start = two_masses(force), np.array([0.1, 0.4, 1.0, 0.7])  # on its way to a stop far outside its reach
    A = system.A.copy()
    A[0, 2:] = 0.0
    free = replace(system, A=A)
    marched = march(free, start[None, None], 100)
    assert marched is not None
    expected = reference(free, start, 100)
    assert np.abs(marched.watched[0, 0] - expected).max() < error * np.abs(expected).max()


def test_sensors_behind_a_low_pass_show_contacts_as_it_leaves_them() -> None:
    """Recorded 20 times as densely, filtered, then sampled; the motion goes on before and after what is compared."""
    cutoff, dense, start = 0.8, 20, np.array([1.0, 0.4, -0.3, 0.7])
    system = two_masses(lambda u, v: 20 * stop(u, v))
    fine, coarse = replace(system, step=STEP / dense), replace(system, lowpass=LowPass(cutoff))
    long = march(fine, start[None, None], 600 * dense)
    assert long is not None
    truth = lowpassed(long.watched[0, 0], dense / STEP, cutoff)[::dense]
    first = long.watched[0, 0, 200 * dense]
    shown, bare = (respond(replace(coarse, lowpass=to), first[None, None], 200)[0, 0] for to in (LowPass(cutoff), None))
    folded = respond(coarse, first[None, None], 200, oversampling=1)[0, 0]  # beyond half the rate it looks like less
    whole = np.abs(truth).max(axis=0)
    inside = slice(50, 150)  # beyond, the filter reaches to where free motion stands in for contacts
    off, aliased, unfiltered = (np.abs((y - truth[200:400])[inside]).max(axis=0) / whole for y in (shown, folded, bare))
    assert off.max() < 5e-4  # contacts set in between samples: see above
    assert aliased.max() > 5 * off.max()
    assert unfiltered.max() > 25 * off.max()
    assert (np.abs(shown - truth[200:400]).max(axis=0) / whole).max() < 0.1  # nor is the rest left to chance


def test_channels_are_what_sensors_pick_of_states_and_forces() -> None:
    rng = np.random.default_rng(1)
    C, D = rng.standard_normal((1, 3, 4)), rng.standard_normal((1, 3, 2))
    none = np.zeros((1, 3))
    system = replace(two_masses(cubic, drag), C=C, D=D, gain=none + 1.0, delay=none, slope=none)
    start = np.array([1.0, 0.4, -0.3, 0.7])[None, None]
    marched = march(system, start, 100)
    assert marched is not None
    expected = marched.watched[0, 0] @ C[0].T + marched.forces[0, 0] @ D[0].T
    assert respond(system, start, 100)[0, 0] == pytest.approx(expected, abs=1e-9)  # sums in another order
    assert marched.last[0, 0] == pytest.approx(marched.watched[0, 0, -1], abs=1e-9)


def test_late_sensor_behind_a_low_pass_is_as_late_beside_a_force() -> None:
    step = 1.2  # s: the second mode has 3.2 samples a period, too few for a curve through them
    late = np.array([[0.0, 0.5 * step, 0.0, 0.0]])
    linear = replace(two_masses(), step=step, delay=late, lowpass=LowPass(0.4))
    beside = replace(two_masses(lambda u, v: 0.0 * u), step=step, delay=late, lowpass=LowPass(0.4))
    start = np.array([1.0, -1.0, 0.3, -0.3])[None, None]
    exact, stepped = (respond(system, start, 100)[0, 0] for system in (linear, beside))
    # free of what a curve does at its ends
    off = np.abs(stepped - exact)[20:80].max(axis=0) / np.abs(exact).max(axis=0)
    assert off.max() < 1e-3  # a curve through twice as many samples; through these it would be 0.04 off


def test_order_is_four() -> None:
    start = np.array([1.0, 0.4, -0.3, 0.7])
    expected = reference(two_masses(cubic), start, 101)[-1]
    errors = []
    for every in (
        4,
        8,
    ):  # samples that many times as far apart, in two substeps each: within half a radian of the modes
        coarse = replace(two_masses(cubic), step=every * STEP)
        marched = march(coarse, start[None, None], 100 // every + 1)
        assert marched is not None
        errors.append(
            np.abs(marched.watched[0, 0, -1] - reference(two_masses(cubic), start, 100 // every * every + 1)[-1]).max()
        )
    assert expected.shape == (4,)
    assert errors[1] / errors[0] > 2**3


def test_every_variant_and_recording_moves_on_its_own() -> None:
    strengths = np.array([[0.0], [0.8]])  # (variant, 1): parameters of a law are one for each variant
    system = two_masses(lambda u, v: strengths * u**3)
    A, B, C, D, G = (np.repeat(part, 2, axis=0) for part in (system.A, system.B, system.C, system.D, system.G))
    system = replace(system, A=A, B=B, C=C, D=D, G=G)
    recordings = THREADS.motions * LANES + 3  # more than go side by side in all threads
    start = np.random.default_rng(0).standard_normal((2, recordings, 4))
    marched, one = march(system, start, 50), march(two_masses(cubic), start[1:], 50)
    assert marched is not None
    assert one is not None
    for recording in range(recordings):
        alone = march(two_masses(cubic), start[1:, [recording]], 50)
        assert alone is not None
        assert marched.watched[1, recording] == pytest.approx(alone.watched[0, 0], abs=1e-8)  # their tables differ
        assert marched.last[1, recording] == pytest.approx(alone.last[0, 0], abs=1e-8)
        assert one.watched[0, recording] == pytest.approx(alone.watched[0, 0], abs=1e-8)
        assert one.last[0, recording] == pytest.approx(alone.last[0, 0], abs=1e-8)
        assert np.all(marched.forces[0, recording] == 0.0)


def test_motion_that_outgrows_its_tables_is_followed() -> None:
    system, start = two_masses(drag, damping=-0.3), np.array([1e-2, 0.0, 0.0, 0.0])
    marched = march(system, start[None, None], 300)
    assert marched is not None
    expected = reference(system, start, 300)
    assert np.abs(expected).max() > 50 * np.abs(start).max()
    assert np.abs(marched.watched[0, 0] - expected).max() < 1e-3 * np.abs(expected).max()


def test_motion_that_explodes_is_none() -> None:
    assert march(two_masses(lambda u, v: -(u**3)), np.array([[[5.0, 0.0, 0.0, 0.0]]]), 300) is None
    assert march(two_masses(cubic), np.full((1, 1, 4), np.nan), 5) is None
    assert march(two_masses(cubic), np.full((1, 1, 4), 1e110), 5) is None  # its cube is more than a number can be
