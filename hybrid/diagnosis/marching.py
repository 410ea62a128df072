"""Motion under force laws, step by step: Lawson's Runge-Kutta scheme, compiled, the laws as tables.

The linear part is carried by matrix exponentials, so that steps are as long as the forces allow. Every law is a
function of elongation plus one of rate; both are tabulated: so one compiled loop serves all laws, each defined where it
belongs (`fe_models.effects`).
"""

from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass, replace
from itertools import pairwise
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
WORST = 1e6  # condition number of coordinates that are still told as well as slopes by finite differences need them
THREADS = 2  # that share the variants; each holds a core only while it works


def _compiled(function: Callable[..., Any]) -> Callable[..., Any]:
    """Return a function compiled to machine code, which is kept from one run to the next where that can be.

    Sums may be taken in any order, so that the processor's vectors serve; what is not finite stays so.
    """
    options = {"nogil": True, "error_model": "numpy", "fastmath": {"reassoc", "contract", "nsz"}}
    try:
        return njit(cache=True, **options)(function)
    except RuntimeError:  # no folder that can be written to
        return njit(**options)(function)


@dataclass(frozen=True)
class Marched:
    """``states`` (variant, recording, time, state) and ``forces`` -f (variant, recording, time, law)."""

    states: FloatArray
    forces: FloatArray


@dataclass(frozen=True)
class _Tables:
    """What laws are told by: of the elongations and rates (2 law,) those ``rows`` (row,) that any law depends on.

    ``values`` (variant, row, node) of a force from -``reach`` to ``reach`` (row,).
    """

    values: FloatArray
    reach: FloatArray
    rows: IntArray


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
    rows = np.flatnonzero(np.abs(values).max(axis=(0, 2)))
    return _Tables(np.ascontiguousarray(values[:, rows]), reach[rows], rows)


