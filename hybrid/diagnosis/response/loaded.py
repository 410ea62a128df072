"""What known loads do to the linear part of a system from rest, exactly, as they are splines from sample to sample.

In each mode x' = root x + g with g(t) = sum over p of g_p t^p / p! within a step,

    x(t) = exp(root t) x(0) + sum over p of t^(p + 1) phi_(p + 1)(root t) g_p

with phi_0 = exp and phi_(p + 1)(z) = (phi_p(z) - 1 / p!) / z, as in exponential integrators.
"""

from dataclasses import replace
from math import factorial

import numpy as np
from scipy.signal import lfilter

from fe_models.arrays import ComplexArray, FloatArray
from fe_models.interpolant import ORDERS, courses_after
from hybrid.diagnosis.nominal.loads import Loads
from hybrid.diagnosis.recorded.batches import Batch
from hybrid.diagnosis.response.config import STATE_SPACE
from hybrid.diagnosis.response.system import System, drifted, free_form

SERIES_RADIUS = 1.0  # below it phi is summed as a series, beyond it by its recurrence, which near zero loses digits
SERIES_TERMS = 18  # of the series: 1 / 18! is rounding


def given(system: System, batch: Batch) -> FloatArray:
    """Return what a linear system's channels show whatever the initial states, but for the drift within a segment.

    Shape (variant, recording, time, sensor), or (variant, recording, 1, sensor) without loads.
    """
    late = drifted(system, batch.begins)
    return late if batch.loads is None else late + loaded_channels(system, batch.loads)


