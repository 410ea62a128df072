"""Fits of a hypothesis: Gauss-Newton with the initial states projected out and the user's uncertainties as priors.

Minimises sum of squares of (y - y(theta, z0)) / sigma plus those of (theta - centre) / width. Where the channels are
linear in the initial states z0 they are solved for at each theta (variable projection); where force laws act, z0 and
theta move together, z0 eliminated from the normal equations by a QR factorisation of its part of the Jacobian.
"""

from dataclasses import dataclass
from math import inf

import numpy as np

from fe_models.dofs import FloatArray, IntArray
from fe_models.recordings import Sensor
from hybrid.diagnosis.hypothesis import Hypothesis
from hybrid.diagnosis.records import Batch
from hybrid.diagnosis.system import channels, drift, drifted, march, observability, respond
from hybrid.diagnosis.tangent import channels_near

STEP = 1e-3  # of a prior width (of the rms of a state): the finite differences of the Jacobian
RIDGE = 1e-6  # of the largest column of the initial state's Jacobian: what no sensor feels stays at rest
ITERATIONS = 12
LAW_ITERATIONS = 8  # with force laws, each of which takes a simulation of all variants
ENOUGH = 0.05  # the fall in the sum of squares (a chi-square) below which a fit has converged, for each of noise's own
WEAKER = (1.0, 0.5, 0.2)  # of force laws, one after the other, where the motion from the start grows for ever
FREE = 1e-10  # of Marquardt's damping: none; a cause and the uncertain factor it resembles need whole steps
FARTHEST = 3.0  # of a log factor: twenty times as much or as little is no calibration
EXPLODED = 1e30  # of a channel, in units of its noise: no structure, but a search gone astray
DAMPING = (1e-3, 30.0, 1e3)  # where a whole step fails: first, factor, give up


@dataclass(frozen=True)
class Frame:
    """What all fits of a dataset share: the fitted ``sensors``, ``rate`` (Hz), and ``sigma`` (sensor,) of the noise."""

    sensors: tuple[Sensor, ...]
    rate: float
    sigma: FloatArray

    @property
    def positions(self) -> tuple[int, ...]:
        """Each sensor's position among the measured ones: its own."""
        return tuple(range(len(self.sensors)))


@dataclass(frozen=True)
class Linearisation:
    """One batch at one theta, in units of sigma and projected orthogonally to what initial states can do.

    ``residual`` (recording, value), ``slopes`` (parameter, recording, value); ``states`` z0 (recording, state) and how
    they move with theta, ``state_slopes`` (parameter, recording, state); ``state_step`` (recording, state) the move
    that the residual asks for; ``raw`` (recording, time, sensor) the residual itself; ``basis`` what was projected out;
    ``path`` (time, recording, state) the motion, empty where it is linear; ``state_errors`` (recording, state) standard
    deviations of z0 at this theta.
    """

    residual: FloatArray
    slopes: FloatArray
    states: FloatArray
    state_slopes: FloatArray
    state_step: FloatArray
    raw: FloatArray
    basis: FloatArray
    path: FloatArray
    state_errors: FloatArray


