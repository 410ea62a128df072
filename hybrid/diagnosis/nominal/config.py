"""Numbers of the nominal model, with the reason beside each."""

from dataclasses import dataclass


@dataclass(frozen=True)
class NominalConfig:
    """The nominal model and its priors."""

    # in the basis of a frame, beyond those kept: they carry what a changed part does to the shapes
    extra_modes: int = 15
    # of a chain's highest natural frequency over the sampling rate: within one sample such a mode dies away to nothing,
    # and what is computed of it is rounding
    max_samples_below: float = 1e3
    least_std: float = 1e-6  # the least standard deviation of a factor, so that a prior of zero stays a number
    spare_damped_modes: int = 1  # mode beyond those kept whose damping is uncertain, too: a cause may bring it
    # of damping ratios that are off: they are those of the modes without any cause (-1), as causes turn them (1) or
    # between: what else dissipates may stay where it is or go with the modes, and recordings show which
    damping_turn_std: float = 1.0
    # that of recordings simulated in steps of a tenth of their interval: see `response.dispersion`
    dispersion_std: float = 1.0
    min_mass_share: float = 1e-3  # of all mass: what a part must hold to be felt
    # of what loads do to modes that are not followed: accelerations are up to a sixth derivative of them
    load_terms: int = 3
    # values of a frame that are worth one independent value: elements, joints and mesh are a little off everywhere; so
    # wide, intervals cover as many parameters of blind bridges as they should
    frame_values_per_independent: float = 4.0
    # of the most that a degree of freedom moves: the last that distinguishes unit shapes must by itself
    min_independent_share: float = 1e-6
    full_share: float = 0.2  # of a matrix's entries that are not zero: beyond, arrays multiply faster, on all cores


@dataclass(frozen=True)
class ScatterConfig:
    """Elements that are off by themselves."""

    # of a group's stated standard deviation of stiffness: that of each of its elements about the group's
    element_std_share: float = 0.25
    min_pattern_share: float = 0.006  # of the one felt most: patterns that are felt less are left alone
    # relative difference of two squared frequencies, below which their modes mix more than to first order
    min_relative_separation: float = 1e-3


@dataclass(frozen=True)
class GeometryConfig:
    """Geometric forces as polynomials of modal coordinates."""

    # elements of a beam at least: with one, what geometry adds to a portal is off by 40 %, with four by 2 %
    min_elements_per_beam: int = 4
    max_dofs: int = 3000  # ... but no more degrees of freedom than so many, with which that takes seconds
    # of the largest: modes whose displacements are smaller count once at most in a product of three
    small_mode_share: float = 0.02
    states_per_product: int = 4  # at which forces are taken, for each of the products
    reach_rms: float = 2.5  # times the rms of a motion: how far these states go
    max_iterations: int = 15  # steps at most in which the modes that are not followed give way
    max_relative_change: float = 3e-3  # of what they bend: what the last step may still change
    max_mesh_difference: float = 0.05  # of the forces: a difference that matters no more than what else is off
    max_tangent_error: float = 1e-3  # of elastic forces at a hundredth of the motion: geometric ones are less


@dataclass(frozen=True)
class MeshErrorConfig:
    """Whether a mesh is fine enough for its modes."""

    # of a natural frequency: recordings determine it to a few ten-thousandths, and the rest is taken for a cause
    min_reported_shift: float = 1e-3
    max_shift_of_fine_mesh: float = 2e-4  # of it: about what recordings determine
    # the error falls with the fourth power of the length of elements whose deflection is cubic
    convergence_order: int = 4


@dataclass(frozen=True)
class ModalDifferenceConfig:
    """Which differences between a modal model and its structure are reported."""

    # of a frequency, of a damping ratio of 1, of a MAC of 1: smaller differences are not worth a word
    min_reported_difference: float = 5e-4
    # of the product of two modes' own damping: the square of what dashpots add between them, reported beyond
    min_coupling_share: float = 0.01
    undamped_ratio_share: float = 1e-12  # of the most damped mode's: what an undamped one is taken to have


