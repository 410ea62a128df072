"""What the peers share: recordings, noise and candidates as the diagnosis takes them, the nominal model held fixed."""

from dataclasses import dataclass, replace

import numpy as np

from fe_models.arrays import FloatArray
from fe_models.causes.candidate import Candidate
from fe_models.causes.places import Motion
from fe_models.errors import raise_faults
from fe_models.recordings import Dataset
from hybrid.diagnosis.contest.growing import Lengths, lengths_of
from hybrid.diagnosis.fitting.driven import states_along
from hybrid.diagnosis.fitting.least_squares import Fit, fit
from hybrid.diagnosis.nominal.candidates import all_candidates
from hybrid.diagnosis.nominal.config import NOMINAL
from hybrid.diagnosis.nominal.lowpass import noise_is_lowpassed
from hybrid.diagnosis.nominal.structure_model import nominal_model_of
from hybrid.diagnosis.recorded.batches import batches_of, columns_of, measured_columns
from hybrid.diagnosis.recorded.filter_transients import without_ringing_ends
from hybrid.diagnosis.recorded.noise import noise_of_recordings, structure_band
from hybrid.diagnosis.recorded.noise_model import NoiseModel
from hybrid.diagnosis.response.hypothesis import Hypothesis


@dataclass(frozen=True)
class Certain:
    """The nominal model as a ``hypothesis``, the recordings in ``lengths``, its fit of the ``short`` ones, and all
    ``candidates``.
    """

    hypothesis: Hypothesis
    noise_model: NoiseModel
    lengths: Lengths
    short: Fit
    candidates: tuple[Candidate, ...]

    @property
    def matrices(self) -> tuple[FloatArray, FloatArray, FloatArray, FloatArray]:
        """M, C, K (coordinate, coordinate) of the nominal model, and the shapes (dof, coordinate) it moves in."""
        reduced = self.hypothesis.reduced(self.hypothesis.centre[None])
        return reduced.mass[0], reduced.damping[0], reduced.stiffness[0], reduced.shapes[0]


def certain_of(dataset: Dataset) -> Certain:
    """Return what a peer starts from; every factor of the nominal model is certain."""
    dataset, _ = without_ringing_ends(dataset)
    nominal, modal = nominal_model_of(dataset), dataset.assumptions.modal_model
    refused = {
        "recordings name loads: the peers take free vibrations only; leave them out": bool(nominal.loaded),
        "[simulation] modal_model: the peers know the structure only; leave it out": modal is not None,
    }
    raise_faults(fault for fault, given in refused.items() if given)
    nominal = replace(nominal, spread=np.full_like(nominal.spread, NOMINAL.least_std))
    measured = measured_columns(dataset)
    batches = columns_of(batches_of(dataset, "train"), measured)
    rate = dataset.sampling_rate
    sensors = tuple(dataset.sensors[column] for column in measured)
    band = structure_band(nominal, rate, dataset.lowpass, white=not noise_is_lowpassed(dataset))
    noise_model = NoiseModel(sensors, rate, noise_of_recordings(batches, rate, band))
    hypothesis = Hypothesis(nominal)
    lengths = lengths_of(batches, hypothesis.states)
    short = fit(hypothesis, hypothesis.centre, lengths.cut[0], noise_model)
    assert short is not None  # a linear system always answers
    motion = Motion.of_states(states_along(short, noise_model), nominal.followed_shapes)
    return Certain(hypothesis, noise_model, lengths, short, all_candidates(nominal, dataset, motion, measured))
