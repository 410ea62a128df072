"""Hand-made diagnoses of hand-made cases, for tests of how they are judged and counted."""

from types import SimpleNamespace
from typing import Any, cast

import numpy as np

from benchmarks.blind.cases import BlindResult, Task
from benchmarks.blind.judging import judge, key_of
from benchmarks.blind_cases import BlindCase, BlindConfig
from benchmarks.peers.answer import Answer, mark
from fe_models.causes import AddedMass, Cause, CubicSpring, StiffnessChange
from fe_models.recordings import Dataset
from hybrid.diagnosis.outcome.calibration import Calibrated
from hybrid.diagnosis.outcome.conclusion import Diagnosis
from hybrid.diagnosis.outcome.findings import Alternative, Finding, Parameter
from hybrid.diagnosis.outcome.verdict import Verdict

WEAK_2, WEAK_3 = StiffnessChange((2,), 0.8), StiffnessChange((3,), 0.8)
HEAVY = AddedMass(4, 0.5)
CUBIC = CubicSpring((1,), "x", 0.3)
EXPLAINED, PARTLY, UNEXPLAINED, FINE = (
    Verdict.EXPLAINED,
    Verdict.PARTLY_EXPLAINED,
    Verdict.UNEXPLAINED,
    Verdict.NOTHING_WRONG,
)


def case_of(*truth: Cause, outside: tuple[str, ...] = ()) -> BlindCase:
    """A case of which only the truth is looked at."""
    return BlindCase(cast(Dataset, None), truth, outside, (), np.zeros(0))


def finding(cause: Cause, probability: float, off: float = 0.0, std: float = 0.01, *rivals: Cause) -> Finding:
    """A finding whose parameters are ``off`` its cause's by so much, with rivals."""
    parameters = {
        word: Parameter(float(value) + off, std, "1")
        for word, value in cause.parameters.items()
        if isinstance(value, float)
    }
    alternatives = tuple(Alternative(rival.kind, rival.location, 0.1) for rival in rivals)
    return Finding(cause, parameters, probability, 1.0, (), alternatives, "")


def diagnosis(
    verdict: Verdict,
    *findings: Finding,
    seconds: float = 5.0,
    over_floor: float = 1.1,
    calibration: tuple[Calibrated, ...] = (),
) -> Diagnosis:
    """A diagnosis of which only what is judged is there."""
    scores: dict[str, Any] = {"extended": {"measured": 0.01 * over_floor}}
    made = SimpleNamespace(
        verdict=verdict, findings=findings, scores=scores, noise_floor=0.01, seconds=seconds, calibration=calibration
    )
    return cast(Diagnosis, made)


def result(
    case: BlindCase, found: Diagnosis, peer: Answer | None = None, seed: int = 1, config: BlindConfig | None = None
) -> BlindResult:
    """The result of a case, with the marks of a peer called "peer" where its answer is given."""
    words = [*(cause.kind for cause in case.truth), *case.outside] or ["nothing"]
    marks = {} if peer is None else {"peer": mark(case, peer, 2.0)}
    return BlindResult(Task(seed, "+".join(words), config or BlindConfig()), judge(case, found), marks)


def answer(*causes: Cause, probability: float | None = None) -> Answer:
    """A peer's answer that names causes."""
    return Answer(tuple(key_of(cause) for cause in causes), probability)
