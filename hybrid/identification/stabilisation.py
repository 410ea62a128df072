"""Stabilisation: poles of rising order, of which those that stay where they are stand for modes.

Poles of two orders with like frequency and shape are joined; a mode is what enough orders have. Of free decays they are
those of eigensystem realisations. One singular value decomposition serves all orders: in balanced coordinates the
realisation of a lower order is the leading block of that of the highest one (Juang & Pappa, J. Guidance 8(5), 1985).
"""

from collections.abc import Sequence
from dataclasses import dataclass
from math import ceil

import numpy as np
from scipy.sparse.csgraph import connected_components

from fe_models.arrays import BoolArray, ComplexArray, FloatArray, IntArray
from fe_models.modes import mac
from hybrid.identification.config import FREE_DECAY, STABILISATION
from hybrid.identification.realisation import realise


@dataclass(frozen=True)
class Stabilisation:
    """The poles of all orders: their ``order`` (pole,), ``roots`` (pole,), rad/s, complex ``shapes`` (pole, sensor),
    and the number of the ``mode`` (pole,) that they belong to, -1 of those that belong to none.
    """

    order: IntArray
    roots: ComplexArray
    shapes: ComplexArray
    mode: IntArray

    @staticmethod
    def of(
        order: IntArray, roots: ComplexArray, shapes: ComplexArray, scale: FloatArray, least: float, first: int = 0
    ) -> "Stabilisation":
        """Return the poles with their modes: what ``least`` so many orders have from the ``first`` on.

        ``scale`` (sensor,): of the channels.
        """
        mode = _modes_of(order, roots, np.asarray(shapes / scale), least, first)
        return Stabilisation(order, roots, shapes, mode)

    @property
    def modes(self) -> tuple[ComplexArray, ComplexArray]:
        """The root (mode,) and shape (mode, sensor) of each stable mode: those of the pole of median frequency."""
        chosen = []
        for number in range(self.mode.max(initial=-1) + 1):
            own = np.flatnonzero(self.mode == number)
            chosen.append(own[np.argsort(np.abs(self.roots[own]))[len(own) // 2]])
        middle = np.array(chosen, dtype=int)
        return self.roots[middle], self.shapes[middle]


def stabilisation_of(
    motions: Sequence[FloatArray], rate: float, slowest: float, band: tuple[float, float]
) -> Stabilisation:
    """Return the poles of free decays (time, sensor), sampled at ``rate`` Hz, with frequencies in a ``band`` (Hz).

    ``slowest``: the lowest natural frequency to look for, Hz, which says how long the block rows have to be.
    """
    scale = np.sqrt(np.mean([np.mean((part - part.mean(axis=0)) ** 2, axis=0) for part in motions], axis=0))
    scale = np.where(scale > 0, scale, 1.0)
    shortest = min(len(part) for part in motions)
    rows = max(2, min(STABILISATION.block_rows, shortest // 4))
    long = ceil(STABILISATION.min_row_periods / slowest * rate / rows)
    spacing = max(1, min(long, shortest // (2 * rows)))
    span = rows * spacing + 1
    parts = [_loud((part - part.mean(axis=0)) / scale, 4 * span) for part in motions]
    columns = sum(max(len(part) - span, 1) for part in parts)
    stride = max(1, columns // STABILISATION.max_columns)
    highest = min(STABILISATION.highest_order, rows * len(scale), max(columns // stride, 1))
    model = realise([part[None] for part in parts], highest, rows, spacing, stride)
    found: list[tuple[IntArray, ComplexArray, ComplexArray]] = []
    for order in range(min(STABILISATION.lowest_order, highest), highest + 1, STABILISATION.order_step):
        values, vectors = np.linalg.eig(model.transition[:order, :order].astype(complex))
        usable = np.abs(values) > np.finfo(float).eps
        roots = np.log(values[usable]) * rate
        shapes = (model.output[:, :order] @ vectors[:, usable]).T * scale
        kept = vibrates(roots, band)
        found.append((np.full(int(kept.sum()), order), roots[kept], shapes[kept]))
    orders, every, shapes = (np.concatenate([part[kind] for part in found]) for kind in range(3))
    return Stabilisation.of(orders, every, shapes, scale, STABILISATION.min_order_share * len(found))


def _loud(part: FloatArray, least: int) -> FloatArray:
    """Return the beginning of a motion (time, sensor) that holds most of its energy, no less than ``least`` samples."""
    power = np.cumsum(np.sum(part**2, axis=1))
    return part[: max(int(np.searchsorted(power, STABILISATION.energy_share * power[-1])), least)]


def vibrates(roots: ComplexArray, band: tuple[float, float]) -> BoolArray:
    """Return which roots are vibrations in the band (Hz) whose damping is that of a structure."""
    frequency, ratio = np.abs(roots) / (2 * np.pi), -roots.real / np.maximum(np.abs(roots), np.finfo(float).tiny)
    inside = (frequency > band[0]) & (frequency < band[1]) & (roots.imag > 0)
    return np.asarray(inside & (np.abs(ratio) < FREE_DECAY.max_damping_ratio))


def _modes_of(order: IntArray, roots: ComplexArray, shapes: ComplexArray, least: float, first: int) -> IntArray:
    """Return the mode (pole,) of each pole, by frequency; -1 where fewer than ``least`` orders from the ``first`` on
    have it.
    """
    frequency = np.log(np.abs(roots))
    near = np.abs(frequency[:, None] - frequency) < STABILISATION.max_frequency_difference
    same = near & (mac(shapes.T, shapes.T) > STABILISATION.min_mac) & (order[:, None] != order)
    count, group = connected_components(same, directed=False)
    held = [len(set(order[(group == number) & (order >= first)])) for number in range(count)]
    stable = [number for number in range(count) if held[number] >= least]
    stable.sort(key=lambda number: float(np.median(frequency[group == number])))
    mode = np.full(len(roots), -1)
    for position, number in enumerate(stable):
        mode[group == number] = position
    return mode
