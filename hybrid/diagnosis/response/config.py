"""Numbers of how a hypothesis moves and what its sensors show of that, with the reason beside each."""

from dataclasses import dataclass


@dataclass(frozen=True)
class HypothesisConfig:
    """What parameter vectors may stand for."""

    min_mass_share: float = 1e-12  # of the largest mass: what less is, is rounding
    max_log_factor: float = 3.0  # of an uncertain factor: twenty times as much or as little is no calibration


@dataclass(frozen=True)
class ReductionConfig:
    """Static shapes that enrich the natural modes of the nominal model."""

    min_new_length_share: float = 1e-6  # of a shape's length: what must be left of it for it to add to the basis
    min_eigenvalue_share: float = 1e-12  # of the largest eigenvalue: what counts as a force that a change brings
    # of a change at one place, on which a static shape each is spent; modes serve one spread over a group of elements
    max_local_forces: int = 6
    # ... but for as many forces on single modes that others beyond give way to by this share of their energy
    min_energy_share: float = 1e-6


@dataclass(frozen=True)
class EigenmodeConfig:
    """Modes of the variants of a Jacobian, to first order."""

    # largest entry of D: variants mix modes by less; what is left out is in proportion to its square
    max_mixing: float = 1e-3
    min_eigenvalue_share: float = 1e-12  # of the largest: what a squared natural frequency counts as where it buckles


@dataclass(frozen=True)
class DispersionConfig:
    """Time steps in which recordings were simulated."""

    normal_step_share: float = 0.1  # of the sampling interval: time steps of that length are normal


@dataclass(frozen=True)
class TrailingConfig:
    """Modes that are not followed, and that dashpots take along."""

    # of roots and what trails them: 60 N s/m on the bridge are off by 8e-5 of a root after one, by 2e-6 after two
    rounds: int = 2
    # times the lowest natural frequency of what trails: roots that are faster, of a dashpot that all but holds its
    # place, take nothing along; what they would, no few modes show
    cutoff_ratio: float = 2.0
    cutoff_order: int = 8  # power of the ratio: how sharply they stop to


@dataclass(frozen=True)
class ResidualConfig:
    """How a frame gives way to force laws in the modes that are not followed."""

    folded_share: float = 0.05  # of a motion: what a low-pass leaves where sampling folds the stiffest coordinates to
    min_flexibility_share: float = 1e-9  # of a place's flexibility: what less is, is rounding
    min_mass_share: float = 1e-9  # of the largest generalised mass: less have shapes of laws at one place
    max_softening_share: float = 0.5  # of a force: what a softening spring may gain by what gives way behind it


@dataclass(frozen=True)
class StateSpaceConfig:
    """Linear motions as sums of exponentials."""

    max_growth_nepers: float = 200.0  # of a motion without damping, in all; more would overflow, and is as wrong
    max_condition: float = 1e9  # condition number of eigenvectors, beyond which matrix exponentials serve better
    soft_spring_share: float = 1e-8  # of the highest eigenvalue: springs that hold a body that moves freely
    # rad: what the largest root times a sample counts as at least, of a single mass that nothing holds any more
    min_turn_per_sample: float = 1e-3
    # of the largest root: roots that lie closer count as one, of which phi is t exp(root t)
    min_root_distance: float = 1e-9


@dataclass(frozen=True)
class MarchingConfig:
    """Steps of a motion under force laws, and the tables of these."""

    # rad: largest omega times substep where a force law acts; its pull on that mode is then off by 5e-4
    max_phase_per_substep: float = 1.0
    # rad: the same under known forces, with the stiffness of laws in omega. Forces drive a structure deep into its laws
    # for long, with little noise: the motion of a spring that stiffens by 30 % is off by 1e-3 at 0.9, by 3e-5 at 0.45
    max_phase_under_loads: float = 0.5
    min_substeps: int = 2  # a sample: contacts and friction set in between samples
    max_substeps: int = 40  # a sample
    max_sharp_substeps: int = 8  # a sample, of a sharp law, as friction that holds its place
    # largest rate times substep; the scheme is stable up to 2.79 (Runge and Kutta's on the real axis)
    max_rate_per_substep: float = 2.5
    # a sample, that keep a law stable: one sharper than that hunts about its place, within its own creep
    max_stabilising_substeps: int = 32
    table_intervals: int = 8192  # an even number: the middle of a table is at rest
    range_ratio: float = 2.0  # times what the linear motion can reach at most: how far tables go
    widening_ratio: float = 8.0  # times as far, where a motion leaves them
    max_ranges: int = 4  # tables that are tried; a motion that goes further has exploded
    # times the sampling rate: half of it folds where a low-pass leaves much, one and a half times where little
    oversampling: int = 2
    # condition number of coordinates that are still known as well as slopes by finite differences need them
    max_coordinate_condition: float = 1e6


HYPOTHESIS = HypothesisConfig()
REDUCTION = ReductionConfig()
EIGENMODES = EigenmodeConfig()
DISPERSION = DispersionConfig()
TRAILING = TrailingConfig()
RESIDUAL = ResidualConfig()
STATE_SPACE = StateSpaceConfig()
MARCHING = MarchingConfig()
