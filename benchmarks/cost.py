"""Seconds and memory of a trajectory with its gradient, against its length, the batch, the modes and the sensors.

Memory is what a trajectory keeps for its gradient, by far the most of what it needs.
"""

import time
from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np
import torch
from torch import Tensor

from benchmarks.row import Row
from fe_models.assembly import linearise
from fe_models.modes import natural_modes
from fe_models.progress import nothing
from fe_models.recordings import Sensor
from fe_models.structure import PointMass, Spring, Structure
from hybrid.config import places_preset
from hybrid.figures import Sheet, figure
from hybrid.neural_modal_ode.connectors import chain_connectors
from hybrid.neural_modal_ode.model import NeuralModalODE
from hybrid.neural_modal_ode.scaling import StateScale


@dataclass(frozen=True)
class Point:
    """A problem's size."""

    length: int = 500
    batch: int = 16
    modes: int = 4
    sensors: int = 4


@dataclass(frozen=True)
class Cost:
    """What a point takes: seconds, and MiB kept for the gradient."""

    point: Point
    seconds: float
    memory: float


SERIES: dict[str, tuple[int, ...]] = {
    "length": (100, 1_000, 10_000, 100_000),
    "batch": (1, 4, 16, 64, 256),
    "modes": (4, 12, 40, 100, 200),
    "sensors": (4, 16, 64, 200),
}
QUICK_SERIES: dict[str, tuple[int, ...]] = {
    "length": (100, 1_000, 10_000),
    "batch": (1, 16, 128),
    "modes": (4, 20, 100),
    "sensors": (4, 50, 200),
}
LABELS = {"length": "steps", "batch": "windows at once", "modes": "modes", "sensors": "sensors"}


def measure(series: dict[str, tuple[int, ...]], advance: Callable[[], object] = nothing) -> dict[str, list[Cost]]:
    """Return the costs along each of the series, everything else as in `Point`; sensors on a chain of 200 masses."""
    _cost(Point(length=10))  # loads what is loaded once
    found: dict[str, list[Cost]] = {}
    for name, sizes in series.items():
        base = Point(modes=200, batch=4, length=100) if name == "sensors" else Point()
        found[name] = []
        for size in sizes:
            found[name].append(_cost(replace(base, **{name: size})))
            advance()
    return found


def rows(costs: dict[str, list[Cost]]) -> list[Row]:
    """Return what the largest of each series costs, beside what it would if cost grew linearly from the one before."""
    found = []
    for name, points in costs.items():
        small, large = points[-2], points[-1]
        ratio = getattr(large.point, name) / getattr(small.point, name)
        what = f"{getattr(large.point, name):,} {LABELS[name]}"
        peer = f"linear from {getattr(small.point, name):,}"
        found.append(Row("cost", f"seconds, {what}", large.seconds, peer, small.seconds * ratio))
        found.append(Row("cost", f"MiB, {what}", large.memory, peer, small.memory * ratio))
    return found


def draw(costs: dict[str, list[Cost]]) -> Sheet:
    """Draw seconds (above) and memory (below), with a line of slope one beside each."""
    with figure(2 * len(costs), len(costs), "A trajectory and its gradient") as (sheet, axes):
        sheet.figure.set_size_inches(13, 5.5)
        for column, (name, points) in enumerate(costs.items()):
            sizes = np.array([getattr(cost.point, name) for cost in points], dtype=float)
            for row, (values, label) in enumerate(
                [([cost.seconds for cost in points], "seconds"), ([cost.memory for cost in points], "MiB")]
            ):
                axis = axes[row * len(costs) + column]
                axis.loglog(sizes, values, "o-", color="#0072B2", label="measured")
                linear = sizes / sizes[-1] * values[-1]
                axis.loglog(sizes, linear, "--", color="#555555", linewidth=1, label="linear")
                axis.set(xlabel=LABELS[name], ylabel=label if column == 0 else "")
        axes[0].legend(frameon=False)
    return sheet


def chain_model(point: Point) -> NeuralModalODE:
    """Return a hybrid model of a chain of as many masses as modes, its nets at their start."""
    nodes = range(1, point.modes + 1)
    springs = [Spring((1,), "x", 1.0), *(Spring((node - 1, node), "x", 1.0) for node in nodes[1:])]
    chain = Structure(
        name="chain",
        nodes=tuple((float(node), 0.0) for node in nodes),
        elements=tuple(springs),
        point_masses=tuple(PointMass(node, 1.0) for node in nodes),
        directions=("x",),
    )
    linear = linearise(chain)
    modal = replace(natural_modes(linear, point.modes), damping_ratio=np.full(point.modes, 0.02))
    sensors = tuple(Sensor(f"a{i}", 1 + i % point.modes, "x", "acceleration", "m/s^2") for i in range(point.sensors))
    scale = StateScale.of_velocity(np.ones(point.modes), modal.omega)
    config = replace(places_preset().model, substeps=1, modes=point.modes)
    connectors = chain_connectors(chain, linear, modal)
    return NeuralModalODE(config, modal, (), sensors, torch.ones(point.sensors), scale, 0.05, connectors)


def _cost(point: Point) -> Cost:
    model = chain_model(point)
    z0 = 0.1 * torch.randn(point.batch, 2 * point.modes, generator=torch.Generator().manual_seed(0))
    kept: dict[int, int] = {}  # bytes of each piece of memory

    def keep(tensor: Tensor) -> Tensor:
        storage = tensor.untyped_storage()
        kept[storage.data_ptr()] = storage.nbytes()
        return tensor

    started = time.perf_counter()
    with torch.autograd.graph.saved_tensors_hooks(keep, lambda tensor: tensor):
        loss = model.forecast(z0, point.length).channels.square().mean()
    loss.backward()
    return Cost(point, time.perf_counter() - started, sum(kept.values()) / 2**20)
