"""How displacements, velocities and accelerations are added up: each over its size in the motion that they share.

Their numbers differ by powers of the angular frequency, so that of a plain sum of squares one quantity alone would be
left. At the angular frequency w of the motion, a channel of the o-th derivative is w^o times its displacement:

    size_i = w^o_i,    log w = sum_k V_k log |s_k| / sum_k V_k,    V_k = sum_i E_ki |s_k|^(2 - 2 o_i),

with the roots s_k of its modes, their energies E_ki in channel i, and those V_k of their velocities, which the kinetic
energy goes with.
"""

import numpy as np

from fe_models.arrays import ComplexArray, FloatArray, IntArray


def are_several(orders: IntArray) -> bool:
    """Return whether sensors whose signals are derivatives of such ``orders`` (sensor,) show several quantities."""
    return bool(np.any(orders != orders[:1]))


def channel_sizes(roots: ComplexArray, energy: FloatArray, orders: IntArray) -> FloatArray:
    """Return by what each channel is divided before channels are added up, (sensor,): ones of a single quantity.

    ``roots`` (mode,), rad/s, and ``energy`` (mode, sensor) of modes; ``orders`` (sensor,): of derivatives. Without any
    motion the sizes are ones.
    """
    omega = np.abs(roots)
    moving = np.sum(energy * omega[:, None] ** (2.0 - 2.0 * orders), axis=1)
    if not are_several(orders) or not moving.sum() > 0:
        return np.ones(len(orders))
    middle = float(np.exp(moving @ np.log(omega) / moving.sum()))
    return np.asarray(middle ** orders.astype(float))


def rms_of_each(data: FloatArray, orders: IntArray) -> FloatArray:
    """Return the root mean square of all channels (time, sensor) that show the quantity of each one, (sensor,)."""
    same = orders[:, None] == orders
    return np.asarray(np.sqrt(same @ np.mean(data**2, axis=0) / same.sum(axis=1)))
