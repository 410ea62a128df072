"""Groups of a structure that is far from its drawing: which findings say so rightly, and how well factors are known."""

from collections.abc import Mapping
from typing import Any

from benchmarks.blind_cases import BlindCase
from benchmarks.blind_cases.far import TrueFactor
from fe_models.causes import Cause, MassChange, StiffnessChange
from fe_models.structure import Structure
from fe_models.uncertain_parts import UncertainPart, uncertain_parts
from hybrid.diagnosis.answer import Answer

MAX_DEVIATION_SIGMA = 2.0  # of a factor: normal errors stay within it in 95 of 100


def is_far(cause: Cause, case: BlindCase) -> bool:
    """Return whether a cause is that a whole group of the drawing is off, and the case says so of it, or of the larger
    one that it belongs to.
    """
    quantity = {StiffnessChange.kind: "stiffness", MassChange.kind: "mass"}.get(cause.kind)
    elements = _elements(cause.location)
    return any(part.quantity == quantity and set(part.elements) == elements for part, _ in _far_parts(case))


def factors_within(found: Answer, case: BlindCase) -> tuple[bool, ...]:
    """Return for each stiffness and mass of a group that is far from its drawing whether the factor that was found is
    within two standard deviations of the true one; not where a hidden cause changes the group, too.
    """
    touched = set[int]().union(*(_elements(cause.location) for cause in case.truth))
    marks = []
    for part, true in _far_parts(case):
        if touched.isdisjoint(part.elements):
            own = [
                item for item in found.calibration if (item.quantity, item.location) == (part.quantity, part.location)
            ]
            marks += [abs(item.factor - true.factor) <= MAX_DEVIATION_SIGMA * item.std for item in own]
    return tuple(marks)


def _far_parts(case: BlindCase) -> list[tuple[UncertainPart, TrueFactor]]:
    """Return the parts of a drawing that are off, each with the factor of the group it belongs to."""
    drawn = case.dataset.model if case.factors else None
    if not isinstance(drawn, Structure):
        return []
    groups = [(true, _elements(true.location)) for true in case.factors]
    return [
        (part, true)
        for part in uncertain_parts(drawn)
        for true, group in groups
        if true.what == part.quantity and part.elements and group.issuperset(part.elements)
    ]


def _elements(location: Mapping[str, Any]) -> set[int]:
    return set(location.get("elements") or ([location["element"]] if "element" in location else []))
