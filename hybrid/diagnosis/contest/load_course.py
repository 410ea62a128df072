"""How known loads go between their samples, where what the best hypothesis leaves says that they are not smooth there.

A program that applies loads takes straight lines between their samples, a converter that drives a shaker holds each of
them. Near a tenth of the sampling rate that takes 3 % of the force away, or makes it late by half a sample: far more
than noise, and near enough to faults of loads and sensors to be taken for these.
"""

from dataclasses import replace

from fe_models.interpolant import Course
from hybrid.diagnosis.contest.evidence import Evidence
from hybrid.diagnosis.contest.setting import Setting
from hybrid.diagnosis.fitting.excess_energy import excess_energy
from hybrid.diagnosis.fitting.least_squares import Fit, fit
from hybrid.diagnosis.recorded.batches import Batch

LEAVES = 0.1  # of what the best hypothesis leaves: the most that another course may leave
WORDS: dict[Course, str] = {
    "straight": "known forces go in straight lines between their samples, as programs apply them",
    "held": "known forces hold each sample until the next one, as converters put them out",
}
NOTE = (
    "{what}: the recordings say so, as {share:.0%} of what was left beyond noise goes with it; they are taken so. Where"
    " forces were measured instead, sample faster, or behind an anti-aliasing filter"
)


def course_told(setting: Setting, evidence: Evidence) -> tuple[Course, str] | None:
    """Return how known loads go between their samples, and a note on it; None where they are smooth, or nothing tells.

    Fits of the best hypothesis, and of none, are held against those with other courses.
    """
    best, noise_model = evidence.posterior.fits[0], evidence.noise_model
    loaded = any(batch.loads is not None for batch in best.batches)
    if not loaded or setting.dataset.lowpass or not excess_energy(best, noise_model, setting.band).significant:
        return None
    trials: list[tuple[float, Course]] = []
    for course in WORDS:
        for item in {id(item): item for item in (best, evidence.base)}.values():
            found = fit(item.hypothesis, item.theta, _going(item, course), noise_model, item.states)
            trials += [] if found is None else [(found.misfit, course)]
    least, course = min(trials, default=(best.misfit, "smooth"))
    if least > LEAVES * best.misfit:
        return None
    return course, NOTE.format(what=WORDS[course], share=1 - max(least, 0.0) / best.misfit)


def _going(item: Fit, course: Course) -> tuple[Batch, ...]:
    return tuple(replace(batch, loads=batch.loads and batch.loads.going(course)) for batch in item.batches)
