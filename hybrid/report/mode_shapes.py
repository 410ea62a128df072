"""Natural modes that move on a page: as drawn, with what was found, and as sensors showed them."""

import numpy as np

from fe_models.arrays import TINY, FloatArray
from fe_models.assembly import linearise
from fe_models.dof_map import DofMap
from fe_models.linear import LinearModel, ModalModel
from fe_models.mode_count import mode_count
from fe_models.modes import mac, natural_modes
from fe_models.pictures.geometry import DRAWN_SHARE, outline
from fe_models.recordings import Dataset
from fe_models.structure import TRANSLATIONS, Structure
from hybrid.identification.recording_comparison import Compared
from hybrid.report.motion import SEEN_PERIOD, Choice, Layer, Stage
from hybrid.report.page import MovingFigure

MODES = 8  # to look at, from the lowest
MORE = 4  # of the extended structure, whose modes may come in another order
CAPTION = "Largest displacement scaled to one; choose a mode, and let it move."
DESCRIPTION = "A natural mode of the structure: its lines at rest and displaced, as drawn and with what was found."


def mode_shapes(
    dataset: Dataset, extended: Structure | LinearModel | None, seen: Compared | None
) -> MovingFigure | None:
    """Return the modes of the dataset's model and, where there is one, of the ``extended`` one; with the shapes that
    were ``seen``. None where there is too much to move.
    """
    model = dataset.model
    shape = outline(model)
    stage = Stage.of(shape, dataset.sensors)
    if stage is None:
        return None
    drawn = _modes(model, MODES)
    other = None if extended is None else _modes(extended, MODES + MORE)
    size = DRAWN_SHARE * shape.size
    choices = []
    for number, frequency in enumerate(drawn.frequencies):
        own = _to_one(drawn.shapes[:, number], drawn.dofs)
        layers = [Layer("as drawn", "var(--drawn)", stage.points(size * own)[None])]
        words = [f"{frequency:.4g} Hz as drawn"]
        if other is not None:
            match, frequency_then = _match(own, drawn.dofs, other)
            layers.append(Layer("with what was found", "var(--extended)", stage.points(size * match)[None]))
            words.append(f"{frequency_then:.4g} Hz with what was found")
        measured = _measured(stage, seen, number, layers[-1].shapes[0])
        if measured is not None:
            layers.append(Layer("measured", "var(--measured)", measured[0][None], is_dots=True))
            words.append(f"{measured[1]:.4g} Hz measured")
        label = f"Mode {number + 1}: {', '.join(words)}."
        choices.append(Choice(label, tuple(layers), 1 / float(frequency), SEEN_PERIOD * float(frequency)))
    return MovingFigure(CAPTION + stage.words, DESCRIPTION, stage.motion(choices))


def _modes(model: Structure | LinearModel, count: int) -> ModalModel:
    linear = linearise(model) if isinstance(model, Structure) else model
    return natural_modes(linear, min(count, mode_count(linear)))


def _moving(dofs: DofMap) -> dict[tuple[int, str], int]:
    """Return the row of each translation, by node and direction."""
    return {
        (int(node), str(direction)): row
        for row, (node, direction) in enumerate(zip(dofs.node, dofs.direction, strict=True))
        if direction in TRANSLATIONS
    }


def _to_one(shape: FloatArray, dofs: DofMap) -> FloatArray:
    """Return a shape (dof,) whose largest translation is one."""
    return np.asarray(shape / max(float(np.abs(shape[list(_moving(dofs).values())]).max(initial=0.0)), TINY))


def _match(own: FloatArray, dofs: DofMap, other: ModalModel) -> tuple[FloatArray, float]:
    """Return the shape (dof,) of the other model's mode that is most like this one, at its degrees of freedom, turned
    the same way, and its frequency (Hz).
    """
    mine, theirs = _moving(dofs), _moving(other.dofs)
    common = [(row, theirs[place]) for place, row in mine.items() if place in theirs]
    rows, columns = (list(part) for part in zip(*common, strict=True))
    best = int(np.argmax(mac(own[rows, None], other.shapes[columns])[0]))
    shape = _to_one(other.shapes[:, best], other.dofs)
    shape = shape if own[rows] @ shape[columns] >= 0 else -shape
    every = {
        (int(node), str(direction)): row
        for row, (node, direction) in enumerate(zip(other.dofs.node, other.dofs.direction, strict=True))
    }
    places = zip(dofs.node, dofs.direction, strict=True)
    found = [every.get((int(node), str(direction)), -1) for node, direction in places]
    return np.where(np.array(found) >= 0, shape[found], 0.0), float(other.frequencies[best])


def _measured(stage: Stage, seen: Compared | None, number: int, beside: FloatArray) -> tuple[FloatArray, float] | None:
    """Return how far (px) sensors move (point, axis) in the mode measured for the drawn one of this ``number``, scaled
    to what is drawn ``beside`` it, and as that across their directions; and its frequency (Hz). None where none
    was.
    """
    if seen is None or number >= len(seen.nominal) or not stage.sensors:
        return None
    own = next((own for own in seen.recordings if own.chosen[number] >= 0), None)
    if own is None:
        return None
    picked = own.chosen[number]
    named = dict(zip(seen.sensors, own.shapes[:, picked], strict=True))
    if not all(sensor.name in named for sensor in stage.sensors):
        return None
    values, ways = np.array([named[sensor.name] for sensor in stage.sensors]), stage.ways
    at = beside[-len(values) :]
    along = np.sum(at * ways, axis=1)
    factor = float(values @ along / max(float(values @ values), TINY))
    points = np.zeros_like(beside)
    points[-len(values) :] = at + (factor * values - along)[:, None] * ways
    return points, float(own.identified.frequencies[picked])
