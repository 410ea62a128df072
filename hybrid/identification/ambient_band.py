"""One pass of the identification of ambient vibration: a band of frequencies, sampled as fast as it asks for.

Poles come of correlations by `covariance_subspace`, order by order, and those that stay where they are stand for modes
(`stabilisation`). What is known too badly, or moves in no phase, is noise and left out. The covariance is the scatter
of what the segments of the recording say,

    cov = sum over segments of e e^T / (n (n - 1)),

e what one of n segments adds to the roots and shapes.
"""

from collections.abc import Sequence
from dataclasses import replace
from math import ceil

import numpy as np
from scipy.signal import decimate, detrend

from fe_models.arrays import TINY, BoolArray, ComplexArray, FloatArray, IntArray
from hybrid.identification.channel_sizes import are_several, channel_sizes
from hybrid.identification.config import AMBIENT, FREE_DECAY, HARMONIC, STABILISATION
from hybrid.identification.covariance_subspace import CovarianceSubspace, PolesOfOrder
from hybrid.identification.identified_modes import IdentifiedModes, no_modes
from hybrid.identification.output_correlations import Correlations, correlations_of
from hybrid.identification.stabilisation import Stabilisation, vibrates


def modes_of_band(
    motions: Sequence[FloatArray],
    rate: float,
    first: float,
    highest: float,
    orders: IntArray,
    sizes: FloatArray | None = None,
) -> tuple[IdentifiedModes, Stabilisation]:
    """Return the modes of ``motions`` (time, sensor) up to ``highest`` Hz, lines of machines among them.

    Their energy is over that of all frequencies up to there; ``sizes`` (sensor,) of the channels, left out, are those
    of these modes (`channel_sizes`). See `identify_ambient_modes`.
    """
    thinned, rate = thinned_to(motions, rate, highest)
    rms = np.sqrt(np.mean(np.concatenate(thinned) ** 2, axis=0))
    scale = np.where(rms > 0, rms, 1.0)
    rows = min(ceil(AMBIENT.row_periods * rate / first), _most_rows(thinned))
    lowest = min(FREE_DECAY.min_frequency_hz, FREE_DECAY.min_frequency_hz * first)
    if rows < 2 or not rms.any():
        return no_modes(orders), _stabilised([], rate, (lowest, highest), scale)
    found = correlations_of([part / scale for part in thinned], 2 * rows, AMBIENT.segments)
    subspace = CovarianceSubspace.of(found)
    enough = 2 * ceil(subspace.significant(samples_that_count(thinned)) / 2)
    most = min(enough + max(enough, AMBIENT.min_further_orders), rows * len(orders))
    poles = [subspace.poles(order) for order in range(STABILISATION.order_step, most + 1, STABILISATION.order_step)]
    stabilised = _stabilised(poles, rate, (lowest, highest), scale, enough)
    modes = _modes(stabilised, subspace, {own.order: own for own in poles if own.order >= enough}, rate, scale, orders)
    modes = _with_energy(modes.take(_is_known(modes)), found, rate, scale, sizes)
    return modes.take(modes.energy > AMBIENT.least_energy), stabilised


def thinned_to(motions: Sequence[FloatArray], rate: float, highest: float) -> tuple[list[FloatArray], float]:
    """Return motions without their trend at a rate (Hz) that frequencies up to ``highest`` Hz ask for, and the rate."""
    every = max(1, int(rate / (AMBIENT.min_rate_ratio * highest)))
    straight = [detrend(part, axis=0) for part in motions]
    while every > 1:  # in steps, as filters of a great decimation are long
        step = next((step for step in (8, 7, 6, 5, 4, 3, 2) if every % step == 0), None)
        if step is None:
            every -= 1
            continue
        straight = [decimate(part, step, ftype="fir", axis=0) for part in straight]
        rate, every = rate / step, every // step
    return straight, rate


def lack_of_rows(motions: Sequence[FloatArray], rate: float, first: float, highest: float) -> float:
    """Return how many times the block rows that there can be the slowest mode asks for."""
    every = max(1, int(rate / (AMBIENT.min_rate_ratio * highest)))
    fewer = [part[::every] for part in motions]
    return AMBIENT.row_periods * rate / every / first / max(_most_rows(fewer), 1)


