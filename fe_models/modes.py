"""Natural modes of a linear model, K phi = omega^2 M phi, and how alike two sets of shapes are.

Shapes are mass-normalised, Phi^T M Phi = I, and signed so that the first translation that comes within 0.1 % of the
largest one (of the largest rotation where nothing translates) is positive.
"""

import numpy as np
from scipy.linalg import LinAlgError, eigh
from scipy.sparse.linalg import LinearOperator, SuperLU, eigsh

from fe_models.arrays import ComplexArray, FloatArray
from fe_models.assembly import linearise
from fe_models.damping import ratios_of_modes, replace_ratios
from fe_models.dof_map import DofMap
from fe_models.errors import InputError, raise_faults
from fe_models.linear import LinearModel, ModalModel
from fe_models.linear_checks import check_linear_model
from fe_models.mechanisms import describe_mechanism, energy, factorise, resists
from fe_models.mode_count import LARGEST_DENSE_SOLVE, mode_count
from fe_models.structure import TRANSLATIONS, Structure

USUAL_COUNT = 10
"""Modes, where nothing is said of how many: as many as the bridge has below its low-pass."""
MASS_TOLERANCE = 1e-14
"""1 / omega^2, relative to that of the first mode, below which a mode has no mass."""


def natural_modes(
    model: LinearModel | Structure, count: int | None = None, factors: SuperLU | None = None
) -> ModalModel:
    """Return the ``count`` lowest modes, with damping ratios xi = phi^T C phi / (2 omega) plus the modal ratios.

    Of a structure those of its linear model as drawn. Without ``count``: `USUAL_COUNT`, or all of `mode_count`.

    Lanczos iterations on K^-1 M with one sparse factorisation of K (shift 0, inverted), or with the ``factors`` of K
    where they are known; a full solution for small models and where most of the modes are wanted. M may be singular:
    degrees of freedom without mass add no mode.
    `InputError` where a matrix cannot be used, the structure can move without resistance, or has fewer modes.
    """
    if isinstance(model, Structure):
        model = linearise(model)
    if not isinstance(model, LinearModel):
        raise InputError(f"{model!r} is no model: give a structure or matrices, as fe_models.load_model returns them")
    raise_faults(check_linear_model(model))
    size = model.mass.shape[0]
    available = mode_count(model)
    if count is None:
        count = min(USUAL_COUNT, available)
    if not 1 <= count <= size:
        raise InputError(f"{count} modes asked for; the model has {size} free degrees of freedom: ask for 1 to {size}")
    _refuse_massless(count, available)
    full = size <= LARGEST_DENSE_SOLVE or 2 * count > available
    omega_squared, shapes = _all_modes(model, count) if full else _lowest_modes(model, count, available, factors)
    if not resists(model.stiffness, shapes).all():
        raise InputError(describe_mechanism(model))
    omega = np.sqrt(omega_squared)
    shapes = _signed(shapes, model.dofs)
    ratio = energy(model.damping, shapes) / (2 * omega) + ratios_of_modes(model.modal_ratios, count)
    return ModalModel(omega, replace_ratios(ratio, model.replaced_ratios), model.dofs.expand(shapes), model.dofs)


def mac(a: FloatArray | ComplexArray, b: FloatArray | ComplexArray) -> FloatArray:
    """Return the modal assurance criterion (..., i, j) of shapes ``a`` (..., dof, i) with ``b`` (..., dof, j), real or
    complex.

    MAC_ij = |a_i^H b_j|^2 / ((a_i^H a_i) (b_j^H b_j)): 1 for equal shapes of any scale, sign and phase, 0 for
    orthogonal ones (Allemang, Sound and Vibration 37(8), 2003).
    """
    products = np.abs(a.conj().swapaxes(-2, -1) @ b) ** 2
    squares = [np.sum(np.abs(shapes) ** 2, axis=-2) for shapes in (a, b)]
    criterion: FloatArray = products / (squares[0][..., :, None] * squares[1][..., None, :])
    return criterion


def _all_modes(model: LinearModel, count: int) -> tuple[FloatArray, FloatArray]:
    """Solve M phi = mu K phi, mu = 1 / omega^2, which stands a singular M and is most exact in the lowest modes."""
    try:
        mu, shapes = eigh(model.mass.toarray(), model.stiffness.toarray())
    except LinAlgError:
        raise InputError(describe_mechanism(model)) from None
    mu, shapes = mu[::-1], shapes[:, ::-1]
    _refuse_massless(count, int(np.sum(mu > MASS_TOLERANCE * mu[0])))
    return 1 / mu[:count], shapes[:, :count] / np.sqrt(mu[:count])  # eigh scales to Phi^T K Phi = I


def _lowest_modes(
    model: LinearModel, count: int, available: int, factors: SuperLU | None
) -> tuple[FloatArray, FloatArray]:
    """Return omega^2 and shapes of the ``count`` lowest of all ``available`` modes."""
    size = model.mass.shape[0]
    try:
        factors = factors or factorise(model.stiffness)
    except RuntimeError:
        raise InputError(describe_mechanism(model)) from None
    known, extended = factors, model.stiffness.astype(np.longdouble)

    def solve(load: FloatArray) -> FloatArray:
        """Solve K u = load; one refinement with an extended residual keeps 4 digits at 100,000 dofs, not 1 or 2."""
        u = known.solve(load)
        residual = np.asarray(load - extended @ u.astype(np.longdouble), dtype=float)
        return np.asarray(u + known.solve(residual))

    omega_squared, shapes = eigsh(
        model.stiffness,
        k=count,
        M=model.mass,
        sigma=0.0,
        OPinv=LinearOperator((size, size), matvec=solve, dtype=float),
        ncv=min(available, max(2 * count + 1, 20)),  # without mass there is nothing more to span
        v0=np.random.default_rng(0).standard_normal(size),  # fixed, so that the same model gives the same bits
    )
    order = np.argsort(omega_squared)
    return omega_squared[order], shapes[:, order]


def _refuse_massless(count: int, available: int) -> None:
    if count > available:
        raise InputError(f"{count} modes asked for; only {available} have mass to move: ask for 1 to {available}")


def _signed(shapes: FloatArray, dofs: DofMap) -> FloatArray:
    """Return the shapes (free, mode) with the sign that the module states."""
    translations = np.isin(dofs.direction[dofs.free], TRANSLATIONS)
    size = np.abs(shapes)
    judged = np.where(translations[:, None], size, 0.0)
    judged = np.where(judged.max(axis=0) > 0, judged, size)
    first = np.argmax(judged >= 0.999 * judged.max(axis=0), axis=0)  # (mode,)
    return np.asarray(shapes * np.sign(shapes[first, np.arange(shapes.shape[1])]))
