"""Motion under force laws: how finely to step, the laws as tables, and what the sensors show of it.

Every law is a function of elongation plus one of rate; both are tabulated: so one compiled loop (`stepping`) serves all
laws, each defined where it belongs (`fe_models.causes`).
"""

from dataclasses import dataclass, replace
from itertools import pairwise
from math import ceil

import numpy as np
from scipy.linalg import expm

from fe_models.arrays import FloatArray, IntArray
from fe_models.interpolant import ORDERS
from hybrid.diagnosis.config import THREADS
from hybrid.diagnosis.nominal.loads import Loads
from hybrid.diagnosis.nominal.nominal_model import NominalModel
from hybrid.diagnosis.parallel import parallel_map
from hybrid.diagnosis.response.config import MARCHING
from hybrid.diagnosis.response.loaded import loaded_channels, loaded_states
from hybrid.diagnosis.response.residual_states import with_residual, with_residual_states
from hybrid.diagnosis.response.stepping import Scheme, scheme_of, step_through
from hybrid.diagnosis.response.system import System, drift, linear_channels, through_lowpass, with_sensor_faults

PROBED_SIZES = 10.0 ** np.arange(-12, 13)  # m, m/s: a law that answers to none of them does not depend on it


def is_too_fast(nominal: NominalModel) -> bool:
    """Return whether between two samples the structure moves too fast to follow under force laws."""
    no_lowpass = nominal.lowpass is None or nominal.loaded  # see `respond`, and `state_space` of loads
    step = 1 / nominal.rate / (1 if no_lowpass else MARCHING.oversampling)
    return float(nominal.modes[0][-1]) * step > MARCHING.max_substeps * MARCHING.max_phase_per_substep


@dataclass(frozen=True)
class Marched:
    """What was ``watched`` of a motion, (variant, recording, time, watched), and ``forces`` -f, (variant, recording,
    time, law): its states, or C z for each sensor, without what forces show at once.

    States (variant, recording, state) at its ``first`` and ``last`` sample, those of residual coordinates last.
    """

    watched: FloatArray
    forces: FloatArray
    first: FloatArray
    last: FloatArray


@dataclass(frozen=True)
class _Tables:
    """Force laws as tables: of the elongations and rates (2 law,) those ``rows`` (row,) that any law depends on.

    ``values`` (variant, row, node) of a force from -``reach`` to ``reach`` (row,).
    """

    values: FloatArray
    reach: FloatArray
    rows: IntArray


def _tables(system: System, reach: FloatArray) -> _Tables:
    """Return the tables of a system's laws for elongations and rates up to ``reach`` (2 law,)."""
    felt = _values(system, np.append(-PROBED_SIZES, PROBED_SIZES), np.ones_like(reach))
    rows = np.flatnonzero(np.abs(felt).max(axis=(0, 2)))
    values = _values(system, np.linspace(-1, 1, MARCHING.table_intervals + 1), reach)
    return _Tables(np.ascontiguousarray(values[:, rows]), reach[rows], rows)


def _values(system: System, at: FloatArray, reach: FloatArray) -> FloatArray:
    """Return forces (variant, 2 law, value) of elongations, then of rates: ``at`` (value,) times ``reach`` (2 law,)."""
    variants, laws = len(system.A), len(system.forces)
    values, still = np.zeros((variants, 2 * laws, len(at))), np.zeros((variants, len(at)))
    with np.errstate(over="ignore", invalid="ignore"):
        for number, force in enumerate(system.forces):
            for row, pair in ((number, (1, 0)), (laws + number, (0, 1))):
                moved = np.broadcast_to(reach[row] * at, still.shape)
                values[:, row] = force(moved if pair[0] else still, moved if pair[1] else still)
    return values


