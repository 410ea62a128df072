"""What a diagnosis starts from: the recordings as they are used, the nominal structure, and its first fit."""

from dataclasses import dataclass, replace

import numpy as np

from fe_models.arrays import BoolArray
from fe_models.causes.candidate import Candidate, LawCandidate
from fe_models.causes.places import Motion
from fe_models.causes.time_integration import root
from fe_models.errors import InputError
from fe_models.recordings import Dataset
from hybrid.diagnosis.contest.config import NOISE_LEVEL
from hybrid.diagnosis.contest.discrepancy import search_noise_model
from hybrid.diagnosis.contest.growing import Lengths, lengths_of, short_fit
from hybrid.diagnosis.contest.wrong_units import with_other_units
from hybrid.diagnosis.fitting.config import CALIBRATION
from hybrid.diagnosis.fitting.crossvalidation import as_recordings
from hybrid.diagnosis.fitting.driven import states_along
from hybrid.diagnosis.fitting.least_squares import Fit
from hybrid.diagnosis.nominal.candidates import all_candidates
from hybrid.diagnosis.nominal.geometry import Geometry
from hybrid.diagnosis.nominal.geometry_forces import geometries_of
from hybrid.diagnosis.nominal.ignored_assumptions import ignored_assumptions
from hybrid.diagnosis.nominal.lowpass import noise_is_lowpassed
from hybrid.diagnosis.nominal.mesh_error import coarse_mesh
from hybrid.diagnosis.nominal.modal_model import modal_model_of, with_ratios_of_modal_model
from hybrid.diagnosis.nominal.nominal_model import NominalModel
from hybrid.diagnosis.nominal.structure_model import nominal_model_of
from hybrid.diagnosis.nominal.unstated_lowpass import unstated_lowpass
from hybrid.diagnosis.recorded.batches import Batch, batches_of, columns_of, measured_columns
from hybrid.diagnosis.recorded.config import SPECTRA
from hybrid.diagnosis.recorded.faulty_channels import usable
from hybrid.diagnosis.recorded.filter_transients import without_ringing_ends
from hybrid.diagnosis.recorded.motionless_channels import without_motionless
from hybrid.diagnosis.recorded.noise import Band, noise_of_recordings, structure_band
from hybrid.diagnosis.recorded.noise_levels import NoiseLevels
from hybrid.diagnosis.recorded.noise_model import NoiseModel
from hybrid.diagnosis.recorded.offsets import without_offsets
from hybrid.diagnosis.recorded.sensor_outputs import SensorOutputs
from hybrid.diagnosis.recorded.spectra import energy_near
from hybrid.diagnosis.recorded.unit_check import other_sizes
from hybrid.diagnosis.response.hypothesis import Hypothesis
from hybrid.diagnosis.response.load_removal import without_load_response
from hybrid.diagnosis.response.marching import is_too_fast
from hybrid.known_loads.quiet_loads import with_quiet_loads
from hybrid.known_loads.short_knocks import without_short_knocks

UNLIKE = "noise goes with {pattern}: each recording counts by its own"


@dataclass(frozen=True)
class Setting:
    """A ``dataset`` less what is unusable in it, and its ``nominal`` model.

    ``geometries``: what the structure may exert beyond its linear model; whether it does, the recordings tell.
    ``modal``: the modal model that stands for the structure in the user's simulation, None where the structure does.
    ``measured``: columns of the sensors that are fitted; ``noise_model``: with the noise that the recordings tell, and
    ``searched``, with which causes are sought: mostly the same (see `discrepancy`); ``levels``: how it differs from
    recording to recording; ``band``: where the structure's motion shows; ``lengths``: the training recordings in
    segments; ``short``: the nominal fit of the shortest; ``notes``: what the user should know about the data.
    """

    dataset: Dataset
    nominal: NominalModel
    geometries: tuple[Geometry, ...]
    modal: NominalModel | None
    measured: tuple[int, ...]
    noise_model: NoiseModel
    searched: NoiseModel
    levels: NoiseLevels
    band: Band
    lengths: Lengths
    short: Fit
    notes: tuple[str, ...]

    @property
    def tolerance(self) -> float:
        """By how much of the noise floor forecasts may be worse for the user's purpose."""
        return self.dataset.assumptions.tolerance

    @property
    def is_astray(self) -> bool:
        """Whether the nominal model leaves so much that what it lacks counts as noise in the search."""
        return self.searched is not self.noise_model

    @property
    def nominal_hypothesis(self) -> Hypothesis:
        """The nominal structure, whose uncertain factors may move."""
        return Hypothesis(self.nominal)

    def test_recordings(self) -> tuple[Batch, ...]:
        """Return the recordings for testing, all channels of them, with their noise."""
        return self.with_noise(batches_of(self.dataset, "test"))

    def with_noise(self, batches: tuple[Batch, ...]) -> tuple[Batch, ...]:
        """Return batches of all channels with the noise of each recording, where these are not alike."""
        return tuple(
            _with_noise(batch, self.measured, self.nominal, self.noise_model, self.levels) for batch in batches
        )

    def candidates(self) -> tuple[Candidate, ...]:
        """Return every cause at every place that it can have."""
        motion = Motion.of_states(states_along(self.short, self.searched), self.nominal.followed_shapes)
        found = all_candidates(self.nominal, self.dataset, motion, self.measured)
        found = with_other_units(found, self.short, self.searched)
        return tuple(c for c in found if not isinstance(c, LawCandidate)) if is_too_fast(self.nominal) else found


