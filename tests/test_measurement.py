"""A recording holds the motion below its low-pass, in phase, and as much noise as asked for."""

import numpy as np
import pytest

from fe_models.arrays import FloatArray
from fe_models.dof_map import DofMap
from fe_models.errors import InputError
from fe_models.lowpass import LowPass
from fe_models.measurement import lowpassed, measure
from fe_models.recordings import Sensor
from fe_models.response import Response

RATE = 500.0  # Hz, of the response
TOP = Sensor("top", 1, "x", "displacement", "m")


def response_of(*channels: FloatArray) -> Response:
    """Return a response whose displacements, one a node in x, are ``channels`` (time,)."""
    x = np.stack(channels, axis=-1)
    nodes = np.arange(1, len(channels) + 1)
    dofs = DofMap(nodes, np.array(["x"] * len(nodes)), np.ones(len(nodes), dtype=bool))
    return Response(np.arange(len(x)) / RATE, x, 10 * x, 100 * x, dofs)


def sine(frequency: float, seconds: float = 20.0) -> FloatArray:
    return np.sin(2 * np.pi * frequency * np.arange(int(seconds * RATE) + 1) / RATE)


def rng(seed: int = 0) -> np.random.Generator:
    return np.random.default_rng(seed)


def test_slow_motion_passes_in_phase() -> None:
    recorded = measure(response_of(sine(5.0)), (TOP,), 100.0, rng(), lowpass=30.0)[:, 0]
    expected = sine(5.0)[::5]
    # Butterworth of order 4, twice: 1 - 1 / (1 + (5/30)^8) = 6e-7 in the middle; the filter rings in at the ends.
    np.testing.assert_allclose(recorded[50:-50], expected[50:-50], atol=1e-5)


def test_lowpass_halves_the_energy_at_its_frequency_twice() -> None:
    recorded = measure(response_of(sine(30.0)), (TOP,), 100.0, rng(), lowpass=30.0)[:, 0]
    assert recorded[100:-100].std() == pytest.approx(0.5 / np.sqrt(2), rel=0.01)  # 3 dB each way; bilinear warping


@pytest.mark.parametrize("frequency", [10.0, 26.0, 33.0])
def test_the_kernel_does_at_samples_what_the_filter_does_before_sampling(frequency: float) -> None:
    before = lowpassed(sine(frequency)[:, None], RATE, 30.0)[::5, 0]
    after = np.convolve(sine(frequency)[::5], LowPass(30.0).kernel(100.0), mode="same")
    np.testing.assert_allclose(after[50:-50], before[50:-50], atol=0.01)  # the filter's own bilinear warping at 500 Hz
    run_after = lowpassed(sine(frequency)[::5, None], 100.0, 30.0)[:, 0]
    if frequency > 20:  # at 100 Hz it is bent by far more
        assert np.abs(run_after - before)[50:-50].max() > 0.05


def test_decaying_motion_is_passed_by_its_complex_frequency() -> None:
    time = np.arange(int(4 * RATE)) / RATE
    root = -1.5 + 2j * np.pi * 28.0
    motion = np.exp(root * time)
    shown = lowpassed(np.stack([motion.real, motion.imag], axis=-1), RATE, 30.0) @ [1, 1j]
    gain = LowPass(30.0).gain(np.array([root]))[0]
    inside = slice(200, -200)  # without the filter's ends
    np.testing.assert_allclose(shown[inside], (gain * motion)[inside], atol=0.01)  # bilinear warping, as above


def test_recordings_of_a_few_samples_are_passed_as_well() -> None:
    """What stays as it is passes whole; ends are mirrored as far as there is something to mirror."""
    for samples in (1, 2, 5, 16):
        np.testing.assert_allclose(lowpassed(np.ones((samples, 1)), 100.0, 40.0), 1.0, atol=1e-12)


def test_nothing_is_folded_down() -> None:
    folded = measure(response_of(sine(95.0)), (TOP,), 100.0, rng())[:, 0]
    filtered = measure(response_of(sine(95.0)), (TOP,), 100.0, rng(), lowpass=30.0)[:, 0]
    assert folded.std() > 0.7  # without a filter 95 Hz looks like 5 Hz
    assert filtered[100:-100].std() < 1e-3  # (30 / 95)^8 = 1e-4


def test_noise_has_the_share_asked_for_and_is_low_passed() -> None:
    clean = measure(response_of(sine(5.0, 200.0)), (TOP,), 100.0, rng(), lowpass=30.0)[:, 0]
    noisy = measure(response_of(sine(5.0, 200.0)), (TOP,), 100.0, rng(), lowpass=30.0, noise=0.1)[:, 0]
    noise = noisy - clean
    assert noise.std() == pytest.approx(0.1 * clean.std(), rel=1e-9)
    power = np.abs(np.fft.rfft(noise)) ** 2
    frequency = np.fft.rfftfreq(len(noise), 0.01)
    assert power[frequency > 40].mean() < 0.01 * power[frequency < 20].mean()


