"""New recordings of a station looked at, one by one: identified, held against the history, kept; changes diagnosed."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from re import sub

import numpy as np

from fe_models.assembly import linearise
from fe_models.errors import InputError
from fe_models.linear import LinearModel
from fe_models.modes import natural_modes
from fe_models.recordings import Dataset, derivative_orders
from hybrid.fleet.diagnosed_file import Options, diagnosed_file
from hybrid.identification.config import COMPARISON
from hybrid.identification.identification import identify
from hybrid.identification.pairing import displacements_of
from hybrid.monitoring.config import MONITORING
from hybrid.monitoring.control_chart import NO_MODE, judged
from hybrid.monitoring.observation import (
    Kept,
    Observation,
    SeenMode,
    Standing,
    alarms_at_the_end,
    save_kept,
    with_last,
)
from hybrid.monitoring.station import Arrived, Station

NO_ALARM = "there is no alarm to accept: the last recording is as usual"
PENDING = "to be diagnosed"  # in place of a folder, until the diagnosis is there
Identified = Callable[[Dataset], tuple[SeenMode, ...]]
Diagnose = Callable[[Path, Path], object]


@dataclass(frozen=True)
class Watch:
    """A ``station`` whose history is kept in the folder ``out``; ``least_history``: recordings before any is judged.

    ``identified`` gives the modes of a dataset of one recording; ``diagnose`` what changed, from a dataset file into a
    folder, None where changes are not diagnosed.
    """

    station: Station
    out: Path
    least_history: int = MONITORING.least_history
    identified: Identified | None = None
    diagnose: Diagnose | None = None

    def missing(self, kept: Kept, settled: float, now: float) -> list[Arrived]:
        """Return the recordings that have not been looked at: those listed first, then those that came since."""
        known = {own.file: own for own in kept.observations}

        def is_new(own: Arrived) -> bool:
            old = known.get(self.station.key(own.file))
            return old is None or (old.standing is Standing.UNREADABLE and old.modified != own.modified)

        listed = self.station.listed
        files = {own.name: self.station.key(own.file) for own in listed}
        files |= {own.name: own.file for own in kept.observations}
        new = [own for own in listed if is_new(own)]
        for own in filter(is_new, self.station.arrived(settled, now)):
            key = self.station.key(own.file)
            names = (own.name, own.file.name, *(f"{own.file.name} ({number})" for number in range(2, len(files) + 3)))
            name = next(name for name in names if files.get(name, key) == key)
            files[name] = key
            new.append(replace(own, name=name))
        return new

    def looked_at(self, kept: Kept, own: Arrived) -> Kept:
        """Return what is kept with one more recording, which is written, too."""
        listed = own.file in {each.file for each in self.station.listed}
        observation = Observation(own.name, self.station.key(own.file), own.modified, kept.state, Standing.HISTORY)
        try:
            dataset = self.station.dataset([own])
            observation = replace(observation, modes=(self.identified or modes_of)(dataset))
            observation = self._judged(observation, kept, listed, [sensor.name for sensor in dataset.sensors])
        except InputError as error:
            observation = replace(observation, standing=Standing.UNREADABLE, words=error.faults)
        except Exception as error:  # of any kind: the others go on, and every restart would meet it again
            reason = f"{type(error).__name__}: {' '.join(str(error).split())}"
            words = (f"it cannot be read, or its modes not be identified ({reason})",)
            observation = replace(observation, standing=Standing.UNREADABLE, words=words)
        earlier = tuple(each for each in kept.observations if each.file != observation.file)
        found = with_last(replace(kept, observations=earlier), observation)
        save_kept(self.out, found)
        return found

    def _judged(self, observation: Observation, kept: Kept, listed: bool, sensors: list[str]) -> Observation:
        history = kept.history
        if len(history) < max(2, self.least_history) or listed:
            if not observation.modes:  # nothing to learn from
                return replace(observation, standing=Standing.UNREADABLE, words=(NO_MODE,))
            return observation
        found = judged(history, observation, sensors)
        standing = Standing.ALARM if found.alarm else Standing.USUAL
        first = found.alarm and not alarms_at_the_end(kept.observations)
        return replace(
            observation,
            standing=standing,
            distance=found.distance,
            limits=found.limits,
            words=found.words,
            diagnosis=PENDING if first and self.diagnose is not None else "",
        )

    def diagnosed(self, kept: Kept) -> Kept:
        """Return what is kept once the first alarms of changes are diagnosed that have not been."""
        for number, own in enumerate(kept.observations):
            if own.diagnosis != PENDING or self.diagnose is None:
                continue
            name = f"change-{sub(r'[^A-Za-z0-9_.-]', '_', own.name)}"
            words, folder = own.words, name
            try:
                self._diagnose(kept, number, self.out / name)
            except Exception as error:  # of any kind: the watch goes on, and the alarm stands
                reason = " ".join(str(error).split())
                words, folder = (*words, f"the change could not be diagnosed ({type(error).__name__}: {reason})"), ""
            done = list(kept.observations)
            done[number] = replace(own, words=words, diagnosis=folder)
            kept = replace(kept, observations=tuple(done))
            save_kept(self.out, kept)
        return kept

    def _diagnose(self, kept: Kept, number: int, folder: Path) -> None:
        own = kept.observations[number]
        usual = [
            each
            for each in kept.observations[:number]
            if each.state == own.state
            and each.standing in (Standing.HISTORY, Standing.USUAL)
            and self.station.path(each.file).is_file()  # and not archived
        ]
        if not usual:
            raise InputError("no earlier recording is there any more to compare it with")
        shown = [*usual[-MONITORING.before :], own]
        file = folder / "before_and_after.toml"
        self.station.write(file, [Arrived(each.name, self.station.path(each.file), each.modified) for each in shown])
        if self.diagnose is not None:
            self.diagnose(file, folder)


def modes_of(dataset: Dataset) -> tuple[SeenMode, ...]:
    """Return the modes of a dataset of one recording, by frequency, at all its sensors."""
    model = dataset.model if isinstance(dataset.model, LinearModel) else linearise(dataset.model)
    slowest = float(natural_modes(model, 1).frequencies[0])
    recording = max(dataset.recordings, key=lambda own: own.data.shape[1])  # the longest stretch, if samples are lost
    rate = dataset.rate_of(recording)
    excitation = "measured" if recording.is_driven else recording.excitation
    found = identify(
        list(recording.data),
        rate,
        slowest,
        dataset.lowpass or rate / 2,
        derivative_orders(dataset.sensors),
        excitation,
        COMPARISON.max_modes,
    ).modes
    shapes = displacements_of(found)
    whole = found.frequencies * recording.data.shape[1] / rate >= COMPARISON.min_periods
    return tuple(
        SeenMode(
            frequency=float(found.frequencies[k]),
            frequency_error=float(found.frequency_errors[k]),
            ratio=float(found.ratios[k]),
            ratio_error=float(found.ratio_errors[k]),
            energy=float(found.energy[k]),
            shape=tuple(shapes[:, k].tolist()),
        )
        for k in np.flatnonzero(whole)
    )


def diagnose_change(file: Path, folder: Path) -> None:
    """Diagnose what changed between the recordings of a dataset ``file``, by modes; leave the report in ``folder``."""
    options = Options(by_modes=True)
    diagnosed_file(file, folder, options, ["hybrid-modal", "diagnose", str(file), "--out", str(folder), *options.words])


def accepted(kept: Kept) -> Kept:
    """Return what is kept with the last alarms as the history of a new state; `InputError` where there are none."""
    alarms = alarms_at_the_end(kept.observations)
    if not alarms:
        raise InputError(f"--accept: {NO_ALARM}")
    state, found = kept.state + 1, list(kept.observations)
    for number in alarms:
        found[number] = replace(found[number], state=state, standing=Standing.HISTORY)
    return replace(kept, observations=tuple(found))


def new_alarms(before: Sequence[Observation], now: Sequence[Observation]) -> list[Observation]:
    """Return the observations that raise an alarm now and did not stand there so before: one that a stopped run left
    without its diagnosis is told when that is done.
    """
    return [own for own in now if own.standing is Standing.ALARM and own not in before]
