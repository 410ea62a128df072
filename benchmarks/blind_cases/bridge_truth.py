"""The bridge that is hidden in a blind case, and its motion after a weight is cut loose.

Its cables are bars without prestress: a tension that the drawing does not know of would be a cause of its own. What
does not belong to a cause is exact, or, where asked for, richer than any diagnosis has it: beams that are geometrically
exact, on a mesh twice as fine, with all nodes and sections a little beside the drawing.
"""

from dataclasses import dataclass, replace

import numpy as np

from benchmarks.blind_cases.ambient import UnknownForces, ambient_motion
from benchmarks.blind_cases.marching import Force, Grid, damping_coupling, integrate_motion
from fe_models.arrays import FloatArray
from fe_models.assembly import linearise
from fe_models.causes import ForceLaw, TimeIntegration
from fe_models.causes.laws import force_laws
from fe_models.linear import LinearModel, ModalModel
from fe_models.modes import natural_modes
from fe_models.recordings import QUANTITIES, Sensor, Uncertainty
from fe_models.structure import Beam, Element, Spring, Structure, group_name

OUTPUT_RATE = 500.0  # Hz; far enough above the recordings' rate for their low-pass to act first
SMOOTH_STEPS, STEPS = 1, 2  # in each 1 / OUTPUT_RATE: without force laws and with them
DIVISIONS = 2
SCATTER = 2e-4  # of sections, and of nodes relative to the shortest deck element: too small to ask about
SCATTER_OFF = 1e-3  # likewise of a bridge that is off: a tenth of that, so that it is no longer off in wholes alone
SHORTEST_ELEMENT = 0.2  # m
MAX_PHASE_PER_STEP = 0.5  # of a mode's phase, rad a step


@dataclass(frozen=True)
class Start:
    """How a motion begins: ``weights``, (node, N) each, cut loose, and ``rates`` (mode,) of the lowest modes.

    The rates are in units of the mass-normalised shapes (m kg^0.5 / s), for a velocity on top of the deflection.
    """

    weights: tuple[tuple[int, float], ...]
    rates: FloatArray


@dataclass(frozen=True)
class Truth:
    """A bridge to simulate: the ``structure`` with its effects, and ``ratios`` (mode,) of its damping, dashpots left
    out, to the drawn one.

    ``rich``: with the geometric nonlinearity of its beams and cables. ``step`` (s): in which Newmark's method simulates
    its linear motion; None: exactly.
    """

    structure: Structure
    ratios: FloatArray
    rich: bool
    step: float | None = None


def off_by_uncertainty(design: Structure, rng: np.random.Generator) -> Structure:
    """Return the bridge with stiffness and mass of the deck, of each tower and of each cable off as wholes."""
    usual, elements = Uncertainty(), list(design.elements)
    groups: dict[str, list[int]] = {}
    weight: dict[int, float] = {}  # of each node's added mass, relative to the drawn one
    for position, element in enumerate(elements):
        name = group_name(element) if isinstance(element, Beam) else f"cable {position + 1}"
        groups.setdefault(name, []).append(position)
    for name, positions in groups.items():
        stiffness, mass = 1 + np.array([usual.stiffness, usual.mass]) * rng.standard_normal(2)
        for position in positions:
            elements[position] = _scaled(elements[position], float(stiffness), float(mass), name)
            if isinstance(elements[position], Beam):
                weight |= dict.fromkeys(elements[position].nodes, float(mass))
    masses = tuple(replace(point, mass=point.mass * weight[point.node]) for point in design.point_masses)
    return replace(design, elements=tuple(elements), point_masses=masses)


def scattered(design: Structure, share: float, rng: np.random.Generator) -> Structure:
    """Return the bridge with every node and every section off by a small ``share``, on a finer mesh."""
    moved = np.array(design.nodes) + share * SHORTEST_ELEMENT * rng.standard_normal((len(design.nodes), 2))
    factors = 1 + share * rng.standard_normal(len(design.elements))
    elements = [
        _scaled(element, float(factor), 1.0, f"element {number}")
        for number, (element, factor) in enumerate(zip(design.elements, factors, strict=True), start=1)
    ]
    return replace(design, nodes=tuple(map(tuple, moved.tolist())), elements=tuple(elements), divisions=DIVISIONS)


def motion_at(
    truth: Truth,
    starts: tuple[Start, ...],
    sensors: tuple[Sensor, ...],
    duration: float,
    margin: float,
    more: tuple[ForceLaw, ...] = (),
    highest: float = np.inf,
) -> FloatArray:
    """Return what each of the ``sensors`` would show without noise, (motion, time, sensor), at `OUTPUT_RATE`.

    From ``margin`` s before the time 0, with which time-dependent forces count, to as much after the ``duration`` (s).
    ``more``: force laws on top of those of the structure's effects. Modes above ``highest`` (Hz) are at rest first.
    """
    linear, modal = modes_of(truth)
    laws = (*force_laws(truth.structure), *more)
    others = _geometric(truth.structure, linear, modal) if truth.rich else _coupled_damping(linear, modal)
    modal = modal if truth.step is None else _stepped(modal, truth.step)
    states = [modal_state(modal, start, highest) for start in starts]
    q, p = (np.stack(part, axis=-1) for part in zip(*states, strict=True))
    steps = STEPS if laws else SMOOTH_STEPS
    outputs = round((duration + 2 * margin) * OUTPUT_RATE)
    grid = Grid(-margin, 1 / OUTPUT_RATE, outputs, steps)
    rows = [modal.dofs.row(sensor.node, str(sensor.direction)) for sensor in sensors]
    motion = integrate_motion(modal, (q, p), grid, rows, laws, others)
    which = [QUANTITIES.index(sensor.quantity) for sensor in sensors]
    return motion[which, :, range(len(sensors))].transpose(2, 1, 0)  # (motion, time, sensor)


