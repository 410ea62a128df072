"""Motion under force laws, step by step: Lawson's Runge-Kutta scheme, compiled, the laws as tables.

The linear part is carried by matrix exponentials, so that steps are as long as the forces allow. Every law is a
function of elongation plus one of rate; both are tabulated: so one compiled loop serves all laws, each defined where it
belongs (`fe_models.effects`).
"""

from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from numba import njit
from scipy.linalg import expm
from scipy.signal import savgol_filter

from fe_models.dofs import FloatArray, IntArray
from hybrid.diagnosis.loaded import loaded_channels, loaded_states
from hybrid.diagnosis.loads import ORDERS, Loads
from hybrid.diagnosis.system import System, as_shown, drift, linear_channels

SUBSTEP = 1.0  # largest omega times substep where a force law acts: its pull on that mode is then off by 5e-4
FEWEST_SUBSTEPS = 2  # contacts and friction set in between samples
MOST_SUBSTEPS = 40
MOST_SUBSTEPS_OF_LAWS = 8  # where a law is sharp: friction that holds its place
NODES = 8192  # of a table, an even number: its middle is at rest
MARGIN = 2.0  # times what the linear motion can reach at most: how far tables go
WIDER = 8.0  # times as far, where a motion leaves them
SMOOTHED = 7  # samples of a force from which its derivatives are told
ATTEMPTS = 4  # of that; a motion that goes further has exploded


def _compiled(function: Callable[..., Any]) -> Callable[..., Any]:
    """Return a function compiled to machine code, which is kept from one run to the next where that can be."""
    try:
        return njit(cache=True)(function)
    except RuntimeError:  # no folder that can be written to
        return njit(function)


@dataclass(frozen=True)
class _Tables:
    """Forces of all laws: ``values`` (variant, 2 law, node), of elongation, then of rate, from -``reach`` to ``reach``
    (2 law,); ``felt`` (2 law,): 0 where a law does not depend on it.
    """

    values: FloatArray
    reach: FloatArray
    felt: IntArray


def _tables(system: System, reach: FloatArray) -> _Tables:
    """Return the tables of a system's laws for elongations and rates up to ``reach`` (2 law,)."""
    variants, laws = len(system.A), len(system.forces)
    values = np.zeros((variants, 2 * laws, NODES + 1))
    nodes, still = np.linspace(-1, 1, NODES + 1), np.zeros((variants, NODES + 1))
    with np.errstate(over="ignore", invalid="ignore"):
        for number, force in enumerate(system.forces):
            for row, pair in ((number, (1, 0)), (laws + number, (0, 1))):
                at = np.broadcast_to(reach[row] * nodes, still.shape)
                values[:, row] = force(at if pair[0] else still, at if pair[1] else still)
    return _Tables(values, reach, np.abs(values).max(axis=(0, 2)).astype(bool).astype(np.int64))


def march(
    system: System, start: FloatArray, samples: int, loads: Loads | None = None
) -> tuple[FloatArray, FloatArray] | None:
    """Return states (time, variant, recording, state) and -f (time, variant, recording, law), None where they explode.

    ``start`` (variant, recording, state). Order 4; only the elongations are needed within a substep, so that all four
    stages cost one product with the state. Known ``loads`` and their derivatives are carried as states that each sample
    sets anew, so that the linear part stays exact.
    """
    fastest = float(np.abs(np.linalg.eigvals(system.A[0])).max())
    substeps = max(FEWEST_SUBSTEPS, int(np.ceil(fastest * system.step / SUBSTEP)))
    if substeps > MOST_SUBSTEPS or not np.isfinite(start).all():  # no structure, but a search gone astray
        return None
    reach = _reach(system, start, loads)
    tables = _tables(system, reach)
    wanted = int(np.ceil(min(_sharpest(system, tables) * system.step, MOST_SUBSTEPS_OF_LAWS)))
    substeps = max(substeps, wanted)
    variants, recordings, states = start.shape
    known = np.zeros((recordings, samples, 0))
    if loads is not None:
        system, known = _with_loads(system, loads)
        start = np.pad(start, ((0, 0), (0, 0), (0, known.shape[2])))
    scheme = _scheme(system, system.step / substeps)
    history = np.empty((samples, *start.shape))
    applied = np.empty((samples, variants, recordings, len(system.forces)))
    begun = np.array(start, order="C")
    for _ in range(ATTEMPTS):
        if _marched(*scheme, tables.values, tables.reach, tables.felt, begun, known, substeps, history, applied):
            return history[..., :states], applied
        reach *= WIDER
        tables = _tables(system, reach)
    return None