@dataclass(frozen=True)
class Fit:
    """The best theta (parameter,) of a hypothesis, its ``covariance``, and what is left.

    ``chi2``: sum of squares of the data alone, ``cost`` with the prior. ``states`` and ``residuals`` (in units of
    sigma): one array (recording, ...) for each batch. ``batches``: what was fitted. ``state_errors``: standard
    deviations (recording, state) at this theta, and ``state_slopes`` (parameter, recording, state), for each batch.
    """

    hypothesis: Hypothesis
    theta: FloatArray
    covariance: FloatArray
    chi2: float
    cost: float
    states: tuple[FloatArray, ...]
    residuals: tuple[FloatArray, ...]
    batches: tuple[Batch, ...]
    state_errors: tuple[FloatArray, ...]
    state_slopes: tuple[FloatArray, ...]

    @property
    def values(self) -> float:
        """Number of data, as independent as those of white noise: a low-pass leaves fewer."""
        return sum(part.size * batch.share for part, batch in zip(self.residuals, self.batches, strict=True))

    @property
    def log_evidence(self) -> float:
        """Laplace's approximation: the fit, and how much of the prior of the candidates' parameters is left.

        The initial states are the same for all hypotheses but for the two of a harmonic force in each recording; their
        prior is a normal distribution as wide as the force that was found.
        """
        first = self.hypothesis.nuisances
        own = self.covariance[first:, first:]
        occam = (
            0.5 * np.linalg.slogdet(own)[1] - float(np.log(self.hypothesis.width[first:]).sum()) if len(own) else 0.0
        )
        motion = 2 * self.hypothesis.size
        for number in range(sum(candidate.oscillator for candidate in self.hypothesis.candidates)):
            entries = slice(motion + 2 * number, motion + 2 * number + 2)
            waves = np.concatenate([states[:, entries] for states in self.states])
            errors = np.concatenate([part[:, entries] for part in self.state_errors])
            square = np.mean(waves**2) + 1e-300
            occam -= 0.5 * float(np.sum(np.log1p(square / errors**2) + waves**2 / square))
        return -0.5 * self.cost + float(occam)


def linearise_batch(
    hypothesis: Hypothesis,
    theta: FloatArray,
    batch: Batch,
    frame: Frame,
    states: FloatArray | None,
    slopes: bool = True,
    path: FloatArray | None = None,
) -> Linearisation | None:
    """Return the linearisation of one batch, None where the motion grows beyond all bounds.

    ``states`` (recording, state) is needed where force laws act; elsewhere it is solved for. ``path``: the motion from
    there, where it is known already.
    """
    hypothesis, kept = _acting(hypothesis, batch)
    own = theta[kept]
    moved = STEP * hypothesis.width
    thetas = np.vstack([own, own + np.diag(moved)]) if slopes else own[None]
    recordings, samples, _ = batch.data.shape
    weight = np.tile(1 / frame.sigma, samples)  # (value,)
    data = batch.data.reshape(recordings, -1) * weight
    if hypothesis.is_linear:
        system = hypothesis.system(thetas, frame.sensors, frame.rate, frame.positions)
        first = observability(system.only(0), samples).reshape(-1, hypothesis.states) * weight[:, None]
        lines = drift(system, samples).reshape(len(thetas), -1) * weight  # (variant, value)
        if not np.abs(first).max() < EXPLODED:
            return None
        basis, upper = orthonormal(first)
        late = drifted(system, batch.begins)
        wanted = data - lines[0] - (late[0] + np.zeros(batch.data.shape)).reshape(recordings, -1) * weight
        z = np.linalg.solve(upper, basis.T @ wanted.T).T  # (recording, state)
        residual = wanted - z @ first.T
        shown = respond(system, np.broadcast_to(z, (len(thetas), *z.shape)), samples) + late
        shown = shown.reshape(len(thetas), recordings, -1) * weight
        change = (shown[1:] - shown[0]) / moved[: len(shown) - 1, None, None]  # (parameter, recording, value)
        inside = change @ basis  # (parameter, recording, state)
        projected = change - inside @ basis.T
        state_slopes = -np.linalg.solve(upper, inside[..., None])[..., 0]
        step = np.zeros_like(z)
        raw = residual.reshape(batch.data.shape)
    else:
        assert states is not None
        z = states
        system = hypothesis.system(own[None], frame.sensors, frame.rate, frame.positions)
        if path is None:
            marched = march(system, z[None], samples)
            if marched is None:
                return None
            path = marched[0][:, 0]
            y = channels(system, marched)[0] + drifted(system, batch.begins)[0]
            if not np.isfinite(y).all() or np.abs(y / frame.sigma).max() > 1e6 * np.abs(data).max():
                return None
            if not slopes:
                residual = data - y.reshape(recordings, -1) * weight
                nothing = np.zeros((0, recordings, 0))
                raw = residual.reshape(batch.data.shape)
                still = np.zeros_like(z)
                return Linearisation(residual, nothing, z, nothing, still, raw, np.zeros((0, 0)), path, still)
        variants = len(thetas)
        size = STEP * np.maximum(np.sqrt(np.mean(z**2, axis=0)), 1e-12)
        thetas = np.vstack([thetas, np.repeat(own[None], hypothesis.states, axis=0)])
        system = hypothesis.system(thetas, frame.sensors, frame.rate, frame.positions)
        near = channels_near(system, path, size)
        if near is None:
            return None
        near = near + drifted(system, batch.begins)
        y = near.reshape(len(thetas), recordings, -1) * weight
        residual = data - y[0]
        raw = residual.reshape(batch.data.shape)
        change = (y[1:variants] - y[0]) / moved[:, None, None]
        by_state = ((y[variants:] - y[0]) / size[:, None, None]).transpose(1, 2, 0)  # (recording, value, state)
        basis, upper = orthonormal(by_state)
        inside = np.einsum("prv,rvs->prs", change, basis, optimize=True)
        projected = change - np.einsum("prs,rvs->prv", inside, basis, optimize=True)
        along = np.einsum("rv,rvs->rs", residual, basis)
        step = np.linalg.solve(upper, along[..., None])[..., 0]
        state_slopes = -np.linalg.solve(upper, inside[..., None])[..., 0]
        residual = residual - np.einsum("rs,rvs->rv", along, basis)
    return Linearisation(
        residual,
        _spread(projected, kept, len(theta)),
        z,
        _spread(state_slopes, kept, len(theta)),
        step,
        raw,
        basis,
        np.zeros((0, *z.shape)) if path is None else path,
        np.broadcast_to(np.linalg.norm(np.linalg.inv(upper), axis=-1), z.shape),
    )