def march(system: System, start: FloatArray, samples: int, loads: Loads | None = None) -> Marched | None:
    """Return the motion from ``start`` (variant, recording, state), None where it explodes.

    Order 4; only the elongations are needed within a substep, so that all four stages cost one product with the state.
    Known ``loads`` and their derivatives are carried as states that each sample sets anew, so that the linear part
    stays exact.
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
    history = np.empty((variants, recordings, samples, start.shape[2]))
    applied = np.empty((variants, recordings, samples, len(system.forces)))
    basis, inverse, half = _carried(system.A, system.step / substeps / 2)
    begun = np.ascontiguousarray(start @ inverse.swapaxes(1, 2))
    for _ in range(ATTEMPTS):
        scheme = _scheme(system, basis, inverse, half, system.step / substeps, tables.rows)
        parts = (*scheme, tables.values, begun, history, applied)
        whole = tables.reach, tables.rows % len(system.forces), known, substeps
        if _all_marched(parts, whole):
            return Marched(history[..., :states], applied)
        reach = reach * WIDER
        tables = _tables(system, reach)
    return None


def _all_marched(parts: tuple[FloatArray, ...], whole: tuple[Any, ...]) -> bool:
    """Return whether all variants stay within their tables; threads share the ``parts``, whose first axis they are."""
    bounds = np.linspace(0, len(parts[0]), THREADS + 1).astype(int)
    shares = [[part[first:last] for part in parts] for first, last in pairwise(bounds)]
    with ThreadPoolExecutor(THREADS) as pool:
        return all(pool.map(lambda share: _marched(*share, *whole), shares))


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
    rates = tables.rows >= laws
    reached = tables.values[0, rates, NODES // 4 : -NODES // 4]  # without the tables' margin
    slopes = np.abs(np.diff(reached, axis=1)).max(axis=1) * NODES / (2 * tables.reach[rates])
    return float((slopes * mobility[tables.rows[rates] - laws]).max(initial=0.0))


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


def channels(system: System, marched: Marched, loads: Loads | None = None) -> FloatArray:
    """Return the channels (variant, recording, time, sensor) of what `march` returns under known ``loads``."""
    with np.errstate(over="ignore", invalid="ignore"):
        y = marched.states @ system.C[:, None].swapaxes(2, 3)
        y += marched.forces @ system.D[:, None].swapaxes(2, 3)
        for order, bent in enumerate(() if system.bent is None else system.bent):
            if bent.any():
                y += _derivative(marched.forces, order, system.step) @ bent.T
        if loads is not None and system.loads is not None:
            courses = loads.at(system.loads.places)
            y += np.einsum("psl,rtl->prts", system.loads.direct, courses[0])
            y += np.einsum("osl,ortl->rts", system.loads.bent, courses[:3])
    return as_shown(system, y)


def _derivative(applied: FloatArray, order: int, step: float) -> FloatArray:
    """Return a derivative of forces (..., time, law), by Savitzky and Golay's filter.

    It follows no jump between samples.
    """
    if order == 0:
        return applied
    if applied.shape[-2] < SMOOTHED:
        return np.zeros_like(applied)
    return np.asarray(savgol_filter(applied, SMOOTHED, polyorder=4, deriv=order, delta=step, axis=-2))


def _reach(system: System, start: FloatArray, loads: Loads | None) -> FloatArray:
    """Return elongations and rates (2 law,) twice as large as without the forces the first variant could reach."""
    vectors = np.linalg.eig(system.A[0])[1]
    with np.errstate(all="ignore"):
        amplitudes = np.abs(np.linalg.pinv(vectors) @ start[0].T)  # (mode, recording)
        most = (np.abs(system.G[0] @ vectors) @ amplitudes).max(axis=1)
        most = np.maximum(most, np.abs(system.G[0] @ start[0].T).max(axis=1))  # of a body that moves freely
        if loads is not None:
            most = most + np.abs(loaded_states(system, loads) @ system.G[0].T).max(axis=(0, 1))
    return np.maximum(MARGIN * most, np.finfo(float).tiny ** 0.25)


def _carried(A: FloatArray, time: float) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Return coordinates (variant, state, coordinate) that hardly couple, their inverse, and what carries them on.

    The real and imaginary parts of eigenvectors, which a ``time`` (s) turns in pairs; where these fall together, the
    states themselves.
    """
    roots, vectors = np.linalg.eig(A)
    basis = np.where(roots.imag[:, None] < 0, -vectors.imag, vectors.real)
    if not np.isfinite(basis).all() or np.linalg.cond(basis).max() > WORST:
        same = np.broadcast_to(np.eye(A.shape[1]), A.shape)
        return same, same, expm(A * time)
    turned = np.exp(roots * time)
    carried = turned.real[:, None] * np.eye(A.shape[1])
    variant, second = np.nonzero(roots.imag < 0)  # each follows the other of its pair
    carried[variant, second - 1, second] = -turned.imag[variant, second]
    carried[variant, second, second - 1] = turned.imag[variant, second]
    return basis, np.linalg.inv(basis), carried


def _scheme(
    system: System, basis: FloatArray, inverse: FloatArray, half: FloatArray, h: float, rows: IntArray
) -> tuple[Any, ...]:
    """Return the matrices of a substep ``h`` for the ``rows`` of G that are felt.

    ``near`` (variant, 3, coordinate): what the one before, the coordinate itself and the next bring to each; where
    others do, too, ``near`` has no entries and ``whole`` serves, columns contiguous.
    """
    whole = half @ half
    B, G = inverse @ system.B, system.G[:, rows] @ basis
    half_B = half @ B
    ahead = np.concatenate([G, G @ half, G @ whole], axis=1)  # (variant, 3 row, coordinate)
    near = np.zeros((len(whole), 3, whole.shape[1]))
    near[:, 0, 1:], near[:, 2, :-1] = (np.diagonal(whole, side, 1, 2) for side in (-1, 1))
    near[:, 1] = np.diagonal(whole, 0, 1, 2)
    if np.triu(whole, 2).any() or np.tril(whole, -2).any():
        near = near[..., :0]
    columns = (basis, whole, h * (G @ B), h * (G @ half_B), h / 6 * (whole @ B), h / 3 * half_B, h / 6 * B)
    return ahead, near, *(np.ascontiguousarray(part.swapaxes(1, 2)) for part in columns)