def _too_fast(nominal: NominalModel) -> list[str]:
    """Return a note where the recordings are sampled too rarely to follow force laws.

    `InputError` where the nominal structure has some.
    """
    if not is_too_fast(nominal):
        return []
    highest = float(nominal.modes[0][-1]) / (2 * np.pi)
    told = (
        f"the recordings' {nominal.rate:.4g} samples a second are too few to follow force laws up to {highest:.4g} Hz"
    )
    if nominal.laws:
        raise InputError(f"sampling_rate: {told}, which the model has: sample more often, or make the model coarser")
    return [f"{told}: stops, friction and other nonlinear causes were not looked for"]


def setting_of(dataset: Dataset) -> Setting:
    """Return the setting of a dataset; `InputError` where it cannot be diagnosed."""
    other_end = unstated_lowpass(dataset)
    dataset, quiet = with_quiet_loads(dataset)
    dataset, knocked = without_short_knocks(dataset)
    dataset, rung = without_ringing_ends(dataset)
    dataset, unusable = usable(dataset)
    nominal = nominal_model_of(with_ratios_of_modal_model(dataset))
    dataset, motionless = without_motionless(dataset, nominal.dofs, nominal.modes[1][:, : nominal.below])
    modal = modal_model_of(nominal, dataset)
    dataset, at_rest = without_offsets(dataset, root(nominal.modes[0], nominal.own_ratios[: nominal.size]))
    dataset, apart = as_recordings(dataset)
    fast = _too_fast(nominal)
    measured = measured_columns(dataset)
    rate = dataset.sampling_rate
    band = structure_band(nominal, rate, dataset.lowpass, white=not noise_is_lowpassed(dataset))
    noise_model, levels = _noise(nominal, dataset, measured, band)
    recorded = tuple(
        _with_noise(batch, measured, nominal, noise_model, levels) for batch in batches_of(dataset, "train")
    )
    lengths = lengths_of(columns_of(recorded, measured), Hypothesis(nominal).states)
    short = short_fit(nominal, lengths, noise_model)
    if _disperses_too_far(short):
        nominal, modal = nominal.undispersed, modal and modal.undispersed
        short = short_fit(nominal, lengths, noise_model)
    searched, lengths, short = search_noise_model(nominal, lengths, noise_model, short)
    motion = Motion.of_states(states_along(short, searched), nominal.followed_shapes).displacement
    geometries = geometries_of(nominal, motion, np.random.default_rng(NOISE_LEVEL.geometry_seed))
    unlike = () if levels.are_alike or searched is not noise_model else (UNLIKE.format(pattern=levels.pattern.value),)
    notes = (
        *other_end,
        *quiet,
        *knocked,
        *rung,
        *unusable,
        *motionless,
        *at_rest,
        *other_sizes(dataset),
        *apart,
        *fast,
        *unlike,
        *ignored_assumptions(nominal, dataset.assumptions),
        *coarse_mesh(nominal, _moved(nominal, lengths.whole, noise_model)),
    )
    return Setting(
        dataset, nominal, geometries, modal, measured, noise_model, searched, levels, band, lengths, short, notes
    )


def _moved(nominal: NominalModel, batches: tuple[Batch, ...], noise_model: NoiseModel) -> BoolArray:
    """Return in which nominal modes (mode,) the recordings have motion."""
    motion = tuple(batch.recorded / batch.sigma(noise_model) for batch in batches)
    return energy_near(nominal.modes[0] / (2 * np.pi), motion, noise_model.rate) >= SPECTRA.min_energy_share


def _disperses_too_far(short: Fit) -> bool:
    """Return whether a fit takes up by dispersion what is wrong otherwise: a search would begin astray."""
    nominal = short.hypothesis.nominal
    return nominal.disperses and bool(
        abs(short.theta[nominal.dispersion]) > CALIBRATION.max_deviation_sigma * nominal.spread[nominal.dispersion]
    )


def _noise(
    nominal: NominalModel, dataset: Dataset, measured: tuple[int, ...], band: Band
) -> tuple[NoiseModel, NoiseLevels]:
    """Return the noise model with the noise of the training recordings, and how it differs between all recordings."""
    sensors, rate = tuple(dataset.sensors[i] for i in measured), dataset.sampling_rate
    outputs = SensorOutputs.measured(sensors, rate)
    train, test = (
        without_load_response(nominal, columns_of(batches_of(dataset, role), measured), outputs)
        for role in ("train", "test")
    )
    levels = NoiseLevels.of((*train, *test), rate, band)
    noise = noise_of_recordings(train, rate, band) if levels.are_alike else np.exp(levels.usual)
    return NoiseModel(sensors, rate, noise), levels


def _with_noise(
    batch: Batch, measured: tuple[int, ...], nominal: NominalModel, noise_model: NoiseModel, levels: NoiseLevels
) -> Batch:
    """Return a batch of all channels with the noise of each recording, as its ``measured`` sensors tell it."""
    if levels.are_alike:
        return batch
    noise = np.ones((len(batch.names), batch.data.shape[2]))
    (free,) = without_load_response(nominal, columns_of((batch,), measured), noise_model.outputs)
    noise[:, list(measured)] = levels.of_recordings(free)
    return replace(batch, noise=noise)