def march(
    system: System,
    start: FloatArray,
    samples: int,
    loads: Loads | None = None,
    only_channels: bool = False,
    step_ratio: int = 1,
) -> Marched | None:
    """Return the motion from ``start`` (variant, recording, state), None where it explodes: all states, or
    ``only_channels``, what the system's C picks of them, which are far fewer. ``step_ratio``: so many times as long as
    needed are the system's steps, for slopes alone: modes may turn that much further in a substep, and a law that is
    sharp takes that many times as many.

    Of ``loads`` for fewer recordings all act again and again.

    Order 4; only the elongations are needed within a substep, so that all four stages cost one product with the state.
    Known ``loads`` and their derivatives are carried as states that each sample sets anew, so that the linear part
    stays exact.
    """
    start, system = with_residual_states(system, start), with_residual(system)
    fastest = float(np.abs(np.linalg.eigvals(system.A[0])).max())
    substeps = max(MARCHING.min_substeps, ceil(fastest * system.step / (step_ratio * MARCHING.max_phase_per_substep)))
    if substeps > MARCHING.max_substeps or not np.isfinite(start).all():  # no structure, but a search gone astray
        return None
    reach = _reach(system, start, loads)
    tables = _tables(system, reach)
    sharp, stiff = (rate * system.step for rate in _sharpest(system, tables))
    if not np.isfinite(sharp):  # forces beyond all bounds: likewise
        return None
    if loads is not None:
        turn = np.hypot(fastest * system.step, stiff) / (step_ratio * MARCHING.max_phase_under_loads)
        substeps = max(substeps, ceil(min(turn, step_ratio * MARCHING.max_sharp_substeps)))
    fine = max(
        min(sharp, step_ratio * MARCHING.max_sharp_substeps),
        min(sharp / MARCHING.max_rate_per_substep, step_ratio * MARCHING.max_stabilising_substeps),
    )
    substeps = max(substeps, ceil(fine))
    variants, recordings, states = start.shape
    watch = system.C if only_channels else np.broadcast_to(np.eye(states), (variants, states, states))
    known = np.zeros((1, recordings, samples, 0))
    if loads is not None:
        system, known = _with_loads(system, _repeated(loads, recordings))
    whole, watch = (np.pad(part, ((0, 0), (0, 0), (0, known.shape[3]))) for part in (start, watch))
    watched = np.empty((variants, recordings, samples, watch.shape[1]))
    applied = np.empty((variants, recordings, samples, len(system.forces)))
    scheme, coordinates = scheme_of(system, system.step / substeps, tables.rows, watch, apart=loads is None)
    begun = np.ascontiguousarray(whole @ coordinates.inverse.swapaxes(1, 2))
    final = np.empty_like(begun)
    for _ in range(MARCHING.max_ranges):
        motion = begun, final, watched, applied
        if _all_stepped(scheme, tables, motion, tables.rows % len(system.forces), known, substeps):
            return Marched(watched, applied, start, (final @ coordinates.basis.swapaxes(1, 2))[..., :states])
        reach = reach * MARCHING.widening_ratio
        tables = _tables(system, reach)
    return None


def _all_stepped(
    scheme: Scheme, tables: _Tables, motion: tuple[FloatArray, ...], law_of: IntArray, known: FloatArray, substeps: int
) -> bool:
    """Return whether all variants stay within their tables: threads share them or, of one, the recordings.

    ``motion``: the arrays (variant, recording, ...) of `step_through`.
    """
    variants, recordings = motion[0].shape[:2]
    whole = slice(None)

    def stepped(bounds: tuple[int, int]) -> bool:
        share = slice(*bounds)
        v, r = (share, whole) if variants > 1 else (whole, share)
        own, parts = Scheme(*(part[v] for part in scheme)), (part[v, r] for part in motion)
        given = known[v if len(known) > 1 else whole, r]
        return bool(step_through(own, tables.values[v], *parts, tables.reach, law_of, given, substeps))

    bounds = np.unique(np.linspace(0, variants if variants > 1 else recordings, THREADS.motions + 1).astype(int))
    return all(parallel_map(stepped, pairwise(bounds.tolist())))


def _repeated(loads: Loads, recordings: int) -> Loads:
    """Return the loads of as many ``recordings``: of fewer all, again and again."""
    return loads.take(np.arange(recordings) % len(loads.rows))


def _with_loads(system: System, loads: Loads) -> tuple[System, FloatArray]:
    """Return a system whose states end with the loads' courses, and what these are, (variant, recording, time, course);
    of one variant alone where the same acts in all.
    """
    entry = system.loads
    assert entry is not None  # a nominal model knows its dataset's loads
    acting = np.stack([entry.acting(loads, variant) for variant in range(1 if entry.is_alike else len(system.B))])
    variants, states, laws = system.B.shape
    own, places = entry.feed.shape[1], len(entry.places)
    more = ORDERS * places
    A = np.zeros((variants, states + more, states + more))
    A[:, :states, :states] = system.A
    A[:, :own, states : states + places] = entry.feed
    A[:, range(states, states + more - places), range(states + places, states + more)] = 1.0  # each order's derivative
    G = np.pad(system.G, ((0, 0), (0, 0), (0, more)))
    G[:, :laws, states:] = entry.stretch.transpose(1, 0, 2).reshape(laws, more)
    G[:, laws:, states + places :] = G[:, :laws, states:-places]  # rates: each order's derivative
    known = acting.transpose(0, 2, 3, 1, 4).reshape(len(acting), *acting.shape[2:4], more)
    return replace(system, A=A, B=np.pad(system.B, ((0, 0), (0, more), (0, 0))), G=G), np.ascontiguousarray(known)


