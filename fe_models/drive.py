"""What is known to drive a structure, as a force of time: loads at nodes, and the inertia that a moving base wakes."""

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from scipy.interpolate import BSpline

from fe_models.arrays import FloatArray
from fe_models.assembly import unsupported
from fe_models.base_motion import Along, BaseMotion, base_force, rigid_motion, unit_vector
from fe_models.dof_map import DofMap
from fe_models.dofs import dofs_of
from fe_models.errors import noting, raise_faults
from fe_models.interpolant import interpolant
from fe_models.linear import LinearModel
from fe_models.recordings import Load
from fe_models.structure import Structure


@dataclass(frozen=True)
class Drive:
    """Forces along ``pulls`` (force, dof) with ``values`` (time, force), one a sample at a ``sampling_rate`` (Hz).

    ``base``: the motions of the base among what they stand for, which sensors of the absolute motion show.
    """

    pulls: FloatArray
    values: FloatArray
    sampling_rate: float
    base: tuple[BaseMotion, ...] = ()

    @property
    def duration(self) -> float:
        """From the first sample to the last, s."""
        return (len(self.values) - 1) / self.sampling_rate

    @cached_property
    def _course(self) -> BSpline:
        return interpolant(self.values)

    def at(self, time: FloatArray | float) -> FloatArray:
        """Return the force (..., dof) at times (...), s, between samples as smooth as what is sampled."""
        return np.asarray(self._course(np.asarray(time) * self.sampling_rate) @ self.pulls)

    def ground(self, time: FloatArray) -> FloatArray | None:
        """Return displacement, velocity and acceleration of the base in x, y and z, (3, time, 3); None where it rests.

        At rest before the first sample.
        """
        return ground_motion(self.base, self.sampling_rate, time) if self.base else None


def ground_motion(base: Sequence[BaseMotion], sampling_rate: float, time: FloatArray) -> FloatArray:
    """Return displacement, velocity and acceleration in x, y and z, (3, time, 3), of a base with several motions."""
    at, step = time * sampling_rate, 1 / sampling_rate
    found = np.zeros((3, len(time), 3))
    for motion in base:
        velocity, displacement = motion.integrals()
        courses = step**2 * displacement(at), step * velocity(at), interpolant(motion.values)(at)
        along = np.pad(motion.along, (0, 3 - len(motion.along)))
        found += np.stack([np.outer(course, along) for course in courses])
    return found


def drive_of(model: Structure | LinearModel, excitation: Sequence[Load | BaseMotion], sampling_rate: float) -> Drive:
    """Return what drives a model, one value a sample; `InputError` with all faults."""
    raise_faults(_faults(model, excitation, sampling_rate))
    dofs = dofs_of(model)
    base = tuple(item for item in excitation if isinstance(item, BaseMotion))
    pulls = [
        inertia(model, item.along) if isinstance(item, BaseMotion) else dofs.pull([(item.node, item.direction, 1.0)])
        for item in excitation
    ]
    values = np.column_stack([np.asarray(item.values, dtype=float) for item in excitation])
    return Drive(np.where(dofs.moves, pulls, 0.0), values, sampling_rate, base)


def inertia(model: Structure | LinearModel, along: Along) -> FloatArray:
    """Return -M r (dof,), N for an acceleration of 1 m/s^2 of the base: of bare matrices without what supports carry
    of the mass.
    """
    if isinstance(model, Structure):
        return base_force(unsupported(model)[0], dofs_of(model), along)
    pull, free = np.zeros(len(model.dofs)), model.dofs.free
    pull[free] = -(model.mass @ rigid_motion(model.dofs, along)[free])
    return pull


def _faults(model: Structure | LinearModel, excitation: Sequence[Load | BaseMotion], sampling_rate: float) -> list[str]:
    faults = [] if sampling_rate > 0 else [f"sampling_rate = {sampling_rate:g} Hz; must be positive"]
    if not excitation:
        return [*faults, "nothing drives the structure: give loads, or a base motion"]
    dofs = dofs_of(model)
    for number, item in enumerate(excitation, start=1):
        values = np.asarray(item.values)
        if values.ndim != 1 or len(values) < 2 or not np.isfinite(values).all():
            faults.append(f"excitation {number}: {item!r} needs two finite values or more, (time,), one a sample")
        faults += [f"excitation {number}: {fault}" for fault in _place_faults(item, dofs)]
    lengths = sorted({len(item.values) for item in excitation})
    if len(lengths) > 1:
        faults.append(f"what drives the structure has {', '.join(map(str, lengths))} samples; give all as many")
    return faults


def _place_faults(item: Load | BaseMotion, dofs: DofMap) -> list[str]:
    """Return what is wrong with where a load acts, or how a base moves."""
    if isinstance(item, BaseMotion):
        faults = list[str]()
        along = noting(faults, "", unit_vector, item.direction)
        if along is not None and not rigid_motion(dofs, along)[dofs.moves].any():
            faults.append(f"no node of this model moves in direction {item.direction!r}; the base would do nothing")
        return faults
    try:
        row = dofs.row(item.node, item.direction)
    except KeyError as missing:
        return [str(missing.args[0])]
    return [] if dofs.moves[row] else [f"node {item.node} is held in {item.direction} by a support"]
