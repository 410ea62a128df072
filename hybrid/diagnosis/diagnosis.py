"""The whole chain: show what a simulation gets wrong, name the cause, extend the model, measure the gain."""

from collections.abc import Callable
from dataclasses import replace
from time import perf_counter

from fe_models.recordings import Dataset
from hybrid.diagnosis.conclusion import Diagnosis, concluded
from hybrid.diagnosis.evidence import gather
from hybrid.diagnosis.setting import setting_of


def diagnose(dataset: Dataset, advance: Callable[[str], object] | None = None) -> Diagnosis:
    """Return the diagnosis of a dataset; ``advance`` is told what is done, step by step.

    `InputError` names what in the dataset cannot be diagnosed.
    """
    begun = perf_counter()
    tell: Callable[[str], object] = advance or (lambda _: None)
    setting = setting_of(dataset)
    evidence = gather(setting, tell)
    tell("forecasts")
    return replace(concluded(setting, evidence), seconds=perf_counter() - begun)
