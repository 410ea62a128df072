"""What the nominal simulation gets wrong, before any cause is named."""

from dataclasses import dataclass, replace

import numpy as np

from fe_models.arrays import TINY, FloatArray
from fe_models.causes.candidate import LoadCandidate, SensorCandidate, SupportCandidate
from fe_models.modes import mac
from fe_models.recordings import Dataset, Sensor
from hybrid.diagnosis.contest.growing import fit_growing, lengths_of
from hybrid.diagnosis.fitting.forecast_score import ForecastScore
from hybrid.diagnosis.fitting.least_squares import Fit, fit, residuals_at
from hybrid.diagnosis.nominal.nominal_model import NominalModel
from hybrid.diagnosis.observed.amplitude_dependence import Amplitude, amplitude_dependence
from hybrid.diagnosis.observed.config import OBSERVATION
from hybrid.diagnosis.recorded.noise_model import NoiseModel
from hybrid.diagnosis.recorded.sensor_outputs import SensorOutputs
from hybrid.diagnosis.recorded.spectra import energy_near
from hybrid.diagnosis.response.hypothesis import Hypothesis
from hybrid.diagnosis.response.state_space import system_of


@dataclass(frozen=True)
class Modes:
    """``frequencies`` (mode,) Hz, damping ``ratios`` (mode,) and ``shapes`` (translation, mode), by frequency."""

    frequencies: FloatArray
    ratios: FloatArray
    shapes: FloatArray


@dataclass(frozen=True)
class Observations:
    """What is seen of a case before a cause is named.

    ``nominal``, ``calibrated`` (within the stated uncertainty) and ``observed``: modes; the last of the linear model
    of this form, with the linear causes found, that follows the recordings best, whatever its factors. ``mac`` (mode,)
    of nominal and observed shapes.
    ``motion_energy`` and ``error_energy`` (mode,): shares of the channels' energy, and of what the nominal model leaves
    of them, noise apart, that lie nearest to each observed frequency. ``errors`` (3, sensor): forecast NRMSE nominal,
    calibrated and floor; ``noise`` (sensor,) its standard deviation in the sensors' units; ``error_share`` (sensor,):
    of the energy that the nominal model leaves beyond noise; both NaN of sensors that are not fitted.
    """

    nominal: Modes
    calibrated: Modes
    observed: Modes
    mac: FloatArray
    motion_energy: FloatArray
    error_energy: FloatArray
    amplitude: Amplitude | None
    sensors: tuple[Sensor, ...]
    errors: FloatArray
    noise: FloatArray
    error_share: FloatArray


def observe(
    dataset: Dataset, base: Fit, own: Fit, nominal: ForecastScore, calibrated: ForecastScore, noise_model: NoiseModel
) -> Observations:
    """Return what is wrong before a cause is named.

    ``base``: the fit of what the user simulates with, of which ``nominal`` and ``calibrated`` are forecasts;
    ``own``: that of the structure with what was found, which the recordings alone may go on from: a
    frequency that is far off in the nominal model is not reached from there.
    """
    free = _free_fit(own, base, noise_model) or base
    hypothesis = base.hypothesis
    brought = free.hypothesis.brought
    modes = _below_lowpass(
        modes_of(_following(hypothesis, brought), np.zeros_like(base.theta), noise_model.rate),
        modes_of(_following(hypothesis, brought), base.theta, noise_model.rate),
        modes_of(free.hypothesis, free.theta, noise_model.rate),
        below=dataset.lowpass or np.inf,
    )
    motion = tuple(batch.data / batch.sigma(noise_model) for batch in base.batches)
    drawn = residuals_at(base, np.zeros_like(base.theta), noise_model)
    error = tuple(all_of_it if part is None else part for part, all_of_it in zip(drawn, motion, strict=True))
    by_mode = [energy_near(modes[2].frequencies, part, noise_model.rate) for part in (motion, error)]
    fitted = [dataset.sensors.index(sensor) for sensor in noise_model.sensors]
    noise, share = np.full((2, len(dataset.sensors)), np.nan)
    noise[fitted] = noise_model.sigma
    left = np.sum([np.square(part).sum(axis=(0, 1)) - part[..., 0].size for part in error], axis=0)
    share[fitted] = np.maximum(left, 0) / max(float(np.maximum(left, 0).sum()), TINY)
    return Observations(
        nominal=modes[0],
        calibrated=modes[1],
        observed=modes[2],
        mac=np.diag(mac(modes[0].shapes, modes[2].shapes)),
        motion_energy=by_mode[0],
        error_energy=by_mode[1],
        amplitude=amplitude_dependence(free, noise_model),
        sensors=dataset.sensors,
        errors=np.stack([nominal.nrmse.mean(axis=0), calibrated.nrmse.mean(axis=0), calibrated.floor.mean(axis=0)]),
        noise=noise,
        error_share=share,
    )


