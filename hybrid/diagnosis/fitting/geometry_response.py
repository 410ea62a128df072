"""What geometric forces add to the channels: as loads on nominal modes they act along the motion, and change it.

They are taken along the motion without them at first, then along that with them, and so on until they settle: where
geometry detunes a mode by d omega, round k changes the motion after time t by some (t d omega)^k / k! of it. Force laws
answer as well.
"""

from dataclasses import replace

import numpy as np
from scipy.interpolate import make_interp_spline

from fe_models.arrays import FloatArray
from fe_models.interpolant import courses_of
from fe_models.recordings import QUANTITIES, Sensor
from hybrid.diagnosis.fitting.config import GEOMETRY_RESPONSE
from hybrid.diagnosis.fitting.driven import sampled_motion
from hybrid.diagnosis.fitting.least_squares import Fit
from hybrid.diagnosis.nominal.geometry import Geometry
from hybrid.diagnosis.nominal.loads import Loads, OnMode
from hybrid.diagnosis.recorded.batches import Batch
from hybrid.diagnosis.recorded.noise_model import NoiseModel
from hybrid.diagnosis.recorded.sensor_outputs import SensorOutputs
from hybrid.diagnosis.response.hypothesis import Hypothesis
from hybrid.diagnosis.response.load_input import load_input_of
from hybrid.diagnosis.response.loaded import loaded_channels
from hybrid.diagnosis.response.marching import respond
from hybrid.diagnosis.response.reduced_model import ReducedModel
from hybrid.diagnosis.response.state_space import system_of
from hybrid.diagnosis.response.system import System, through_lowpass


def added_motion(
    hypothesis: Hypothesis, theta: FloatArray, states: FloatArray, batch: Batch, outputs: SensorOutputs
) -> FloatArray:
    """Return what geometry adds to the channels (recording, time, sensor) of motions.

    ``states`` (recording, state): where they begin; ``batch``: of which recordings. Zero where the nominal model has no
    geometry, where the motion explodes, and where the forces do not settle.
    """
    nothing, geometry = np.zeros((len(states), batch.samples, len(outputs.sensors))), hypothesis.nominal.geometry
    if geometry is None:
        return nothing
    whole, reduced = system_of(hypothesis, theta[None], outputs), hypothesis.reduced(theta[None])
    fine = replace(whole, step=whole.step / GEOMETRY_RESPONSE.oversampling)
    straight = replace(fine, lowpass=None)  # the difference passes it
    forced, samples = (
        _with_load_input(straight, hypothesis, reduced, outputs.sensors),
        GEOMETRY_RESPONSE.oversampling * batch.samples,
    )
    known = None if batch.loads is None else batch.loads.finer(GEOMETRY_RESPONSE.oversampling)
    picked = reduced.shapes[0].T @ geometry.weighted  # (vector, mode): to modal coordinates of the nominal structure
    moving, loads, forces = straight, known, np.zeros(0)
    for _ in range(GEOMETRY_RESPONSE.max_rounds):
        motion, before = sampled_motion(moving, states, samples, loads), forces
        if motion is None:
            return nothing
        coordinates = motion[..., : hypothesis.size] @ picked  # (time, recording, mode)
        with np.errstate(over="ignore", invalid="ignore"):
            forces = geometry.at(coordinates)
        if not np.isfinite(forces).all():
            return nothing
        own = _as_loads(forces, fine.step)
        moving, loads = forced, _beside(known, own, forced)
        if before.size and np.linalg.norm(forces - before) <= GEOMETRY_RESPONSE.max_relative_change * np.linalg.norm(
            forces
        ):
            break
    else:
        return nothing
    if straight.is_linear:
        moved = loaded_channels(forced, own)[0]
    else:
        moved = respond(forced, states[None], samples, loads)[0] - respond(straight, states[None], samples, known)[0]
    if not np.isfinite(moved).all():
        return nothing
    shown = through_lowpass(moved, fine) + _given_way(geometry, coordinates, hypothesis, outputs.sensors, fine)
    return np.asarray(shown[:, :: GEOMETRY_RESPONSE.oversampling])


def _with_load_input(
    system: System, hypothesis: Hypothesis, reduced: ReducedModel, sensors: tuple[Sensor, ...]
) -> System:
    """Return a system that forces on the modes that geometry exerts enter as well.

    What gives way to them at once is treated apart, by `_given_way`; force laws do not answer to that.
    """
    nominal, geometry = hypothesis.nominal, hypothesis.nominal.geometry
    assert geometry is not None  # its caller has seen to that
    pulls = geometry.weighted.T
    places, laws = (
        tuple(OnMode(mode + 1) for mode in range(len(pulls))),
        np.zeros((len(system.forces), len(nominal.dofs))),
    )
    inverse = np.linalg.inv(reduced.mass)
    own = load_input_of(
        places, pulls, np.zeros((0, *geometry.weighted.shape)), laws, reduced, inverse, nominal, sensors
    )
    return replace(system, loads=own if system.loads is None else system.loads.and_at(own))


def _as_loads(forces: FloatArray, step: float) -> Loads:
    """Return modal ``forces`` (time, recording, mode), a ``step`` (s) apart, as loads."""
    places = tuple(OnMode(mode + 1) for mode in range(forces.shape[2]))
    return Loads.of(places, courses_of(forces.swapaxes(0, 1), step), step)


def _beside(known: Loads | None, own: Loads, system: System) -> Loads:
    """Return known loads and others in one, as they enter a system."""
    if known is None:
        return own
    assert system.loads is not None  # they enter it
    places = system.loads.places
    return Loads.of(places, known.at(places) + own.at(places), own.step)


def _given_way(
    geometry: Geometry, coordinates: FloatArray, hypothesis: Hypothesis, sensors: tuple[Sensor, ...], system: System
) -> FloatArray:
    """Return what the channels (recording, time, sensor) show of modes that give way at once, as a column shortens, at
    modal ``coordinates`` (time, recording, mode).
    """
    given = geometry.bent_at(coordinates, hypothesis.nominal.rows(sensors))
    times, shown = system.step * np.arange(len(given)), []
    for position, (sensor, delay) in enumerate(zip(sensors, system.delay[0], strict=True)):
        curve = make_interp_spline(
            times, given[..., position], k=min(GEOMETRY_RESPONSE.spline_degree, len(given) - 1), check_finite=False
        )
        shown.append(curve(times - delay, nu=QUANTITIES.index(sensor.quantity)))
    return through_lowpass(np.stack(shown, axis=-1).swapaxes(0, 1) * system.gain[0], system)


def straightened(item: Fit, noise_model: NoiseModel) -> tuple[Batch, ...] | None:
    """Return what was recorded less what geometry adds to the motion of a fit; None where that hardly changes."""
    batches, change = [], 0.0
    for batch, states in zip(item.batches, item.states, strict=True):
        y = added_motion(item.hypothesis, item.theta, states, batch, noise_model.outputs)
        change += float(np.square((batch.recorded - batch.data - y) / batch.sigma(noise_model)).sum())
        batches.append(batch.less(y))
    return tuple(batches) if change > GEOMETRY_RESPONSE.min_energy_share * item.values else None
