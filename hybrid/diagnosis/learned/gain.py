"""What the extension leaves a hybrid model to learn: trained on the nominal structure and on the extended one."""

from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import Any, Protocol

from fe_models.causes import ModalDamping, PointDamper, SlackCable, StiffnessChange, SupportSpring
from fe_models.causes.wording import at_place, kind_words
from fe_models.errors import InputError
from fe_models.progress import nothing
from fe_models.recordings import Dataset
from fe_models.structure import Structure
from hybrid.config import Config
from hybrid.diagnosis.fitting.crossvalidation import as_recordings
from hybrid.diagnosis.learned.forces import Learned
from hybrid.diagnosis.learned.projection import Projected, project
from hybrid.diagnosis.outcome.extend_matrices import ExtendedMatrices
from hybrid.diagnosis.outcome.findings import Finding
from hybrid.diagnosis.recorded.faulty_channels import usable
from hybrid.diagnosis.recorded.filter_transients import without_ringing_ends

CAUSES_OF_LAW = {  # causes that a linear law's word stands for
    "spring": (StiffnessChange.kind, SupportSpring.kind, SlackCable.kind),
    "dashpot": (PointDamper.kind, ModalDamping.kind),
}


@dataclass(frozen=True)
class Trained:
    """A hybrid's mean NRMSE of the ``measured`` and the ``held_out`` channels, what ``share`` of the acceleration was
    learned, and what of it at each place.
    """

    measured: float
    held_out: float | None
    share: float
    places: tuple[Projected, ...]


@dataclass(frozen=True)
class Gain:
    """The hybrid on the ``nominal`` and on the ``extended`` structure; None where the training was not possible."""

    nominal: Trained | None
    extended: Trained | None
    notes: tuple[str, ...]


class Extension(Protocol):
    """What a diagnosis, by whichever search, says of the structure."""

    @property
    def findings(self) -> tuple[Finding, ...]:
        """What is wrong."""

    @property
    def extended(self) -> Structure | ExtendedMatrices:
        """The structure with that built in."""


def hybrid_gain(
    dataset: Dataset,
    found: Extension,
    config: Config | None = None,
    advance: Callable[[], object] = nothing,
) -> Gain:
    """Train on both structures and score both; ``advance`` is called after each epoch of each."""
    from hybrid.diagnosis.learned.learning import corrected, learn, learning_preset  # loads PyTorch, for this alone
    from hybrid.training.gradient_training import TrainingDivergedError

    if isinstance(found.extended, ExtendedMatrices):
        raise InputError("model: a diagnosis of matrices has no structure to train on; use hybrid-modal train")
    data = _with_test(dataset)
    own = replace(data.assumptions, damping_ratio=None, modal_model=None)  # the extended structure has it all
    notes: list[str] = []
    trained: list[Trained | None] = []
    for name in ("nominal", "extended"):
        try:
            extended = name == "extended"
            each = replace(corrected(data, found.findings), model=found.extended, assumptions=own) if extended else data
            trained.append(_trained(learn(each, config or learning_preset(each.model), advance), each))
        except (InputError, TrainingDivergedError) as error:
            notes.append(f"no hybrid model of the {name} structure: {' '.join(str(error).split())}")
            trained.append(None)
    nominal, better = trained
    if nominal and better:
        notes.append(
            f"learned forces make {100 * nominal.share:.3g} % of the mean square acceleration of the hybrid on the"
            f" nominal structure, and {100 * better.share:.3g} % on the extended one"
        )
    if nominal and nominal.places:
        notes.append(_evidence(nominal.places, found.findings, found.extended))
    return Gain(nominal, better, tuple(notes))


def _with_test(dataset: Dataset) -> Dataset:
    """Return the usable part of the dataset; without test recordings the last one is set apart."""
    data, _ = as_recordings(usable(without_ringing_ends(dataset)[0])[0])
    if not data.select("test"):
        data = replace(data, recordings=(*data.recordings[:-1], replace(data.recordings[-1], role="test")))
    return data


def _trained(learned: Learned, dataset: Dataset) -> Trained:
    mean = learned.nrmse.mean(axis=0)
    by_role = {
        role: [float(mean[i]) for i, sensor in enumerate(dataset.sensors) if sensor.role == role]
        for role in ("measured", "held_out")
    }
    measured, held_out = (sum(values) / len(values) if values else None for values in by_role.values())
    assert measured is not None  # a training needs a measured sensor
    places = sorted((project(place) for place in learned.places), key=lambda item: -item.share)
    return Trained(measured, held_out, learned.share, tuple(places))


def _evidence(places: tuple[Projected, ...], findings: tuple[Finding, ...], structure: Structure) -> str:
    """Return in a sentence what the net learned most, and whether that speaks for the findings."""
    first = places[0]
    law, part = next(iter(first.laws.items()))
    said = (
        f"what a hybrid learned on the nominal structure acts mostly {at_place(first.location)}"
        f" ({first.share:.0%} of it), where {kind_words(law)} explains {part:.0%}"
    )
    placed = [finding for finding in findings if finding.cause.location]  # no place speaks for what is wrong everywhere
    if not placed:
        return said
    same = [finding for finding in placed if finding.cause.kind in CAUSES_OF_LAW.get(law, (law,))]
    if any(finding.cause.location in _locations(first, structure) for finding in same):
        return f"{said}: this speaks for the finding"
    return f"{said}: this does not speak for the findings" + (", but for their kind" if same else "")


def _locations(place: Projected, structure: Structure) -> list[dict[str, Any]]:
    """Return the locations that stand for a place: its own, and the springs of a chain between its ends.

    Whichever end was drawn first: causes go by sorted nodes.
    """
    own, nodes = place.location, sorted(place.location.get("nodes", [place.location.get("node")]))
    springs = [number for number, item in enumerate(structure.elements, start=1) if sorted(item.nodes) == nodes]
    return [own | {"nodes": nodes} if "nodes" in own else own, *({"element": number} for number in springs)]
