"""Lawson's Runge-Kutta scheme, compiled: matrix exponentials carry the linear part, steps are as long as forces allow.

In coordinates that turn in pairs, so that carrying them on costs little.
"""

from typing import NamedTuple

import numpy as np
from scipy.linalg import expm

from fe_models.arrays import FloatArray, IntArray
from hybrid.compiled import compiled, put_matrix
from hybrid.diagnosis.response.config import MARCHING
from hybrid.diagnosis.response.system import System

LANES = 8  # recordings that go side by side: the sums of a substep wait for each other, not for those of other lanes


class Scheme(NamedTuple):
    """The matrices of a substep, of each variant, in coordinates; those of B by law, columns contiguous.

    ``ahead`` (3 row, coordinate): the felt rows of G now, half a substep ahead and one ahead; ``near`` (3, coordinate):
    what the one before, the coordinate itself and the next bring to each in a substep; where others do, too, it has no
    entries, and ``whole`` (from, to) serves; ``watch`` (watched, coordinate): what is wanted of the motion. ``answer``
    (3, law, row): what forces of each stage but the last move until the next; ``first``, ``middle`` and ``last`` (law,
    coordinate): at the end of the substep.
    """

    ahead: FloatArray
    near: FloatArray
    watch: FloatArray
    whole: FloatArray
    answer: FloatArray
    first: FloatArray
    middle: FloatArray
    last: FloatArray


class SteppingBasis(NamedTuple):
    """What motions are stepped in: their ``basis`` (variant, state, coordinate) and its ``inverse``."""

    basis: FloatArray
    inverse: FloatArray


def scheme_of(system: System, h: float, rows: IntArray, watch: FloatArray, apart: bool) -> tuple[Scheme, SteppingBasis]:
    """Return the scheme of a substep ``h`` (s), and its coordinates, for the ``rows`` of G that are felt and for what
    is wanted of the states, ``watch`` (variant, watched, state).

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
    later = h * (G @ half_B)  # half a substep after they act
    answer = np.stack([later / 2, h / 2 * (G @ B), later], axis=1)  # (variant, stage, row, law)
    columns = (whole, answer, h / 6 * (whole @ B), h / 3 * half_B, h / 6 * B)
    scheme = Scheme(ahead, near, watch @ basis, *(np.ascontiguousarray(part.swapaxes(-2, -1)) for part in columns))
    return scheme, SteppingBasis(basis, inverse)


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
    if not np.isfinite(basis).all() or np.linalg.cond(basis).max() > MARCHING.max_coordinate_condition:
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
def _step_lanes(
    scheme: Scheme,
    values: FloatArray,
    variant: int,
    start: FloatArray,
    final: FloatArray,
    watched: FloatArray,
    applied: FloatArray,
    reach: FloatArray,
    law_of: IntArray,
    known: FloatArray,
    substeps: int,
) -> bool:
    """Do the work of `step_through` for one ``variant`` and a few recordings, each of which is a lane.

    ``scheme`` and ``values``: of all variants; ``start`` and ``final`` (lane, coordinate), ``watched`` and ``applied``
    (lane, sample, ...), ``known`` (lane, time, known). Sums are written out: most functions that are given arrays are
    called by counting who holds these, which takes longer than a sum (with all parts in functions of their own, inlined
    ones, the whole takes a fifth longer).
    """
    ahead, near, whole = scheme.ahead[variant], scheme.near[variant], scheme.whole[variant]
    watch, answer, table = scheme.watch[variant], scheme.answer[variant], values[variant]
    below, on, above = near[0], near[1], near[2]
    first, middle, last = scheme.first[variant], scheme.middle[variant], scheme.last[variant]
    lanes, samples, laws = applied.shape
    rows, states = len(reach), len(whole)
    own = states - known.shape[2]  # the states that are not known
    middle_node = (table.shape[1] - 1) / 2
    per_unit = middle_node / reach
    seen, f = np.zeros((lanes, 3 * rows)), np.zeros((4, lanes, laws))
    # Nothing stands before the first coordinate and after the last, so that all have two neighbours.
    z, moved = np.zeros((lanes, 1 + states + 1)), np.zeros((lanes, 1 + states + 1))
    put_matrix(start, z[:, 1:-1])
    for k in range(samples):
        for lane in range(lanes):
            for i in range(own, states):
                z[lane, 1 + i] = known[lane, k, i - own]
            for row in range(len(watch)):
                value = 0.0
                for i in range(states):
                    value += watch[row, i] * z[lane, 1 + i]
                watched[lane, k, row] = value
        for part in range(substeps):
            for lane in range(lanes):
                for row in range(rows):
                    now, between, then = 0.0, 0.0, 0.0
                    for i in range(states):
                        now += ahead[row, i] * z[lane, 1 + i]
                        between += ahead[rows + row, i] * z[lane, 1 + i]
                        then += ahead[2 * rows + row, i] * z[lane, 1 + i]
                    seen[lane, row], seen[lane, rows + row], seen[lane, 2 * rows + row] = now, between, then
            stages = 4 if k < samples - 1 else 1  # at the last sample the forces there are computed, and no more
            for stage in range(stages):
                for lane in range(lanes):
                    for law in range(laws):
                        f[stage, lane, law] = 0.0
                    for row in range(rows):
                        met = seen[lane, (stage + 1) // 2 * rows + row]
                        if stage > 0:
                            for law in range(laws):
                                met += answer[stage - 1, law, row] * f[stage - 1, lane, law]
                        if not abs(met) <= reach[row]:
                            return False
                        f[stage, lane, law_of[row]] -= _force(table, row, middle_node + met * per_unit[row])
            if part == 0:
                for lane in range(lanes):
                    for law in range(laws):
                        applied[lane, k, law] = f[0, lane, law]
            if k == samples - 1:
                break
            for lane in range(lanes):
                if near.shape[1]:
                    for i in range(states):
                        moved[lane, 1 + i] = below[i] * z[lane, i] + on[i] * z[lane, 1 + i] + above[i] * z[lane, 2 + i]
                else:
                    for i in range(states):
                        moved[lane, 1 + i] = 0.0
                    for j in range(states):
                        amount = z[lane, 1 + j]
                        for i in range(states):
                            moved[lane, 1 + i] += whole[j, i] * amount
                for law in range(laws):
                    begun, between, ended = f[0, lane, law], f[1, lane, law] + f[2, lane, law], f[3, lane, law]
                    for i in range(states):
                        moved[lane, 1 + i] += begun * first[law, i] + between * middle[law, i] + ended * last[law, i]
            z, moved = moved, z
    put_matrix(z[:, 1:-1], final)
    return True


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

    Each row of the tables belongs to a law (``law_of``). The last states are ``known`` at each sample (variant,
    recording, time, known); of one variant where all have the same.
    """
    for v in range(len(start)):
        for begin in range(0, start.shape[1], LANES):
            r = slice(begin, begin + LANES)
            parts = start[v, r], final[v, r], watched[v, r], applied[v, r]
            given = known[min(v, len(known) - 1), r]
            if not _step_lanes(scheme, values, v, *parts, reach, law_of, given, substeps):
                return False
    return True