def _acting(hypothesis: Hypothesis, batch: Batch) -> tuple[Hypothesis, IntArray]:
    """Return the hypothesis with those candidates that act in the batch, and the indices of its parameters."""
    if not batch.off:
        return hypothesis, np.arange(len(hypothesis.centre))
    on = [i for i in range(len(hypothesis.candidates)) if i not in batch.off]
    kept = [*range(hypothesis.nuisances)] + [k for i in on for k in range(len(hypothesis.centre))[hypothesis.slices[i]]]
    return Hypothesis(hypothesis.plant, tuple(hypothesis.candidates[i] for i in on)), np.array(kept)


def _spread(part: FloatArray, kept: IntArray, parameters: int) -> FloatArray:
    """Return slopes (parameter, ...) by all parameters from those by the ``kept`` ones."""
    if len(part) == parameters or len(part) == 0:
        return part
    full = np.zeros((parameters, *part.shape[1:]))
    full[kept] = part
    return full


def orthonormal(columns: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Return Q and R of columns (..., value, state), with a ridge below them that keeps R from being singular."""
    ridge = RIDGE * np.linalg.norm(columns, axis=-2).max()
    states = columns.shape[-1]
    below = np.broadcast_to(ridge * np.eye(states), (*columns.shape[:-2], states, states))
    Q, R = np.linalg.qr(np.concatenate([columns, below], axis=-2))
    return Q[..., :-states, :], R


def fit(
    hypothesis: Hypothesis,
    theta: FloatArray,
    batches: tuple[Batch, ...],
    frame: Frame,
    states: tuple[FloatArray, ...] | None = None,
    iterations: int = ITERATIONS,
    enough: float = ENOUGH,
    bound: float = inf,
) -> Fit | None:
    """Return the best fit from ``theta`` (parameter,) by Levenberg and Marquardt; None where no start is possible.

    ``states``: where initial states begin, one array (recording, state) for each batch, needed with force laws. A fit
    that would not get below the cost ``bound``, even if every step to come brought as much as the last, is broken off.
    """
    centre, width, lower = hypothesis.centre, hypothesis.width, hypothesis.lower
    current, whole = None, theta
    for share in WEAKER:
        theta = np.maximum(_weakened(hypothesis, whole, share), lower)
        current = _linearise_all(hypothesis, theta, batches, frame, states)
        if current is not None:
            break
    if current is None:
        return None
    cost = _cost(current, theta, centre, width)
    values = sum(batch.data.size for batch in batches)
    first, factor, most = DAMPING
    damping = FREE
    iterations = iterations if hypothesis.is_linear else min(iterations, LAW_ITERATIONS)
    for number in range(iterations):
        J = np.concatenate([part.slopes.reshape(len(theta), -1) for part in current], axis=1)
        r = np.concatenate([part.residual.ravel() for part in current])
        H = J @ J.T + np.diag(1 / width**2)
        gradient = J @ r - (theta - centre) / width**2
        gain = inf
        while damping < most:
            step = np.linalg.solve(H + damping * np.diag(np.diag(H)), gradient)
            trial = np.maximum(theta + step, lower)
            trial[: hypothesis.nuisances] = np.clip(trial[: hypothesis.nuisances], -FARTHEST, FARTHEST)
            step = trial - theta
            moved = [
                part.states + part.state_step + np.einsum("p,prs->rs", step, part.state_slopes) for part in current
            ]
            then = _linearise_all(hypothesis, trial, batches, frame, tuple(moved), slopes=hypothesis.is_linear)
            new = inf if then is None else _cost(then, trial, centre, width)
            if then is not None and new <= cost:
                if not hypothesis.is_linear:  # the slopes take far longer, and are not needed of a step that fails
                    then = _linearise_all(hypothesis, trial, batches, frame, tuple(moved), found=then)
                if then is None:
                    damping = most
                    break
                gain, theta, current, cost = cost - new, trial, then, new
                damping = damping / factor if damping > first else FREE
                break
            damping = max(damping * factor, first)
        if (
            gain < enough * max(1.0, cost / values)
            or damping >= most
            or cost - (iterations - 1 - number) * gain > bound
        ):
            break
    J = np.concatenate([part.slopes.reshape(len(theta), -1) for part in current], axis=1)
    H = J @ J.T + np.diag(1 / width**2)
    chi2 = sum(float(np.square(part.raw).sum()) for part in current)
    return Fit(
        hypothesis,
        theta,
        np.linalg.inv(H),
        chi2,
        cost,
        tuple(part.states for part in current),
        tuple(part.raw for part in current),
        batches,
        tuple(part.state_errors for part in current),
        tuple(part.state_slopes for part in current),
    )


def _weakened(hypothesis: Hypothesis, theta: FloatArray, share: float) -> FloatArray:
    """Return theta with a ``share`` of each candidate's force law: motions of a softening spring may grow for ever."""
    weaker = theta.copy()
    for candidate, part in zip(hypothesis.candidates, hypothesis.slices, strict=True):
        if candidate.is_law:
            neutral = candidate.neutral[0]
            weaker[part.start] = neutral + share * (theta[part.start] - neutral)
    return weaker


def _linearise_all(
    hypothesis: Hypothesis,
    theta: FloatArray,
    batches: tuple[Batch, ...],
    frame: Frame,
    states: tuple[FloatArray, ...] | None,
    slopes: bool = True,
    found: tuple[Linearisation, ...] | None = None,
) -> tuple[Linearisation, ...] | None:
    """Return the linearisations of all batches, None where one fails; ``found``: those without slopes, with motions."""
    parts = []
    for number, batch in enumerate(batches):
        own = None if states is None else states[number]
        path = None if found is None else found[number].path
        try:
            part = linearise_batch(hypothesis, theta, batch, frame, own, slopes, path)
        except np.linalg.LinAlgError:  # masses that are not positive: a step too far
            return None
        if part is None:
            return None
        parts.append(part)
    return tuple(parts)


def _cost(parts: tuple[Linearisation, ...], theta: FloatArray, centre: FloatArray, width: FloatArray) -> float:
    data = sum(float(np.square(part.raw).sum()) for part in parts)
    return data + float(np.sum(((theta - centre) / width) ** 2))
