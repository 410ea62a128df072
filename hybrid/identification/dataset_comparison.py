"""What the recordings of a dataset show by themselves: modes where they move freely or under unknown forces, frequency
response functions where forces are known.
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from time import perf_counter

from fe_models.errors import InputError, raise_faults
from fe_models.linear import LinearModel
from fe_models.progress import progress_bar
from fe_models.recordings import Dataset, Sensor
from fe_models.structure import Structure
from hybrid.identification.clipped_channels import clipped_notes
from hybrid.identification.comparison_report import describe_compared
from hybrid.identification.frequency_response import FrequencyResponse, extended_faults, frequency_response
from hybrid.identification.frequency_response_report import describe_responses
from hybrid.identification.recording_comparison import Compared, compare_recordings
from hybrid.known_loads.short_knocks import after_loads


@dataclass(frozen=True)
class DatasetComparison:
    """What recordings of a ``dataset`` show: modes of those that are ``free`` or ambient, ``compared`` with one another
    and the model, and frequency ``responses`` of those under known forces; None where there are none.

    ``notes``: why there are no responses although forces are known, and channels without a scale; ``seconds`` that all
    of it took.
    """

    dataset: Dataset
    free: Dataset | None
    compared: Compared | None
    responses: FrequencyResponse | None = None
    notes: tuple[str, ...] = ()
    seconds: float = 0.0

    @property
    def text(self) -> str:
        """All of it as tables in Markdown."""
        modes = describe_compared(self.compared) if self.compared else ""
        responses = describe_responses(self.responses) if self.responses else ""
        return "\n\n".join(filter(None, (modes, responses)))


def compare_dataset(
    dataset: Dataset, extended: Structure | LinearModel | None = None, progress: bool | None = None
) -> DatasetComparison:
    """Return what the recordings of a dataset show beside its model, and beside an ``extended`` one.

    Recordings under known forces whose functions cannot be had (of too few averages, say) are taken by the modes that
    they show, from where the forces have ended if most of them lies there: the decay of a knock. ``progress``: whether
    a bar is shown; left out, where there is a terminal. `InputError` where no strong mode is one of the model's, or the
    extended model does not fit.
    """
    begun = perf_counter()
    raise_faults(extended_faults(dataset, extended) if extended is not None else ())
    driven, free = dataset.parted()
    responses, notes = None, (*without_a_scale(dataset.sensors), *clipped_notes(dataset))
    if driven is not None:
        try:
            responses = frequency_response(driven, extended)
        except InputError as reason:
            free = replace(dataset, recordings=tuple(map(after_loads, dataset.recordings)))
            notes = (*notes, *(f"no frequency response functions: {fault}" for fault in reason.faults))
    compared = None
    if free is not None:
        motions = sum(len(recording.data) for recording in free.recordings)
        try:
            with progress_bar("modes of each motion", motions, "motion", shown=progress) as bar:
                compared = compare_recordings(free, bar.update)
        except InputError as reason:
            raise InputError([*notes, *reason.faults]) from reason
    return DatasetComparison(dataset, free, compared, responses, notes, perf_counter() - begun)


def without_a_scale(sensors: Sequence[Sensor]) -> tuple[str, ...]:
    """Return a note on normalised channels that have no scale beside the others, where there are any."""
    names = [sensor.name for sensor in sensors if sensor.unit == "1"]
    if not names or (len(names) == len(sensors) and len({sensor.quantity for sensor in sensors}) == 1):
        return ()
    return (
        f'{", ".join(names)}: of unit "1", normalised, beside sensors that are not, or that show another quantity:'
        " shapes and MAC, which compare sensors, are off by the factors between them; state units",
    )
