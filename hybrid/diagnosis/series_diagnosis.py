"""Diagnosis by time series: every sample is held against the drawn structure, which must be nearly right."""

from collections.abc import Callable
from dataclasses import replace
from time import perf_counter

from threadpoolctl import threadpool_limits

from fe_models.recordings import Dataset
from hybrid.diagnosis.config import THREADS
from hybrid.diagnosis.contest.evidence import gather
from hybrid.diagnosis.contest.load_course import course_told
from hybrid.diagnosis.contest.setting import setting_of
from hybrid.diagnosis.outcome.conclusion import Diagnosis, concluded


def diagnose_series(dataset: Dataset, advance: Callable[[str], object] | None = None) -> Diagnosis:
    """Return the diagnosis of a dataset; ``advance`` hears the name of each stage (`stage_names`) as it begins, and
    what is done in it, step by step.

    `InputError` names what in the dataset cannot be diagnosed.
    """
    dataset.require_recordings("a diagnosis")
    dataset = dataset.of_one_rate("a diagnosis by time series")
    begun = perf_counter()
    announce: Callable[[str], object] = advance or (lambda _: None)
    with threadpool_limits(THREADS.linear_algebra, "blas"):
        announce("recordings")
        setting = setting_of(dataset)
        evidence = gather(setting, announce)
        told = course_told(setting, evidence)
        if told is not None:
            course, note = told
            setting = setting_of(replace(dataset, load_course=course))
            setting = replace(setting, notes=(note, *setting.notes))
            evidence = gather(setting, announce)
        announce("forecasts")
        found = concluded(setting, evidence)
    return replace(found, seconds=perf_counter() - begun)
