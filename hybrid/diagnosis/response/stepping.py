"""Lawson's Runge-Kutta scheme, compiled: matrix exponentials carry the linear part, steps are as long as forces allow.

In coordinates that turn in pairs, so that carrying them on costs little.
"""

from typing import NamedTuple

import numpy as np
from scipy.linalg import expm

from fe_models.dofs import FloatArray, IntArray
from hybrid.diagnosis.response.compiled import compiled
from hybrid.diagnosis.response.system import System

WORST = 1e6  # condition number of coordinates that are still told as well as slopes by finite differences need them


class Scheme(NamedTuple):
    """The matrices of a substep, of each variant, in coordinates; those of B by law, columns contiguous.

    ``ahead`` (3 row, coordinate): the felt rows of G now, half a substep ahead and one ahead; ``near`` (3, coordinate):
    what the one before, the coordinate itself and the next bring to each in a substep; where others do, too, it has no
    entries, and ``whole`` (from, to) serves; ``watch`` (watched, coordinate): what is told of the motion. ``direct``
    and ``delayed`` (law, row): what forces move within the substep; ``first``, ``middle`` and ``last`` (law,
    coordinate): at its end.
    """

    ahead: FloatArray
    near: FloatArray
    watch: FloatArray
    whole: FloatArray
    direct: FloatArray
    delayed: FloatArray
    first: FloatArray
    middle: FloatArray
    last: FloatArray


class Coordinates(NamedTuple):
    """What motions are stepped in: their ``basis`` (variant, state, coordinate) and its ``inverse``."""

    basis: FloatArray
    inverse: FloatArray


def scheme_of(system: System, h: float, rows: IntArray, watch: FloatArray, apart: bool) -> tuple[Scheme, Coordinates]:
    """Return the scheme of a substep ``h`` (s), and its coordinates, for the ``rows`` of G that are felt and for what
    is to be told of the states, ``watch`` (variant, watched, state).

    ``apart``: in coordinates that hardly couple; otherwise in the states themselves, some of which are known.
    """
    basis, inverse, half = (_carried if apart else _same)(system.A, h / 2)
    whole = half @ half
    B, G = inverse @ system.B, system.G[:, rows] @ basis
    half_B = half @ B
    ahead = np.concatenate([G, G @ half, G @ whole], axis=1)  # (variant, 3 row, coordinate)
    near = np.zeros((len(whole), 3, whole.shape[1]))
    near[:, 0, 1:], near[:, 2, :-1] = (np.diagonal(whole, side, 1, 2) for side in (-1, 1))
    near[:, 1] = np.diagonal(whole, 0, 1, 2)
    if np.triu(whole, 2).any() or np.tril(whole, -2).any():
        near = near[..., :0]
    columns = (whole, h * (G @ B), h * (G @ half_B), h / 6 * (whole @ B), h / 3 * half_B, h / 6 * B)
    scheme = Scheme(ahead, near, watch @ basis, *(np.ascontiguousarray(part.swapaxes(1, 2)) for part in columns))
    return scheme, Coordinates(basis, inverse)


def _same(A: FloatArray, time: float) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Return the states as coordinates, as `_carried` does."""
    same = np.broadcast_to(np.eye(A.shape[1]), A.shape)
    return same, same, np.asarray(expm(A * time))


def _carried(A: FloatArray, time: float) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Return coordinates (variant, state, coordinate) that hardly couple, their inverse, and what carries them on for a
    ``time`` (s).

    They are the real and imaginary parts of eigenvectors, and turn in pairs; the states themselves where eigenvectors
    fall together.
    """
    roots, vectors = np.linalg.eig(A)
    basis = np.where(roots.imag[:, None] < 0, -vectors.imag, vectors.real)
    if not np.isfinite(basis).all() or np.linalg.cond(basis).max() > WORST:
        return _same(A, time)
    turned = np.exp(roots * time)
    carried = turned.real[:, None] * np.eye(A.shape[1])
    variant, second = np.nonzero(roots.imag < 0)  # each follows the other of its pair
    carried[variant, second - 1, second] = -turned.imag[variant, second]
    carried[variant, second, second - 1] = turned.imag[variant, second]
    return basis, np.linalg.inv(basis), carried


@compiled
def _force(tables: FloatArray, row: int, place: float) -> float:
    """Return a ``row``'s value at ``place``, counted in nodes: the cubic through its four nearest nodes (Lagrange)."""
    cell = min(max(int(place), 1), tables.shape[1] - 3)
    t = place - cell
    before, here = tables[row, cell - 1], tables[row, cell]
    after, last = tables[row, cell + 1], tables[row, cell + 2]
    low, high = (t - 1) * (t - 2), (t + 1) * t
    return (low * (3 * here * (t + 1) - before * t) + high * (last * (t - 1) - 3 * after * (t - 2))) * (1 / 6)


