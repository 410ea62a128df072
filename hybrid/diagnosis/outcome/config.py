"""Numbers of verdicts, findings and what is said beside them, with the reason beside each."""

from dataclasses import dataclass


@dataclass(frozen=True)
class VerdictConfig:
    """When a simulation is right, wrong, or explained."""

    # of the noise floor, in the forecast, by a second cause; a first one by the user's tolerance: beside one that the
    # simulation is wrong is no longer asked, but in what
    min_second_gain: float = 0.01
    max_explained_excess: float = 0.03  # share of the excess energy that is left where all is called explained
    max_certain_excess: float = 0.01  # likewise, where that is certain, however far it is beyond noise
    # of what was wrong, in fit and forecast: where less is left, it is what interpolation and steps leave of recordings
    # with next to no noise, and no further cause
    max_negligible_share: float = 1e-3
    max_near_ratio: float = 1.15  # times the noise floor: as near as a model that is off by its uncertainty must come
    max_part_share: float = 0.5  # of what was wrong: where more is left, nothing is explained
    max_usual_sigma: float = 4.0  # stated: a calibration beyond takes the place of something else that is wrong
    listed: float = 0.85  # probability of a cause on the list, where something significant is left or two adjoin, ...
    # ... and where a part only is explained: in blind cases such a name is wrong where what was hidden is not on the
    # list, and mostly right where it is one of two causes
    listed_in_part: float = 0.25


@dataclass(frozen=True)
class MaterialityConfig:
    """Which significant causes explain something."""

    # of the energy that the nominal model gets wrong: what takes no more away explains nothing ...
    max_trifles: tuple[float, float] = (0.02, 0.005)  # alone, and beside another cause
    min_share_of_rest: float = 0.5  # ... unless it takes that much away of what is wrong without it
    far_ratio: float = 2.0  # times what is normal: a calibration that far off stands for a cause
    max_mostly_left: float = 0.5  # of what a fit leaves: where one cause more leaves no more, it is most of what missed


@dataclass(frozen=True)
class RestConfig:
    """Where and when something is left."""

    min_share: float = 0.2  # of what is left: a channel or mode that has less is not reported
    min_times_usual: float = 2.0  # its part of all values: a recording that has more stands out, ...
    min_share_of_outstanding: float = 0.5  # ... if all of these have more of what is left
    near_share: float = 0.1  # of a natural frequency: what is further off is not near it ...
    near_lines: float = 4.0  # ... nor further than so many lines of the spectrum
    late_ratio: float = 2.0  # times as much of the motion's energy: what is left late, beside what is left early


@dataclass(frozen=True)
class MentionConfig:
    """From where on something is mentioned."""

    min_dispersion_sigma: float = 4.0  # standard deviations
    min_acting_fall: float = 12.0  # in the tempered sum of squares of a test recording, by a cause that acts in it
    max_left_of_changed: float = 0.1  # of what is left beyond noise: what a fit with a changed dataset may leave
    min_alternative_probability: float = 0.005
    min_load_factor_change: float = 0.02  # a factor nearer to one is none
    load_factor_rounds: int = 3  # of the factor and the nominal values in turn
    max_moved_share: float = 0.5  # of what a channel differs by from its own place: another one must differ by less
    fold_share: float = 0.02  # of a natural frequency: how well the model knows it
    min_machine_probability: float = 0.99  # from which on hum needs no mention
    # below which a machine is none: by chance one looks like hum where others show next to nothing of it
    max_no_machine_probability: float = 0.05
    max_imperfect_ratio: float = 2.0  # times what noise makes: a perfect model that misses by more tells little
    max_helped_share: float = 0.8  # of it: a sensor that does not bring it down so far is no help


@dataclass(frozen=True)
class ShareConfig:
    """What counts as nothing."""

    next_to_nothing: float = 1e-9  # of the energy of an error
    # of the energy of noise: what the nominal model may leave beyond it by chance, one hundredth in NRMSE
    max_by_chance: float = 0.02
    difference_step: float = 1e-6  # relative: between a search's parameter and the reported one


VERDICT = VerdictConfig()
MATERIALITY = MaterialityConfig()
REST = RestConfig()
MENTION = MentionConfig()
SHARE = ShareConfig()
