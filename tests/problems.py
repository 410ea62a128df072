"""Problems with known answers: closed forms, and small solvers that share nothing with the product's.

`frame_matrices` integrates the textbook's shape functions by Gauss quadrature in NumPy; `chain_motion` is scipy's
eighth-order Runge-Kutta. Neither knows Exudyn.
"""

from collections.abc import Callable

import numpy as np
from numpy.polynomial.legendre import leggauss
from scipy.integrate import solve_ivp

from fe_models.arrays import FloatArray
from fe_models.sections import Section, round_wire
from fe_models.structure import Beam, Cable, PointMass, Spring, Structure, Support

TIMBER = Section("timber", 1.1e10, 450.0, 6e-4, 2e-8)
WIRE = round_wire("wire", 2e11, 7850.0, 2e-3)
CANTILEVER_ROOTS = (1.8751040687, 4.6940911330, 7.8547574382)  # cos(b) cosh(b) = -1


def cantilever(length: float = 2.0, divisions: int = 1, section: Section = TIMBER) -> Structure:
    """A horizontal cantilever of one beam from node 1, clamped, to node 2."""
    return Structure(
        "cantilever",
        ((0.0, 0.0), (length, 0.0)),
        (Beam((1, 2), section),),
        supports=(Support(1, ("x", "y", "rz")),),
        divisions=divisions,
    )


def bending_frequencies(roots: tuple[float, ...], length: float, section: Section = TIMBER) -> FloatArray:
    """Natural frequencies root^2 / (2 pi L^2) sqrt(E I / (rho A)), in Hz, of a slender uniform beam."""
    speed = np.sqrt(section.bending_stiffness / section.mass_per_length)
    return np.array(roots) ** 2 / (2 * np.pi * length**2) * speed


def frame_matrices(structure: Structure) -> tuple[FloatArray, FloatArray]:
    """M and K (dof, dof) of an unrefined plane frame, supports not applied."""
    size = len(structure.nodes) * 3
    mass, stiffness = np.zeros((size, size)), np.zeros((size, size))
    for element in structure.elements:
        rows = [3 * (node - 1) + i for node in element.nodes for i in range(3)]
        if isinstance(element, Spring):
            along = np.zeros(len(rows))
            along[["x", "y", "rz"].index(element.direction) :: 3] = [-1.0, 1.0][-len(element.nodes) :]
            stiffness[np.ix_(rows, rows)] += element.stiffness * np.outer(along, along)
            continue
        vector = np.subtract(structure.nodes[element.nodes[1] - 1], structure.nodes[element.nodes[0] - 1])
        m, k = _member(element, float(np.hypot(*vector)))
        c, s = vector / np.hypot(*vector)
        turn = np.zeros((6, 6))
        turn[:3, :3] = turn[3:, 3:] = [[c, s, 0], [-s, c, 0], [0, 0, 1]]
        mass[np.ix_(rows, rows)] += turn.T @ m @ turn
        stiffness[np.ix_(rows, rows)] += turn.T @ k @ turn
    for point in structure.point_masses:
        for row in (3 * point.node - 3, 3 * point.node - 2):
            mass[row, row] += point.mass
    return mass, stiffness


def _member(element: Beam | Cable, L: float) -> tuple[FloatArray, FloatArray]:
    """Mass and stiffness (6, 6) along the member, integrated over its shape functions with four Gauss points."""
    mass, stiffness = np.zeros((6, 6)), np.zeros((6, 6))
    section, is_beam = element.section, isinstance(element, Beam)
    for point, weight in zip(*leggauss(4), strict=True):
        x, dx = (point + 1) / 2, weight * L / 2
        u = np.array([1 - x, 0, 0, x, 0, 0])
        strain = np.array([-1, 0, 0, 1, 0, 0]) / L
        hermite = [1 - 3 * x**2 + 2 * x**3, L * x * (1 - x) ** 2, 3 * x**2 - 2 * x**3, L * x**2 * (x - 1)]
        bend = np.array([12 * x - 6, L * (6 * x - 4), 6 - 12 * x, L * (6 * x - 2)]) / L**2
        v, curvature = np.zeros(6), np.zeros(6)
        if is_beam:
            v[[1, 2, 4, 5]], curvature[[1, 2, 4, 5]] = hermite, bend
        else:
            v[[1, 4]] = 1 - x, x  # a bar stays straight
        mass += section.mass_per_length * dx * (np.outer(u, u) + np.outer(v, v))
        stiffness += section.axial_stiffness * dx * np.outer(strain, strain)
        stiffness += section.bending_stiffness * dx * np.outer(curvature, curvature)
    return mass, stiffness


def chain_motion(
    matrices: tuple[FloatArray, FloatArray, FloatArray],
    force: Callable[[FloatArray, FloatArray, float], FloatArray],
    start: FloatArray,
    time: FloatArray,
) -> FloatArray:
    """States (time, 2 dof) of M u'' + C u' + K u + force(u, u', t) = 0 from ``start`` (2 dof,), to about 1e-11."""
    mass, damping, stiffness = matrices
    inverse = np.linalg.inv(mass)

    def rates(t: float, state: FloatArray) -> FloatArray:
        u, v = np.split(state, 2)
        return np.concatenate([v, -inverse @ (damping @ v + stiffness @ u + force(u, v, t))])

    solution = solve_ivp(rates, (time[0], time[-1]), start, "DOP853", time, rtol=1e-12, atol=1e-12)
    return np.asarray(solution.y.T)


def newmark(
    matrices: tuple[FloatArray, FloatArray, FloatArray], start: FloatArray, step: float, count: int
) -> FloatArray:
    """Displacements (time, dof) of the linear system from rest at ``start``, constant average acceleration."""
    mass, damping, stiffness = matrices
    u, v = start, np.zeros_like(start)
    a = -np.linalg.solve(mass, stiffness @ u)
    effective = np.linalg.inv(mass + step / 2 * damping + step**2 / 4 * stiffness)
    history = [u]
    for _ in range(count):
        u_half, v_half = u + step * v + step**2 / 4 * a, v + step / 2 * a
        a = -effective @ (damping @ v_half + stiffness @ u_half)
        u, v = u_half + step**2 / 4 * a, v_half + step / 2 * a
        history.append(u)
    return np.array(history)


def held_mass(stiffness: float = 100.0) -> Structure:
    """One mass of 2 kg on a spring along x, in a chain."""
    return Structure(
        "held mass",
        ((0.0, 0.0),),
        (Spring((1,), "x", stiffness),),
        point_masses=(PointMass(1, 2.0),),
        directions=("x",),
    )