@dataclass(frozen=True)
class LowpassConfig:
    """Which low-pass recordings have passed, and what of noise and motion is beyond it."""

    # steepness of a filter that cuts off: half at the cutoff, a five-hundredth at a tenth above it
    sharp_steepness: int = 64
    # of the power below the cutoff: a Butterworth filter of order 4, run both ways, leaves 1e-4 and more
    max_power_of_sharp: float = 1e-6
    leakage_lines: int = 3  # lines of a spectrum with a Hann window: how far a sinusoid shows beyond its own
    # of a motion: what a low-pass leaves of it where motions end, unless recordings hold more than
    passed_share: float = 0.2
    # of a channel's energy: less is there of noise that was low-passed, too, or is white and under 5 %
    min_energy_share: float = 1e-3
    parts: int = 10  # of a recording: in one may ring what a release has shaken, ...
    calm_parts: int = 3  # ... and in the last there is least motion
    # of the noise in a part: releases of a mast leave 0.4 to 1.8 of it, most causes less than 0.1
    min_ringing_share: float = 0.2
    min_loudness_ratio: int = 4  # times the usual part: noise alone, after the low-pass, differs by half of that


@dataclass(frozen=True)
class UnstatedLowpassConfig:
    """Recordings that end as behind a low-pass which the dataset does not state."""

    band_far_beyond: tuple[float, float] = (1.5, 1.8)  # of an end: where nothing is
    first_line: int = 3  # line of a spectrum that has nothing of the mean, which is taken away
    max_level_ratio: float = 10.0  # of power: that near is level, ...
    max_power_ratio_beyond: float = 5e-3  # ... and this little is nothing; the usual filter leaves 2e-3
    # likewise: what motion makes of the level falls with it from one half of a recording to the other
    max_decay_ratio: float = 3.0
    min_noise_share: float = 1e-5  # of a channel's energy: motions with less noise fall as steeply
    power_share_at_cutoff: float = 0.25  # of the power: what the usual filter leaves at its cutoff
    max_share_of_stated: float = 0.75  # of the low-pass that is stated: an end below is another one
    min_lines: int = 4  # lines of a spectrum in a band that determine its level


@dataclass(frozen=True)
class CoordinateConfig:
    """Matrices in few coordinates."""

    # modes of a larger model: more than a few dozen sensors never tell apart, and a spectrum has no end
    most_modes: int = 48
    reach: float = 1.35  # of the highest frequency that was found: up to there the structure is followed
    most_whole: int = 400  # free degrees of freedom of a model that keeps them: as fast as fewer, and exact
    # nodes at which causes are sought: sensors do not tell more apart, and each costs three static shapes and a second
    most_nodes: int = 48
    min_motion_share: float = 1e-4  # of the largest motion in the modes: a node that moves less feels no force
    # of a share of K or M, by what it does to the modes seen: those and their combinations that are larger ... With
    # 6 of them natural frequencies of a tall frame whose columns lose a quarter are off by 7e-5, with 12 by 2e-6
    most_shapes_a_share: int = 12
    min_force_share: float = 1e-3  # ... than so much of the largest
    min_independent_share: float = 1e-10  # of the largest: what other shapes nearly make up is left out
    # relative difference of two natural frequencies, below which their shapes are any mixture; and by how much of it
    # the mass is then taken to differ from axis to axis, which is less than any model knows
    min_separation: float = 1e-5
    parting_share: float = 1e-3
    loads_at_once: int = 16  # of static solutions: more take more memory and no less time


NOMINAL = NominalConfig()
COORDINATES = CoordinateConfig()
SCATTER = ScatterConfig()
GEOMETRY = GeometryConfig()
MESH_ERROR = MeshErrorConfig()
MODAL_DIFFERENCE = ModalDifferenceConfig()
LOWPASS = LowpassConfig()
UNSTATED_LOWPASS = UnstatedLowpassConfig()