def test_noise_is_a_share_of_what_is_recorded_not_of_the_jump_before() -> None:
    motion = sine(5.0)
    jumped = np.where(np.arange(len(motion)) < 20, 100.0, 0.0) + motion  # gone long before the recording starts
    clean, noisy = (measure(response_of(jumped), (TOP,), 100.0, rng(), 30.0, noise, start=1.0) for noise in (0, 0.1))
    assert len(clean) == len(measure(response_of(motion), (TOP,), 100.0, rng())) - 100
    assert (noisy - clean).std() == pytest.approx(0.1 * clean.std(), rel=1e-9)
    assert clean.std() == pytest.approx(motion.std(), rel=0.01)


def test_channels_follow_their_quantity_and_place() -> None:
    response = response_of(sine(2.0), sine(3.0))
    sensors = (
        Sensor("a", 2, "x", "acceleration", "m/s^2"),
        Sensor("b", 1, "x", "velocity", "m/s"),
    )
    recorded = measure(response, sensors, 250.0, rng())
    np.testing.assert_array_equal(recorded, np.column_stack([100 * sine(3.0)[::2], 10 * sine(2.0)[::2]]))


def test_same_generator_same_recording() -> None:
    first, again, other = (measure(response_of(sine(5.0)), (TOP,), 100.0, rng(seed), noise=0.05) for seed in (1, 1, 2))
    np.testing.assert_array_equal(first, again)
    assert (first != other).any()


def test_all_faults_at_once() -> None:
    sensors = (Sensor("s", 7, "x", "displacement", "m"), Sensor("t", 1, "x", "velocity", "m"))
    with pytest.raises(InputError) as caught:
        measure(response_of(sine(5.0)), sensors, 120.0, rng(), lowpass=80.0, noise=-1.0, start=1e3)
    lowpass, place, unit, noise, start, rate = caught.value.faults
    assert "lowpass = 80 Hz is not below half" in lowpass
    assert "sensor 's': node 7 does not exist" in place
    assert "sensor 't': unit 'm' does not fit velocity" in unit
    assert "noise = -1.0; must be 0 or more" in noise
    assert "start = 1000 s; must be 0 or more and before the response ends, after 20.002 s" in start
    assert "sampling_rate = 120 Hz does not divide that of the response, 500 Hz" in rate


def test_a_motion_of_one_sample_is_no_recording() -> None:
    measure(response_of(sine(5.0, 0.01)), (TOP,), 100.0, rng(), lowpass=40.0, noise=0.03)
    with pytest.raises(InputError, match=r"the response lasts 0\.01 s, one sample at 100 Hz"):
        measure(response_of(sine(5.0, 0.008)), (TOP,), 100.0, rng(), lowpass=40.0, noise=0.03)


def test_needs_sensors_and_one_motion() -> None:
    with pytest.raises(InputError, match="there is no sensor"):
        measure(response_of(sine(5.0)), (), 100.0, rng())
    many = response_of(sine(5.0))
    many = Response(many.time, many.displacement[None], many.velocity[None], many.acceleration[None], many.dofs)
    with pytest.raises(InputError, match="one motion"):
        measure(many, (TOP,), 100.0, rng())


def test_noise_may_be_given_in_units() -> None:
    """A channel that hardly moves gets as much as one that does."""
    quick = Sensor("quick", 2, "x", "acceleration", "m/s^2")
    slow = Sensor("slow", 1, "x", "acceleration", "m/s^2")
    response = response_of(1e-9 * sine(5.0), sine(5.0))
    clean = measure(response, (slow, quick, TOP), 100.0, rng())
    noisy = measure(response, (slow, quick, TOP), 100.0, rng(), noise={"m/s^2": 0.01, "m": 0.002})
    np.testing.assert_allclose((noisy - clean).std(axis=0), [0.01, 0.01, 0.002], rtol=1e-9)


def test_units_of_noise_that_do_not_fit_the_sensors_are_refused() -> None:
    turn = Sensor("spin", 1, "x", "velocity", "m/s")
    with pytest.raises(InputError) as caught:
        measure(response_of(sine(5.0)), (TOP, turn), 100.0, rng(), noise={"m/s^2": 0.01, "m": -1.0})
    assert [fault.split(":")[0] for fault in caught.value.faults] == [
        "noise = -1.0 m; must be 0 or more",
        "noise in m/s^2",
        "noise of the sensors in m/s (spin) is missing",
    ]
