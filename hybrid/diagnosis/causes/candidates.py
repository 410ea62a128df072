"""All causes at all places of a structure, of its sensors and of its simulation."""

from functools import partial

import numpy as np

from fe_models.causes import ModalDamping, SensorDelay, SensorDrift, SensorGain
from fe_models.recordings import Dataset
from hybrid.diagnosis.causes.candidate import Candidate
from hybrid.diagnosis.causes.force_causes import force_laws_of, harmonic_forces
from hybrid.diagnosis.causes.linear_causes import linear_causes
from hybrid.diagnosis.causes.places import Motion, places_of
from hybrid.diagnosis.nominal.plant import Plant

MOST_DAMPED = 0.99  # ratio: an effect's is below one
DAMPED = 0.05  # the prior standard deviation of a damping ratio
OFF = 0.3  # that of a sensor's gain about one
LATE = 0.03  # that of its delay, of a period


def all_candidates(plant: Plant, dataset: Dataset, motion: Motion, measured: tuple[int, ...]) -> tuple[Candidate, ...]:
    """Return every cause at every place that it can have; ``measured``: columns of the sensors that are fitted."""
    places = places_of(plant, motion)
    longest = max(recording.data.shape[-2] for recording in dataset.select("train"))  # samples
    return (
        *linear_causes(plant, places),
        *_modes(plant),
        *force_laws_of(plant, places, motion),
        *harmonic_forces(places, dataset.sampling_rate / longest, plant.highest),
        *_sensors(plant, dataset, motion, measured),
        *_steps(plant),
    )


def _modes(plant: Plant) -> list[Candidate]:
    return [
        Candidate(
            kind=ModalDamping.kind,
            location={"modes": [mode + 1]},
            names=("ratio",),
            build=partial(ModalDamping, (mode + 1,)),
            neutral=(float(ratio),),
            width=(DAMPED,),
            lower=(0.0,),
            upper=(max(MOST_DAMPED, float(ratio)),),
            mode=mode,
        )
        for mode, ratio in enumerate(plant.own_ratios[: plant.below])
    ]


def _sensors(plant: Plant, dataset: Dataset, motion: Motion, measured: tuple[int, ...]) -> list[Candidate]:
    found = []
    moving = plant.dofs.direction != "rz"  # rotations are no lengths
    period = 2 * np.pi * float(np.std(motion.displacement[..., moving]) / np.std(motion.velocity[..., moving]))
    for position, column in enumerate(measured):
        name = dataset.sensors[column].name
        data = [recording.data[..., column] for recording in dataset.select("train")]
        size = float(np.mean([part.std() for part in data]))
        time = max(part.shape[-1] for part in data) / dataset.sampling_rate
        for word, cause, neutral, width in (
            ("factor", SensorGain, 1.0, OFF),
            ("delay", SensorDelay, 0.0, LATE * period),
            ("slope", SensorDrift, 0.0, size / time),
        ):
            found.append(
                Candidate(
                    kind=cause.kind,
                    location={"sensor": name},
                    names=(word,),
                    build=partial(cause, name),
                    neutral=(neutral,),
                    width=(width,),
                    lower=(-np.inf,),
                    sensor=position,
                )
            )
    return found


def _steps(plant: Plant) -> list[Candidate]:
    known = plant.integration
    return [] if known is None else [Candidate(known.kind, {}, (), lambda: known, (), (), ())]