def ambient_at(
    truth: Truth, forces: UnknownForces, sensors: tuple[Sensor, ...], duration: float, margin: float
) -> FloatArray:
    """Return what the ``sensors`` would show of so small a motion that it is linear, as `motion_at` does, (1, time,
    sensor). Modes too fast for `OUTPUT_RATE` are left out: far above the recordings' low-pass they just give way.
    """
    linear, modal = modes_of(truth)
    modal = modal if truth.step is None else _stepped(modal, truth.step)
    count = int(np.sum(modal.frequencies < OUTPUT_RATE / 2))
    modal = ModalModel(modal.omega[:count], modal.damping_ratio[:count], modal.shapes[:, :count], modal.dofs)
    return ambient_motion(linear, modal, forces, sensors, duration + 2 * margin, OUTPUT_RATE)[None]


def modes_of(truth: Truth) -> tuple[LinearModel, ModalModel]:
    """Return the linear model of a truth, and all its modes with the damping that the truth has."""
    linear = linearise(truth.structure)
    modal = natural_modes(linear, linear.mass.shape[0])
    factors = np.ones(len(modal.omega))
    factors[: len(truth.ratios)] = truth.ratios[: len(factors)]
    factors[[mode - 1 for mode, _ in linear.replaced_ratios]] = 1.0  # what an effect says, it says of the truth
    ratio = modal.damping_ratio + (factors - 1) * _own_ratios(truth.structure, modal)
    return linear, replace(modal, damping_ratio=ratio)


def _stepped(modal: ModalModel, step: float) -> ModalModel:
    """Return what Newmark's method shows in steps of ``step`` s of the modes that these follow; the others just give
    way, as they do without steps.
    """
    followed = modal.omega * step < MAX_PHASE_PER_STEP
    shown = TimeIntegration(step).frequency_and_ratio(modal.omega[followed], modal.damping_ratio[followed])
    omega, ratio = modal.omega.copy(), modal.damping_ratio.copy()
    omega[followed], ratio[followed] = shown
    return replace(modal, omega=omega, damping_ratio=ratio)


def _scaled(element: Element, stiffness: float, mass: float, name: str) -> Element:
    """Return the element with its stiffness and mass multiplied; ``name`` distinguishes its section from others."""
    assert not isinstance(element, Spring)  # the bridge is drawn without
    section = element.section
    return replace(
        element,
        section=replace(
            section,
            name=f"{section.name}, {name}",
            youngs_modulus=section.youngs_modulus * stiffness,
            density=section.density * mass,
        ),
    )


def modal_state(modal: ModalModel, start: Start, highest: float) -> tuple[FloatArray, FloatArray]:
    """Return modal coordinates and rates (mode,): the deflection under the weights, and the rates."""
    load = np.zeros(len(modal.dofs))
    for node, weight in start.weights:
        load[modal.dofs.row(node, "y")] -= weight
    moving = modal.frequencies < highest
    q = np.where(moving, load @ modal.shapes / modal.omega**2, 0.0)
    p = np.zeros_like(q)
    count = min(len(start.rates), int(moving.sum()))
    p[:count] = start.rates[:count]
    return q, p


def _own_ratios(structure: Structure, modal: ModalModel) -> FloatArray:
    """Return the damping ratios (mode,) that the structure has without dashpots: Rayleigh's."""
    own = structure.damping
    return np.asarray(own.mass_factor / (2 * modal.omega) + own.stiffness_factor * modal.omega / 2)


def _coupled_damping(linear: LinearModel, modal: ModalModel) -> Force | None:
    """Return the modal forces of what damping couples the modes; None where it does not."""
    coupling = damping_coupling(linear, modal)
    own = 2 * modal.damping_ratio * modal.omega
    if np.abs(coupling).max() <= 1e-9 * own.max():  # rounding
        return None
    return lambda q, p: np.asarray(-coupling @ p)


def _geometric(structure: Structure, linear: LinearModel, modal: ModalModel) -> Force:
    """Return the modal forces that the structure exerts beyond those of its modes."""
    from fe_models.exudyn.internal_forces import InternalForces  # loads Exudyn only where it is needed

    forces = InternalForces(structure)
    free = modal.shapes[modal.dofs.free]
    stiffness = (modal.omega**2)[:, None]
    damping = np.einsum("di,di->i", free, linear.damping @ free)[:, None]

    def beyond(q: FloatArray, p: FloatArray) -> FloatArray:
        u, v = modal.shapes @ q, modal.shapes @ p  # (dof, motion)
        exerted = np.stack([forces(u[:, i], v[:, i]) for i in range(u.shape[1])], axis=-1)
        return np.asarray(modal.shapes.T @ exerted + stiffness * q + damping * p)

    return beyond