def modes_of(hypothesis: Hypothesis, theta: FloatArray, rate: float) -> Modes:
    """Return the modes that a hypothesis has at ``theta`` (parameter,), force laws left out."""
    sensors = every_translation(hypothesis.nominal)
    system = system_of(hypothesis, theta[None], SensorOutputs.faultless(sensors, rate))
    roots, vectors = np.linalg.eig(system.A[0])
    order = [i for i in np.argsort(np.abs(roots)) if roots[i].imag > 0]
    roots, shapes = roots[order], system.C[0] @ vectors[:, order]  # (translation, mode)
    largest = shapes[np.argmax(np.abs(shapes), axis=0), np.arange(len(order))]
    return Modes(np.abs(roots) / (2 * np.pi), -roots.real / np.abs(roots), np.real(shapes / largest))


def _below_lowpass(*models: Modes, below: float) -> list[Modes]:
    """Return those first modes of each that are ``below`` a low-pass (Hz) in any of them: of others little is seen."""
    count = max(int(np.sum(modes.frequencies < below)) for modes in models)
    return [Modes(m.frequencies[:count], m.ratios[:count], m.shapes[:, :count]) for m in models]


def _following(hypothesis: Hypothesis, more: int) -> Hypothesis:
    """Return the hypothesis with so many ``more`` modes followed."""
    nominal = hypothesis.nominal
    return (
        hypothesis if nominal.kept is None else replace(hypothesis, nominal=replace(nominal, kept=nominal.kept + more))
    )


def every_translation(nominal: NominalModel) -> tuple[Sensor, ...]:
    """Return a displacement sensor for each translation that can move."""
    places = [(int(nominal.dofs.node[row]), nominal.dofs.direction[row]) for row in nominal.dofs.free_rows]
    return tuple(
        Sensor(f"{node} {direction}", node, direction, "displacement", "m")
        for node, direction in places
        if direction != "rz"
    )


def _free_fit(own: Fit, base: Fit, noise_model: NoiseModel) -> Fit | None:
    """Return the fit of a linear model whose factors the recordings alone determine, from where ``own`` is.

    Causes that are linear and everywhere the same stay in it, faults of sensors and loads, too; a support that gives
    way would bring a mode of its own. Calibrated values beside a cause that is left out may be far from those without
    it: then from where the ``base`` is, too.
    """
    nominal, known = own.hypothesis.nominal, own.hypothesis.candidates
    off = {number for batch in own.batches for number in batch.off}
    stays = [
        isinstance(c, SensorCandidate | LoadCandidate) or (c.is_structural and not isinstance(c, SupportCandidate))
        for c in known
    ]
    kept = [i for i in range(len(known)) if stays[i] and i not in off]
    spread = np.where(np.arange(len(nominal.spread)) < nominal.factors, OBSERVATION.free_factor_std, nominal.spread)
    free = Hypothesis(replace(nominal, laws=(), spread=spread), tuple(known[i] for i in kept))
    theta = np.concatenate([own.theta[: free.nuisances], *(own.theta[own.hypothesis.slices[i]] for i in kept)])
    batches = tuple(replace(batch, off=()) for batch in own.batches)
    with np.errstate(over="ignore", invalid="ignore"):  # a step that goes too far is taken back
        found = [fit_growing(free, theta, lengths_of(batches, free.states), noise_model)]
        if base.hypothesis.nominal is nominal and len(kept) < len(known):
            found.append(fit(free, np.append(base.theta, theta[free.nuisances :]), batches, noise_model))
    return min((item for item in found if item is not None), key=lambda item: item.cost, default=None)
