"""Diagnosis by time series: every sample is held against the drawn structure, which must be nearly right."""

from collections.abc import Callable
from dataclasses import dataclass, replace
from time import perf_counter

from threadpoolctl import threadpool_limits

from fe_models.recordings import Dataset
from hybrid.diagnosis.config import THREADS
from hybrid.diagnosis.contest.evidence import Singles, gather
from hybrid.diagnosis.contest.load_course import course_told
from hybrid.diagnosis.contest.setting import setting_of
from hybrid.diagnosis.outcome.conclusion import Diagnosis, concluded


@dataclass(frozen=True, eq=False)
class SeriesSearch:
    """A diagnosis of a ``dataset`` that has tried each cause alone, the ``singles``."""

    dataset: Dataset
    singles: Singles

    @classmethod
    def with_singles(cls, dataset: Dataset, tell: Callable[[str], object]) -> "SeriesSearch":
        """Return it after each cause alone; ``tell`` hears the name of each stage (`stage_names`) as it begins, and
        what is done in it.

        `InputError` names what in the dataset cannot be diagnosed.
        """
        dataset.require_recordings("a diagnosis")
        dataset = dataset.of_one_rate("a diagnosis by time series")
        with threadpool_limits(THREADS.linear_algebra, "blas"):
            tell("recordings")
            return cls(dataset, Singles.of(setting_of(dataset), tell))

    def finished(self, tell: Callable[[str], object], pairs: bool = True) -> Diagnosis:
        """Return the diagnosis, with all that is tried beyond causes alone; ``pairs``: see `gather`."""
        setting = self.singles.setting
        with threadpool_limits(THREADS.linear_algebra, "blas"):
            evidence = gather(self.singles, tell, pairs)
            told = course_told(setting, evidence)
            if told is not None:
                course, note = told
                setting = setting_of(replace(self.dataset, load_course=course))
                setting = replace(setting, notes=(note, *setting.notes))
                evidence = gather(Singles.of(setting, tell), tell, pairs)
            tell("forecasts")
            return concluded(setting, evidence)


def diagnose_series(dataset: Dataset, advance: Callable[[str], object] | None = None) -> Diagnosis:
    """Return the diagnosis of a dataset; ``advance`` hears the name of each stage (`stage_names`) as it begins, and
    what is done in it, step by step.

    `InputError` names what in the dataset cannot be diagnosed.
    """
    begun = perf_counter()
    tell: Callable[[str], object] = advance or (lambda _: None)
    found = SeriesSearch.with_singles(dataset, tell).finished(tell)
    return replace(found, seconds=perf_counter() - begun)