@_compiled
def _force(tables: FloatArray, row: int, place: float) -> float:
    """Return a ``row``'s value at ``place``, counted in nodes: the cubic through its four nearest nodes (Lagrange)."""
    cell = min(max(int(place), 1), tables.shape[1] - 3)
    t = place - cell
    before, here = tables[row, cell - 1], tables[row, cell]
    after, last = tables[row, cell + 1], tables[row, cell + 2]
    low, high = (t - 1) * (t - 2), (t + 1) * t
    return (low * (3 * here * (t + 1) - before * t) + high * (last * (t - 1) - 3 * after * (t - 2))) * (1 / 6)


@_compiled
def _add_columns(columns: FloatArray, amounts: FloatArray, to: FloatArray) -> None:
    """Add the product of a matrix, given by its ``columns`` (column, entry), and ``amounts``."""
    for j in range(len(amounts)):
        amount = amounts[j]
        for i in range(len(to)):
            to[i] += columns[j, i] * amount


@_compiled
def _marched(
    ahead: FloatArray,
    near: FloatArray,
    basis: FloatArray,
    whole: FloatArray,
    direct: FloatArray,
    delayed: FloatArray,
    first: FloatArray,
    middle: FloatArray,
    last: FloatArray,
    values: FloatArray,
    start: FloatArray,
    history: FloatArray,
    applied: FloatArray,
    reach: FloatArray,
    law_of: IntArray,
    known: FloatArray,
    substeps: int,
) -> bool:
    """Fill ``history`` and ``applied``; return whether no elongation or rate left its table.

    Each row of the tables belongs to a law (``law_of``). The last states are ``known`` at each sample (recording, time,
    known).
    """
    variants, recordings, samples, states = history.shape
    laws, rows = applied.shape[3], len(reach)
    own = states - known.shape[2]  # the states that are not known
    middle_node = (values.shape[2] - 1) / 2
    per_unit = middle_node / reach
    seen, at, f = np.zeros(3 * rows), np.zeros(rows), np.zeros((4, laws))
    z, moved = np.zeros(states), np.zeros(states)
    for variant in range(variants):  # what is picked here need not be picked in the loops below
        ahead_of, below, on, above = ahead[variant], near[variant, 0], near[variant, 1], near[variant, 2]
        by_first, by_middle, by_last = first[variant], middle[variant], last[variant]
        stage_direct, stage_delayed, table = direct[variant], delayed[variant], values[variant]
        shapes, dense = basis[variant], whole[variant]
        for recording in range(recordings):
            z[:] = start[variant, recording]
            for k in range(samples):
                for i in range(own, states):
                    z[i] = known[recording, k, i - own]
                for part in range(substeps):
                    for row in range(3 * rows):
                        total = 0.0
                        for j in range(states):
                            total += ahead_of[row, j] * z[j]
                        seen[row] = total
                    for stage in range(4):
                        place = 0 if stage == 0 else rows if stage < 3 else 2 * rows
                        for row in range(rows):
                            at[row] = seen[place + row]
                            for law in range(laws):
                                if stage == 1:
                                    at[row] += 0.5 * f[0, law] * stage_delayed[law, row]
                                elif stage == 2:
                                    at[row] += 0.5 * f[1, law] * stage_direct[law, row]
                                elif stage == 3:
                                    at[row] += f[2, law] * stage_delayed[law, row]
                        for law in range(laws):
                            f[stage, law] = 0.0
                        for row in range(rows):
                            if not abs(at[row]) <= reach[row]:
                                return False
                            f[stage, law_of[row]] -= _force(table, row, middle_node + at[row] * per_unit[row])
                        if stage == 0 and part == 0:
                            shown = history[variant, recording, k]
                            shown[:] = 0.0
                            _add_columns(shapes, z, shown)
                            applied[variant, recording, k] = f[0]
                            if k == samples - 1:
                                break
                    if k == samples - 1:
                        break
                    if near.shape[2]:
                        for i in range(states):
                            moved[i] = on[i] * z[i]
                        for i in range(1, states):
                            moved[i] += below[i] * z[i - 1]
                        for i in range(states - 1):
                            moved[i] += above[i] * z[i + 1]
                    else:
                        moved[:] = 0.0
                        _add_columns(dense, z, moved)
                    for law in range(laws):
                        begun, between, ended = f[0, law], f[1, law] + f[2, law], f[3, law]
                        for i in range(states):
                            moved[i] += begun * by_first[law, i] + between * by_middle[law, i] + ended * by_last[law, i]
                    z[:] = moved
    return True
