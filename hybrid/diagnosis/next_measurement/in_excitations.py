"""What hypotheses of the search by time series expect of one more recording of the present sensors: after a pull at a
node is let go, from a state that nobody knows, or after the blow of a hammer that measures its force, from rest.

Both are free decays: from the static displacements under the pull, z = -A^-1 b, or from the velocities that the blow
leaves, z = b, where b is what a unit of force there adds to the rates of the state.
"""

from dataclasses import replace
from typing import cast

import numpy as np

from fe_models.arrays import FloatArray
from fe_models.structure import Direction
from hybrid.diagnosis.fitting.least_squares import Fit
from hybrid.diagnosis.next_measurement.config import EXCITATIONS
from hybrid.diagnosis.next_measurement.in_recordings import Surroundings, largest_states
from hybrid.diagnosis.next_measurement.information import Prediction
from hybrid.diagnosis.next_measurement.measurements import Measurement
from hybrid.diagnosis.next_measurement.motion import NearFit
from hybrid.diagnosis.response.system import System, linear_channels


def considered(places: list[tuple[int, Direction]]) -> tuple[Measurement, ...]:
    """Return pulls and blows at some of the places, evenly spread among them."""
    kept = np.unique(np.linspace(0, len(places) - 1, min(EXCITATIONS.max_places, len(places))).round().astype(int))
    return tuple(Measurement(kind, *places[int(i)]) for kind in ("pull", "hammer") for i in kept)


def predictions_after(
    fits: list[Fit], excitations: tuple[Measurement, ...], around: Surroundings
) -> list[list[Prediction]] | None:
    """Return what each fit, the best first, predicts of each excitation, (excitation, hypothesis), as strong as what
    moved the recordings there are; None where motion grows beyond all bounds.
    """
    batch = max(fits[0].batches, key=lambda own: own.samples)
    sigma, samples = around.noise_model.sigma, batch.samples
    stride = max(1, samples // EXCITATIONS.slopes_at)
    used = -(-samples // stride)
    many = max(1, min(used, EXCITATIONS.compared_at // len(sigma)))
    times = np.sort(np.random.default_rng(0).choice(used, many, replace=False))
    wanted = float(np.sqrt(np.mean(((batch.data - batch.data.mean(axis=1, keepdims=True)) / sigma) ** 2)))
    noise = sigma * np.sqrt(around.temper * many / (used * stride))
    found, strength = list[list[Prediction]](), None
    for item in fits:
        near = NearFit.of(item, ())
        outputs = around.outputs()
        starts = _starts(near, excitations, near.varied(outputs), around)
        if starts is None:
            return None
        if strength is None:
            linear = replace(near.varied(outputs).only(0), step=stride / around.noise_model.rate)
            shown = linear_channels(linear, starts[:1], used)[0] / sigma
            strength = wanted / np.maximum(np.sqrt(np.mean(shown**2, axis=(1, 2))), np.finfo(float).tiny)
        motion = near.motion(outputs, starts * strength[:, None], samples, stride)
        if not motion.is_finite:
            return None
        free = largest_states(starts[0] * strength[:, None], near)
        root = around.open_in(item)
        rest = (
            motion.by_state[0, : max(1, round(EXCITATIONS.rest_share * used))]
            * np.sqrt(stride / around.temper)
            / sigma[:, None]
        )
        rest = rest.reshape(-1, rest.shape[-1])
        own = list[Prediction]()
        for number, excitation in enumerate(excitations):
            known = np.diag(1 / free**2) + (rest.T @ rest if excitation.kind == "hammer" else 0.0)
            left = np.linalg.inv(np.linalg.cholesky(known)).T
            by_theta = motion.by_theta[:, number, times].transpose(1, 2, 0) @ root
            spread = np.concatenate([by_theta, motion.by_state[number, times] @ left], axis=2) / noise[:, None]
            mean = motion.mean[number, times] / noise
            own.append(Prediction(mean.ravel(), spread.reshape(mean.size, -1)))
        found.append(own)
    return [list(predictions) for predictions in zip(*found, strict=True)]


def _starts(
    near: NearFit, excitations: tuple[Measurement, ...], free: System, around: Surroundings
) -> FloatArray | None:
    """Return the states (variant, excitation, state) after each excitation of unit size."""
    nominal = near.hypothesis.nominal
    at = [(item.node, cast(Direction, item.direction)) for item in excitations]  # pulls and blows are along axes
    places = tuple(dict.fromkeys(at))
    loaded = replace(near.hypothesis, nominal=replace(nominal, loaded=(*nominal.loaded, *places)))
    entry = replace(near, hypothesis=loaded).varied(around.outputs()).loads
    assert entry is not None  # loads are there now
    feed = entry.feed[..., len(nominal.loaded) :]  # (variant, state, place)
    starts = np.zeros((len(feed), len(excitations), free.A.shape[1]))
    own = feed.shape[1]
    for number, item in enumerate(excitations):
        pushed = feed[..., places.index(at[number])]
        if item.kind == "hammer":
            starts[:, number, :own] = pushed
            continue
        try:
            starts[:, number, :own] = -np.linalg.solve(free.A[0, :own, :own], pushed[0])
        except np.linalg.LinAlgError:  # a body that moves freely: no pull holds it still
            return None
    return starts