def samples_that_count(motions: Sequence[FloatArray]) -> float:
    """Return how many samples say something: (sum p)^2 / sum p^2 of the power p (Kish), less than all where gusts hold
    most of it.
    """
    length = max(sum(map(len, motions)) // AMBIENT.segments, 1)
    parts = [part[: len(part) // length * length].reshape(-1, length, part.shape[1]) for part in motions]
    power = np.concatenate([np.mean(part**2, axis=1) for part in parts])  # (segment, sensor)
    power = np.sum(power / np.maximum(power.mean(axis=0), TINY), axis=1)
    return sum(map(len, motions)) * float(np.mean(power) ** 2 / max(np.mean(power**2), TINY))


def _most_rows(motions: Sequence[FloatArray]) -> int:
    """Return how many block rows there can be."""
    most = min(AMBIENT.max_rows, int(AMBIENT.max_row_share * samples_that_count(motions))) // motions[0].shape[1]
    return min(most, min(map(len, motions)) // 4)


def _stabilised(
    poles: Sequence[PolesOfOrder], rate: float, band: tuple[float, float], scale: FloatArray, enough: int = 0
) -> Stabilisation:
    """Return the poles that are vibrations in the band (Hz), in the channels' own ``scale``.

    An order that is ``enough`` holds all modes: those that come later are of noise, and those that do not stay, too.
    """
    order, roots = np.zeros(0, dtype=int), np.zeros(0, dtype=complex)
    shapes = np.zeros((0, len(scale)), dtype=complex)
    for own in poles:
        every = _roots_of(own, rate)
        kept = vibrates(every, band) & (every.real < HARMONIC.largest_ratio * np.abs(every))
        order = np.concatenate([order, np.full(int(kept.sum()), own.order)])
        roots, shapes = np.concatenate([roots, every[kept]]), np.concatenate([shapes, own.shapes[kept] * scale])
    later = sum(own.order >= enough for own in poles)
    found = Stabilisation.of(order, roots, shapes, scale, AMBIENT.min_order_share * later, enough)
    number, early = np.full(found.mode.max(initial=-1) + 2, -1), np.unique(found.mode[order <= enough])
    early = early[early >= 0]
    number[early] = np.arange(len(early))
    return replace(found, mode=number[found.mode])


def _roots_of(poles: PolesOfOrder, rate: float) -> ComplexArray:
    """Return the roots (pole,), rad/s, of the poles of one order."""
    return np.asarray(np.log(np.where(poles.values == 0, np.finfo(float).tiny, poles.values)) * rate, dtype=complex)


def _modes(
    stabilised: Stabilisation,
    subspace: CovarianceSubspace,
    poles: dict[int, PolesOfOrder],
    rate: float,
    scale: FloatArray,
    orders: IntArray,
) -> IdentifiedModes:
    """Return the stable modes: of each the pole in the middle of its kind, with its covariance."""
    sensors = len(scale)
    count = int(stabilised.mode.max(initial=-1)) + 1
    roots, shapes = np.zeros(count, dtype=complex), np.zeros((sensors, count), dtype=complex)
    reference, covariance = np.zeros(count, dtype=int), np.zeros((count, 2 + 2 * sensors, 2 + 2 * sensors))
    for mode in range(count):
        own = np.flatnonzero((stabilised.mode == mode) & (stabilised.order >= min(poles)))
        chosen = own[_in_the_middle(stabilised.roots[own])]
        order = poles[int(stabilised.order[chosen])]
        pole = int(np.argmin(np.abs(_roots_of(order, rate) - stabilised.roots[chosen])))
        roots[mode] = stabilised.roots[chosen]
        reference[mode] = np.argmax(np.abs(order.shapes[pole]))
        shapes[:, mode], covariance[mode] = _with_covariance(subspace, order, pole, rate, scale, int(reference[mode]))
    sizes = scale if are_several(orders) else np.ones(sensors)
    return IdentifiedModes(roots, shapes, reference, covariance, np.zeros(count), 1.0, orders, sizes)


def _in_the_middle(roots: ComplexArray) -> int:
    """Return the number of the root nearest to the median decay and frequency of all, in units of their decay."""
    middle = np.median(roots.real) + 1j * np.median(roots.imag)
    return int(np.argmin(np.abs(roots - middle)))


def _with_covariance(
    subspace: CovarianceSubspace, order: PolesOfOrder, pole: int, rate: float, scale: FloatArray, reference: int
) -> tuple[ComplexArray, FloatArray]:
    """Return the shape (sensor,) of a pole, one at its ``reference``, and the covariance of its root and shape."""
    influence = subspace.influence(order, pole)  # (segment, 1 + sensor)
    entry = order.shapes[pole, reference]
    shape = order.shapes[pole] / entry
    to_units = scale / scale[reference]
    ds = influence[:, :1] / order.values[pole] * rate
    dv = (influence[:, 1:] - shape * influence[:, [1 + reference]]) / entry * to_units
    parts = np.hstack([ds.real, ds.imag, dv.real, dv.imag])
    return shape * to_units, parts.T @ parts / (len(parts) * (len(parts) - 1))


def _is_known(found: IdentifiedModes) -> BoolArray:
    """Return which modes are known well enough and in phase."""
    entries = np.sqrt(np.diagonal(found.covariance, axis1=1, axis2=2)[:, 2:]) / np.tile(found.sizes, 2)
    usual = np.median(entries, axis=1) / np.abs(found.shapes / found.sizes[:, None]).max(axis=0, initial=0)
    sure = np.sqrt(found.scatter[:, 0, 0]) < AMBIENT.max_frequency_error
    in_phase = found.collinearity >= FREE_DECAY.min_phase_collinearity
    return np.asarray(sure & in_phase & (usual < FREE_DECAY.max_shape_error))


def _with_energy(
    modes: IdentifiedModes, found: Correlations, rate: float, scale: FloatArray, sizes: FloatArray | None
) -> IdentifiedModes:
    """Return the modes with their shares of the energy: R(l) = Re sum_k v_k exp(s_k l) g_k^T, g of least squares."""
    if not len(modes.roots):
        return modes
    lags = np.arange(1, len(found.mean))
    count, shapes = len(modes.roots), modes.shapes / scale[:, None]
    waves = np.exp(np.outer(lags / rate, modes.roots))[:, None] * shapes  # (lag, sensor, mode)
    columns = np.concatenate([waves.real, -waves.imag], axis=2).reshape(-1, 2 * count)
    solved = np.linalg.lstsq(columns, found.mean[1:].reshape(len(columns), -1), rcond=None)[0]
    power = scale[:, None] ** 2 * np.real(shapes * (solved[:count] + 1j * solved[count:]).T)  # (sensor, mode)
    if sizes is None:
        sizes = channel_sizes(modes.roots, np.maximum(power.T, 0.0), modes.orders)
    total = np.sum(scale**2 * np.diag(found.mean[0]) / sizes**2)
    share = np.clip(np.sum(power / sizes[:, None] ** 2, axis=0) / total, 0.0, 1.0)
    return replace(modes, energy=share, left=float(max(1 - share.sum(), 0.0)), sizes=sizes)