def _with_loads(system: System, loads: Loads) -> tuple[System, FloatArray]:
    """Return a system whose states end with the loads' courses, and what these are, (recording, time, course)."""
    entry = system.loads
    assert entry is not None  # a plant knows its dataset's loads
    courses = loads.at(entry.places)
    variants, states, laws = system.B.shape
    own, places = entry.feed.shape[1], len(entry.places)
    more = ORDERS * places
    A = np.zeros((variants, states + more, states + more))
    A[:, :states, :states] = system.A
    A[:, :own, states : states + places] = entry.feed
    A[:, range(states, states + more - places), range(states + places, states + more)] = 1.0  # each order's derivative
    G = np.pad(system.G, ((0, 0), (0, 0), (0, more)))
    for order in (0, 1):
        first = states + order * places
        G[:, order * laws : (order + 1) * laws, first : first + places] = entry.stretch
    known = courses.transpose(1, 2, 0, 3).reshape(*courses.shape[1:3], more)
    return replace(system, A=A, B=np.pad(system.B, ((0, 0), (0, more), (0, 0))), G=G), np.ascontiguousarray(known)


def _sharpest(system: System, tables: _Tables) -> float:
    """Return the largest rate (1/s) at which a law would bring its own place to rest: where friction holds it."""
    laws = len(system.forces)
    mobility = np.abs(np.einsum("ls,sl->l", system.G[0, laws:], system.B[0]))  # acceleration by a unit force
    reached = tables.values[0, laws:, NODES // 4 : -NODES // 4]  # without the tables' margin
    slopes = np.abs(np.diff(reached, axis=1)).max(axis=1) * NODES / (2 * tables.reach[laws:])
    return float((slopes * mobility).max())


def respond(system: System, start: FloatArray, samples: int, loads: Loads | None = None) -> FloatArray:
    """Return the channels (variant, recording, time, sensor) from initial states (variant, recording, state) under
    known ``loads``.

    NaN where the motion grows beyond all bounds.
    """
    if system.is_linear:
        y = linear_channels(system, start, samples) + drift(system, samples)[:, None]
        return y if loads is None else y + loaded_channels(system, loads)
    marched = march(system, start, samples, loads)
    if marched is None:
        return np.full((*start.shape[:2], samples, system.C.shape[1]), np.nan)
    return channels(system, marched, loads)


def channels(system: System, marched: tuple[FloatArray, FloatArray], loads: Loads | None = None) -> FloatArray:
    """Return the channels (variant, recording, time, sensor) of what `march` returns under known ``loads``."""
    with np.errstate(over="ignore", invalid="ignore"):
        y = np.einsum("tprn,psn->prts", marched[0], system.C, optimize=True)
        y += np.einsum("tprm,psm->prts", marched[1], system.D, optimize=True)
        for order, bent in enumerate(() if system.bent is None else system.bent):
            if bent.any():
                y += np.einsum("tprm,sm->prts", _derivative(marched[1], order, system.step), bent, optimize=True)
        if loads is not None and system.loads is not None:
            courses = loads.at(system.loads.places)
            y += np.einsum("psl,rtl->prts", system.loads.direct, courses[0])
            y += np.einsum("osl,ortl->rts", system.loads.bent, courses[:3])
    return as_shown(system, y)


def _derivative(applied: FloatArray, order: int, step: float) -> FloatArray:
    """Return a derivative of forces (time, ...), by Savitzky and Golay's filter: it follows no jump between samples."""
    if order == 0:
        return applied
    if len(applied) < SMOOTHED:
        return np.zeros_like(applied)
    return np.asarray(savgol_filter(applied, SMOOTHED, polyorder=4, deriv=order, delta=step, axis=0))


def _reach(system: System, start: FloatArray, loads: Loads | None) -> FloatArray:
    """Return elongations and rates (2 law,) twice as large as without the forces the first variant could reach."""
    vectors = np.linalg.eig(system.A[0])[1]
    with np.errstate(all="ignore"):
        amplitudes = np.abs(np.linalg.pinv(vectors) @ start[0].T)  # (mode, recording)
        most = (np.abs(system.G[0] @ vectors) @ amplitudes).max(axis=1)
        if loads is not None:
            most = most + np.abs(loaded_states(system, loads) @ system.G[0].T).max(axis=(0, 1))
    return np.maximum(MARGIN * most, np.finfo(float).tiny ** 0.25)


def _scheme(system: System, h: float) -> tuple[FloatArray, ...]:
    """Return the matrices of a substep ``h``, transposed so that columns are contiguous."""
    half = expm(system.A * (h / 2))
    whole = half @ half
    G, half_B = system.G, half @ system.B
    stack = np.concatenate([G, G @ half, G @ whole, whole], axis=1)  # (variant, 6 law + state, state)
    parts = (
        stack,
        h * (G @ system.B),
        h * (G @ half_B),
        h / 6 * (whole @ system.B),
        h / 3 * half_B,
        h / 6 * system.B,
    )
    return tuple(np.ascontiguousarray(part.transpose(0, 2, 1)) for part in parts)


@_compiled
def _force(values: FloatArray, reach: float, x: float) -> float:
    """Return a table's value at ``x``: the cubic through its four nearest nodes (Lagrange)."""
    place = (x + reach) / (2 * reach) * (len(values) - 1)
    cell = min(max(int(place), 1), len(values) - 3)
    t = place - cell
    before, here, after, last = values[cell - 1], values[cell], values[cell + 1], values[cell + 2]
    return (
        -before * t * (t - 1) * (t - 2) / 6
        + here * (t + 1) * (t - 1) * (t - 2) / 2
        - after * (t + 1) * t * (t - 2) / 2
        + last * (t + 1) * t * (t - 1) / 6
    )


@_compiled
def _marched(
    stack: FloatArray,
    direct: FloatArray,
    delayed: FloatArray,
    first: FloatArray,
    middle: FloatArray,
    last: FloatArray,
    values: FloatArray,
    reach: FloatArray,
    felt: IntArray,
    start: FloatArray,
    known: FloatArray,
    substeps: int,
    history: FloatArray,
    applied: FloatArray,
) -> bool:
    """Fill ``history`` and ``applied``; return whether no elongation or rate left its table. The last states are
    ``known`` at each sample (recording, time, known).
    """
    samples, variants, recordings, states = history.shape
    laws = applied.shape[3]
    rows = 2 * laws
    moved, at = np.empty(3 * rows + states), np.empty(rows)
    f = np.empty((4, laws))
    z = np.empty(states)
    for variant in range(variants):
        columns = stack[variant]
        for recording in range(recordings):
            z[:] = start[variant, recording]
            for k in range(samples):
                for i in range(known.shape[2]):
                    z[states - known.shape[2] + i] = known[recording, k, i]
                for part in range(substeps):
                    moved[:] = 0.0
                    for j in range(states):
                        column, amount = columns[j], z[j]
                        for i in range(len(column)):
                            moved[i] += column[i] * amount
                    for stage in range(4):
                        for row in range(rows):
                            at[row] = moved[row if stage == 0 else rows + row if stage < 3 else 2 * rows + row]
                            for law in range(laws):
                                if stage == 1:
                                    at[row] += 0.5 * f[0, law] * delayed[variant, law, row]
                                elif stage == 2:
                                    at[row] += 0.5 * f[1, law] * direct[variant, law, row]
                                elif stage == 3:
                                    at[row] += f[2, law] * delayed[variant, law, row]
                        for law in range(laws):
                            f[stage, law] = 0.0
                            for row in (law, laws + law):
                                if not abs(at[row]) <= reach[row]:
                                    return False
                                if felt[row]:
                                    f[stage, law] -= _force(values[variant, row], reach[row], at[row])
                        if stage == 0 and part == 0:
                            history[k, variant, recording] = z
                            applied[k, variant, recording] = f[0]
                            if k == samples - 1:
                                break
                    if k == samples - 1:
                        break
                    for i in range(states):
                        z[i] = moved[3 * rows + i]
                        for law in range(laws):
                            z[i] += f[0, law] * first[variant, law, i] + f[3, law] * last[variant, law, i]
                            z[i] += (f[1, law] + f[2, law]) * middle[variant, law, i]
    return True
