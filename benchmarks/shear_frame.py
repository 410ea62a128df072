"""A shear frame that unknown random forces keep moving, with its modes; exact in time, mode by mode."""

import numpy as np
from scipy.signal import lfilter

from fe_models.arrays import FloatArray
from fe_models.assembly import linearise
from fe_models.linear import ModalModel
from fe_models.modes import natural_modes
from fe_models.structure import Damping, PointMass, Spring, Structure

STOREY_MASS, STOREY_STIFFNESS, RATIO = 25.91, 1e4, 0.02  # kg, N/m: the shear frame that pyOMA2 shows
STOREYS = (1, 2, 3, 4, 5)  # nodes, and the springs below them, from the top
STEPS = 4  # of a force held, a sample: white up to twice the Nyquist frequency and more


def shear_frame(lost: dict[int, float] | None = None) -> Structure:
    """Five storeys, node 5 the lowest; ``lost``: share of the stiffness of the springs of these numbers (1 the top)."""
    factors = [1 - (lost or {}).get(number, 0.0) for number in range(1, 6)]
    springs = [
        Spring(nodes=(i, i + 1), direction="x", stiffness=STOREY_STIFFNESS * factors[i - 1]) for i in range(1, 5)
    ]
    springs.append(Spring(nodes=(5,), direction="x", stiffness=STOREY_STIFFNESS * factors[4]))
    return Structure(
        "five storeys",
        tuple((0.0, 5.0 - i) for i in range(5)),
        tuple(springs),
        tuple(PointMass(node, STOREY_MASS) for node in range(1, 6)),
        directions=("x",),
        damping=Damping(modal_ratios=(RATIO,)),
    )


def ambient(
    modal: ModalModel,
    rows: list[int],
    forced: list[int],
    samples: int,
    rate: float,
    rng: np.random.Generator,
    corner: float | None = None,
) -> FloatArray:
    """Return accelerations (time, row) at ``rows`` under independent random forces at the rows ``forced``.

    White, or of first order above a ``corner`` frequency (Hz). It has gone on for a while when the recording begins.
    """
    slowest = float(np.min(modal.damping_ratio * modal.omega))
    before = round(4 / slowest * rate)
    step = 1 / (rate * STEPS)
    force = rng.standard_normal(((before + samples) * STEPS, len(forced)))
    if corner is not None:
        kept = np.exp(-2 * np.pi * corner * step)
        force = np.asarray(lfilter([1 - kept], [1, -kept], force, axis=0))
    found = np.zeros((len(force), len(rows)))
    for omega, ratio, shape in zip(modal.omega, modal.damping_ratio, modal.shapes.T, strict=True):
        own = force @ shape[forced]
        s = omega * complex(-ratio, np.sqrt(1 - ratio**2))
        # z' = s z + own, held: q = Im z / Im s
        z = lfilter([0, (np.exp(s * step) - 1) / s], [1, -np.exp(s * step)], own.astype(complex))
        q, velocity = z.imag / s.imag, (s * z).imag / s.imag
        found += (own - 2 * ratio * omega * velocity - omega**2 * q)[:, None] * shape[rows]
    return np.asarray(found[before * STEPS :: STEPS])


def with_noise(data: FloatArray, share: float, rng: np.random.Generator) -> FloatArray:
    """Return data (time, sensor) with white noise of a ``share`` of each channel's rms."""
    return np.asarray(data + share * data.std(axis=0) * rng.standard_normal(data.shape))


def frame_modes(lost: dict[int, float] | None = None) -> ModalModel:
    """The five modes of the frame."""
    return natural_modes(linearise(shear_frame(lost)), 5)


def frame_recording(
    seed: int, samples: int = 14400, rate: float = 20.0, noise: float = 0.03, lost: dict[int, float] | None = None
) -> FloatArray:
    """Accelerations (time, storey) of the frame under white noise at all storeys."""
    modal, rng = frame_modes(lost), np.random.default_rng(seed)
    rows = [modal.dofs.row(node, "x") for node in range(1, 6)]
    return with_noise(ambient(modal, rows, rows, samples, rate, rng), noise, rng)