@compiled
def _multiply_columns(columns: FloatArray, amounts: FloatArray, to: FloatArray) -> None:
    """Set the product of a matrix, given by its ``columns`` (column, entry), and ``amounts``."""
    to[:] = 0.0
    for j in range(len(amounts)):
        amount = amounts[j]
        for i in range(len(to)):
            to[i] += columns[j, i] * amount


@compiled
def _multiply(matrix: FloatArray, vector: FloatArray, to: FloatArray) -> None:
    """Set the product of a matrix and a vector."""
    for i in range(len(to)):
        total = 0.0
        for j in range(len(vector)):
            total += matrix[i, j] * vector[j]
        to[i] = total


@compiled
def _multiply_near(below: FloatArray, on: FloatArray, above: FloatArray, vector: FloatArray, to: FloatArray) -> None:
    """Set the product of a matrix that has entries ``on`` its diagonal and next to it alone, and a vector."""
    for i in range(len(to)):
        to[i] = on[i] * vector[i]
    for i in range(1, len(to)):
        to[i] += below[i] * vector[i - 1]
    for i in range(len(to) - 1):
        to[i] += above[i] * vector[i + 1]


@compiled
def _meet(stage: int, seen: FloatArray, f: FloatArray, direct: FloatArray, delayed: FloatArray, at: FloatArray) -> None:
    """Set ``at`` (row,), what the laws meet at a ``stage`` of four: ``seen`` (time of three times row,) of the motion
    without them, and what the forces ``f`` (stage, law) before did at once (``direct``) or half a step ago.
    """
    rows = len(at)
    place = 0 if stage == 0 else rows if stage < 3 else 2 * rows
    for row in range(rows):
        at[row] = seen[place + row]
        for law in range(f.shape[1]):
            if stage == 1:
                at[row] += 0.5 * f[0, law] * delayed[law, row]
            elif stage == 2:
                at[row] += 0.5 * f[1, law] * direct[law, row]
            elif stage == 3:
                at[row] += f[2, law] * delayed[law, row]


@compiled
def step_through(
    scheme: Scheme,
    values: FloatArray,
    start: FloatArray,
    final: FloatArray,
    watched: FloatArray,
    applied: FloatArray,
    reach: FloatArray,
    law_of: IntArray,
    known: FloatArray,
    substeps: int,
) -> bool:
    """Fill ``watched`` and ``applied`` (variant, recording, sample, ...) and ``final``, the last sample's coordinates,
    from those of ``start`` (variant, recording, coordinate); return whether no elongation or rate left its table.

    Each row of the tables belongs to a law (``law_of``). The last states are ``known`` at each sample (recording, time,
    known).
    """
    variants, recordings, samples, laws = applied.shape
    states, rows = start.shape[2], len(reach)
    own = states - known.shape[2]  # the states that are not known
    middle_node = (values.shape[2] - 1) / 2
    per_unit = middle_node / reach
    seen, at, f = np.zeros(3 * rows), np.zeros(rows), np.zeros((4, laws))
    z, moved = np.zeros(states), np.zeros(states)
    for variant in range(variants):  # what is picked here need not be picked in the loops below
        ahead, near = scheme.ahead[variant], scheme.near[variant]
        below, on, above = near[0], near[1], near[2]
        first, middle, last = scheme.first[variant], scheme.middle[variant], scheme.last[variant]
        direct, delayed, table = scheme.direct[variant], scheme.delayed[variant], values[variant]
        watch, whole = scheme.watch[variant], scheme.whole[variant]
        for recording in range(recordings):
            z[:] = start[variant, recording]
            for k in range(samples):
                for i in range(own, states):
                    z[i] = known[recording, k, i - own]
                for part in range(substeps):
                    _multiply(ahead, z, seen)
                    for stage in range(4):
                        _meet(stage, seen, f, direct, delayed, at)
                        for law in range(laws):
                            f[stage, law] = 0.0
                        for row in range(rows):
                            if not abs(at[row]) <= reach[row]:
                                return False
                            f[stage, law_of[row]] -= _force(table, row, middle_node + at[row] * per_unit[row])
                        if stage == 0 and part == 0:
                            _multiply(watch, z, watched[variant, recording, k])
                            applied[variant, recording, k] = f[0]
                            if k == samples - 1:
                                break
                    if k == samples - 1:
                        break
                    if near.shape[1]:
                        _multiply_near(below, on, above, z, moved)
                    else:
                        _multiply_columns(whole, z, moved)
                    for law in range(laws):
                        begun, between, ended = f[0, law], f[1, law] + f[2, law], f[3, law]
                        for i in range(states):
                            moved[i] += begun * first[law, i] + between * middle[law, i] + ended * last[law, i]
                    z[:] = moved
            final[variant, recording] = z
    return True