def loaded_channels(system: System, loads: Loads) -> FloatArray:
    """Return the channels (variant, recording, time, sensor) under known loads from rest, without force laws.

    With gain and delay of the sensors; a late one shows at first what would have been if motion and load had gone on
    before as they begin.
    """
    entry = system.loads
    assert entry is not None  # a nominal model knows its dataset's loads
    own = entry.feed.shape[1]  # loads do not move harmonic forces
    gain, delay = np.ones_like(system.gain), np.zeros_like(system.delay)  # they come at the end
    still = replace(system, A=system.A[:, :own, :own], C=system.C[..., :own], gain=gain, delay=delay)
    form = free_form(still, own // 2)
    step, longest = system.step, loads.samples * system.step
    y = np.empty((len(gain), len(loads.rows), loads.samples, gain.shape[1]))
    common = entry.acting(loads, 0) if entry.is_alike else None  # (order, recording, time, place)
    for variant, grown in enumerate(form.roots):
        courses = entry.acting(loads, variant) if common is None else common
        roots = np.minimum(grown.real, STATE_SPACE.max_growth_nepers / longest) + 1j * grown.imag
        moved = form.left[variant] @ entry.feed[variant]  # (mode, place)
        x = _from_rest(roots, moved, courses, step)
        shown = form.right[variant], entry.direct[variant], entry.bent
        y[variant] = _seen(shown, x, courses)
        for sensor in np.flatnonzero(system.delay[variant]):
            shift, one = -system.delay[variant, sensor] / step, slice(sensor, sensor + 1)
            picked = shown[0][one], shown[1][one], shown[2][:, one]
            y[variant, :, :, one] = _seen(picked, *_moved(x, courses, roots, moved, shift, step))
    return np.asarray(y * system.gain[:, None, None])


def loaded_states(system: System, loads: Loads, ahead: float = 0.0) -> FloatArray:
    """Return the states (time, recording, state) of the first variant, so far ``ahead`` (s) of the samples."""
    entry = system.loads
    assert entry is not None  # as above
    own, states, places = entry.feed.shape[1], system.A.shape[1], len(entry.places)
    nothing, one = np.zeros((1, states)), slice(0, 1)
    entry = replace(entry.only(0), direct=np.zeros((1, states, places)), bent=np.zeros((ORDERS, states, places)))
    watched = replace(
        system,
        A=system.A[one],
        C=np.eye(states)[None],
        gain=nothing + 1.0,
        delay=nothing - ahead,
        slope=nothing,
        loads=entry,
    )
    moved = loaded_channels(watched, loads)[0].transpose(1, 0, 2)
    moved[..., own:] = 0.0
    return moved


def loaded_size(system: System, loads: Loads) -> FloatArray:
    """Return the mean squares (state,) of the motion that loads make from rest."""
    return np.asarray(np.mean(loaded_states(system, loads) ** 2, axis=(0, 1)))


def _from_rest(roots: ComplexArray, moved: ComplexArray, courses: FloatArray, step: float) -> ComplexArray:
    """Return modal motions (mode, time, recording) at samples a ``step`` (s) apart.

    ``moved`` (mode, place): what a unit of each load adds to their rates.
    """
    orders, recordings, samples, places = courses.shape
    pushes = courses.transpose(0, 3, 2, 1).reshape(orders * places, samples * recordings)
    kicks = (_kicks(roots, step)[:, :, None] * moved[:, None]).reshape(len(roots), -1) @ pushes
    x = np.zeros((len(roots), samples, recordings), dtype=complex)
    for mode, kick in enumerate(kicks.reshape(x.shape)):
        x[mode, 1:] = lfilter([1.0], [1.0, -np.exp(roots[mode] * step)], kick[:-1], axis=0)
    return x


def _seen(shown: tuple[ComplexArray, FloatArray, FloatArray], x: ComplexArray, courses: FloatArray) -> FloatArray:
    """Return the channels (recording, time, sensor) of modal motions (mode, time, recording) and loads; ``shown``: what
    sensors pick of them.
    """
    right, direct, bent = shown
    flat = x.reshape(len(x), -1)
    y = (np.hstack([right.real, -right.imag]) @ np.vstack([flat.real, flat.imag])).reshape(-1, *x.shape[1:])
    felt = np.einsum("sl,rtl->rts", direct, courses[0])
    for order, picked in enumerate(bent):
        if picked.any():
            felt += np.einsum("sl,rtl->rts", picked, courses[order])
    return np.asarray(y.transpose(2, 1, 0) + felt)


def _moved(
    x: ComplexArray, courses: FloatArray, roots: ComplexArray, moved: ComplexArray, shift: float, step: float
) -> tuple[ComplexArray, FloatArray]:
    """Return modal motions and courses ``shift`` samples later, as both go on from the sample before."""
    samples = x.shape[1]
    at = np.arange(samples) + shift
    first = np.clip(np.floor(at).astype(int), 0, max(samples - 2, 0))
    rest = (at - first) * step  # (time,)
    kicks = _kicks(roots[:, None], rest)  # (mode, time, order)
    known = courses[:, :, first]  # (order, recording, time, place)
    growth = np.minimum(roots.real[:, None] * rest, STATE_SPACE.max_growth_nepers)
    then = np.exp(growth + 1j * roots.imag[:, None] * rest)
    x = then[..., None] * x[:, first] + np.einsum("mto,ml,ortl->mtr", kicks, moved, known, optimize=True)
    return x, courses_after(known, rest)


def _kicks(roots: ComplexArray, time: FloatArray | float) -> ComplexArray:
    """Return t^(p + 1) phi_(p + 1)(root t) of every order p, the last axis."""
    z = np.asarray(roots * time, dtype=complex)
    near = np.abs(z) < SERIES_RADIUS
    small, large = np.where(near, z, 0.0), np.where(near, 1.0, z)
    found, phi = [], np.exp(np.minimum(large.real, STATE_SPACE.max_growth_nepers) + 1j * large.imag)
    for order in range(ORDERS):
        phi = (phi - 1 / factorial(order)) / large
        series = sum(small**term / factorial(term + order + 1) for term in range(SERIES_TERMS))
        found.append(np.where(near, series, phi) * np.asarray(time) ** (order + 1))
    return np.stack(found, axis=-1)
