"""The motion of the whole structure that a model forecasts, as it moves on a page."""

import numpy as np

from fe_models.arrays import TINY, FloatArray
from fe_models.files.run_folder import Prediction
from fe_models.linear import LinearModel
from fe_models.pictures.geometry import choose_scale, largest_displacement, outline
from fe_models.spectra import power_spectrum
from fe_models.structure import Structure
from hybrid.report.motion import SEEN_PERIOD, Choice, Layer, Stage
from hybrid.report.page import MovingFigure

PARTS = 12  # shapes that a motion is made of: models have ten modes, or fewer
LEAST_PART = 1e-4  # of the largest part of a motion: smaller ones are not seen
MOST_SAMPLES = 2000  # of a motion on a page; of longer ones the first
CAPTION = (
    "The first test window as the models forecast it from its first samples, displacements {scale:.3g} times as large."
    " It is slowed down, or sped up, so that its strongest vibration takes {period:g} s."
)
DESCRIPTION = "The structure's lines at rest, and displaced as the hybrid and the FE model forecast them over time."


def field_motion(model: Structure | LinearModel, prediction: Prediction) -> MovingFigure | None:
    """Return the forecast motion of all nodes; None where there is too much to move, or nothing moves."""
    shape = outline(model)
    stage = Stage.of(shape, prediction.sensors)
    fields = {"FE model": prediction.fe, "hybrid": prediction.hybrid}
    if prediction.truth is not None:
        fields = {"truth": prediction.truth, **fields}
    fields = {name: field[:MOST_SAMPLES] for name, field in fields.items()}
    step = max(1, len(prediction.hybrid[:MOST_SAMPLES]) // 100)
    largest = largest_displacement(shape, prediction.hybrid[:MOST_SAMPLES:step])
    if stage is None or largest <= 0 or not all(np.isfinite(field).all() for field in fields.values()):
        return None
    scale = choose_scale(largest, shape.size)
    colours = {"truth": "var(--measured)", "FE model": "var(--drawn)", "hybrid": "var(--extended)"}
    layers = tuple(_layer(stage, scale * field, name, colours[name]) for name, field in fields.items())
    seconds = float(prediction.time[1] - prediction.time[0])
    slowed = SEEN_PERIOD * _strongest(prediction.hybrid[:MOST_SAMPLES], 1 / seconds)
    choice = Choice("Forecast.", layers, seconds, slowed)
    caption = CAPTION.format(scale=scale, period=SEEN_PERIOD) + stage.words
    return MovingFigure(caption, DESCRIPTION, stage.motion([choice]))


def _layer(stage: Stage, field: FloatArray, name: str, colour: str) -> Layer:
    """Return a motion (time, dof) as a few shapes, and how much of each there is over time."""
    U, sizes, shapes = np.linalg.svd(field, full_matrices=False)
    kept = max(1, int(np.sum(sizes[:PARTS] > LEAST_PART * max(float(sizes[0]), TINY))))
    history = U[:, :kept] * sizes[:kept]
    most = np.maximum(np.abs(history).max(axis=0), TINY)
    drawn = np.stack([stage.points(size * shape) for size, shape in zip(most, shapes[:kept], strict=True)])
    return Layer(name, colour, drawn, history / most)


def _strongest(field: FloatArray, rate: float) -> float:
    """Return the frequency (Hz) of a motion's (time, dof) strongest vibration."""
    power = power_spectrum(field - field.mean(axis=0)).sum(axis=1)
    return (int(np.argmax(power[1:])) + 1) * rate / len(field)