def _sharpest(system: System, tables: _Tables) -> tuple[float, float]:
    """Return the largest rate (1/s) at which a law would bring its own place to rest, where friction holds it, or turn
    it back, as a stiff stop does; and the largest at which one turns it back.
    """
    laws = len(system.forces)
    mobility = np.abs(np.einsum("ls,sl->l", system.G[0, laws:], system.B[0]))  # acceleration by a unit force
    intervals = MARCHING.table_intervals
    reached = tables.values[0, :, intervals // 4 : -intervals // 4]  # half of the tables' range, as far as motions go
    with np.errstate(over="ignore", invalid="ignore"):
        slopes = np.abs(np.diff(reached, axis=1)).max(axis=1) * intervals / (2 * tables.reach)
    square = slopes * mobility[tables.rows % laws]
    turning = np.sqrt(square[tables.rows < laws]).max(initial=0.0)
    return float(max(turning, square[tables.rows >= laws].max(initial=0.0))), float(turning)


def respond(
    system: System,
    start: FloatArray,
    samples: int,
    loads: Loads | None = None,
    oversampling: int = MARCHING.oversampling,
) -> FloatArray:
    """Return the channels (variant, recording, time, sensor) from initial states (variant, recording, state) under
    known ``loads``.

    NaN where the motion grows beyond all bounds. What contacts make beyond half the sampling rate a low-pass took away
    before the recording was sampled: it acts on a motion that is computed ``oversampling`` times as often. Once is
    enough for slopes, where sharp laws are stepped as finely nevertheless; without a low-pass it is once.
    """
    if system.is_linear:
        y = linear_channels(system, start, samples) + drift(system, samples)[:, None]
        return y if loads is None else y + loaded_channels(system, loads)
    if system.lowpass is None:
        oversampling, step_ratio = 1, 1
    else:
        step_ratio = max(1, MARCHING.oversampling // oversampling)
    fine = replace(system, step=system.step / oversampling)
    marched = march(fine, start, oversampling * samples, loads, only_channels=True, step_ratio=step_ratio)
    if marched is None:
        return np.full((*start.shape[:2], samples, system.C.shape[1]), np.nan)
    y = with_sensor_faults(fine, _channels(fine, marched, loads))  # late sensors are interpolated between samples
    return y[:, :, ::oversampling]


def _channels(system: System, marched: Marched, loads: Loads | None) -> FloatArray:
    """Return the channels (variant, recording, time, sensor) of what `march` returns of them under known ``loads``, as
    sensors without fault show them. No low-pass acts under known loads: see `state_space`.
    """
    system = with_residual(system)
    with np.errstate(over="ignore", invalid="ignore"):
        y = marched.forces @ system.D[:, None].swapaxes(2, 3)
        y += marched.watched
        if loads is not None and system.loads is not None:
            entry, acting = system.loads, _repeated(loads, y.shape[1])
            courses = entry.acting(acting, 0)
            for variant, own in enumerate(y):
                if not entry.is_alike:
                    courses = entry.acting(acting, variant)
                own += np.einsum("sl,rtl->rts", entry.direct[variant], courses[0])
                own += np.einsum("osl,ortl->rts", entry.bent, courses)
        if system.lowpass is not None:
            y = through_lowpass(
                y,
                system,
                _free(system, marched.first, -1)[:, :, ::-1],
                _free(system, marched.last, 1),
            )
    return y


def _free(system: System, states: FloatArray, sign: int) -> FloatArray:
    """Return what the sensors would show, (variant, recording, time, sensor), as far as the low-pass reaches after
    ``states`` (variant, recording, state), or before them with ``sign`` -1, if no law acted.
    """
    assert system.lowpass is not None  # its caller has seen to that
    turn, C = expm(sign * system.step * system.A).swapaxes(1, 2), system.C.swapaxes(1, 2)
    shown = []
    for _ in range(system.lowpass.settled(1 / system.step)):
        states = states @ turn
        shown.append(states @ C)
    return np.stack(shown, axis=2)


def _reach(system: System, start: FloatArray, loads: Loads | None) -> FloatArray:
    """Return elongations and rates (2 law,) twice as large as without the forces the first variant could reach.

    Of a body that nothing holds: twice those that it begins with.
    """
    vectors = np.linalg.eig(system.A[0])[1]
    with np.errstate(all="ignore"):
        amplitudes = np.abs(np.linalg.pinv(vectors) @ start[0].T)  # (mode, recording)
        most = (np.abs(system.G[0] @ vectors) @ amplitudes).max(axis=1)
        most = np.maximum(most, np.abs(system.G[0] @ start[0].T).max(axis=1))
        if loads is not None:
            most = most + np.abs(loaded_states(system, loads) @ system.G[0].T).max(axis=(0, 1))
    return np.maximum(MARCHING.range_ratio * most, np.finfo(float).tiny ** 0.25)
