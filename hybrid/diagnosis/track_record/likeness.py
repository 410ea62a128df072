"""Which simulated cases an answer is most like: what was diagnosed, what moved it, and how far off its drawing is."""

from dataclasses import dataclass

from fe_models.recordings import Dataset, Recording
from fe_models.structure import Structure
from hybrid.diagnosis.answer import Answer
from hybrid.diagnosis.modes_and_motion.conclusion import ModalDiagnosis
from hybrid.diagnosis.track_record.certified import Certified, Column

CHAIN, FRAME = "four_dof", "bridge"
STRUCTURES = {CHAIN: "chains of four masses", FRAME: "cable-stayed bridges"}
SORTS = {CHAIN: "chains", FRAME: "frames"}
TIERS = ("exact", "off", "far")  # the harder the later
MOVED = {
    "free": "in free vibration",
    "ambient": "under unknown forces (wind, traffic)",
    "measured": "under known forces",
    "base": "on a moving base",
}
DRAWINGS = {
    "exact": "drawn as they were",
    "off": "whose drawings were off by 1 %",
    "far": "whose drawings were off by 10 to 40 %",
}
MATRICES = "the certificate has no models that are given as matrices"
LISTED = "the certificate has no tables of modes"
SEVERAL = "the certificate has no structures that are moved in several ways"
NO_SUCH = "the certificate has no {structure} {moved}"


@dataclass(frozen=True)
class Kind:
    """What is like an answer: the columns' words of a `Column`."""

    structure: str
    tier: str
    excitation: str
    acts: str


def kind_of(dataset: Dataset, found: Answer) -> Kind | str:
    """Return the kind of an answer about a ``dataset``; or why the certificate has none such.

    What moved it is what the answer went by, which recordings may show to be another than is stated. No drawing is
    exact: one that the answer does not call far off counts as off by its uncertainty.
    """
    if not isinstance(dataset.model, Structure):
        return MATRICES
    train = dataset.select("train")
    if dataset.modes or not train:
        return LISTED
    moved = {_excitation(recording, found) for recording in train}
    if len(moved) > 1:
        return SEVERAL
    is_far = isinstance(found, ModalDiagnosis) and bool(found.groups)
    own = set(found.findings[0].recordings) if found.findings else set[str]()
    acts = "one" if own and not {recording.name for recording in train} <= own else "all"
    return Kind(CHAIN if dataset.model.is_chain else FRAME, "far" if is_far else "off", moved.pop(), acts)


def column_like(kind: Kind, known: Certified) -> Column | str:
    """Return the column of the certificate that a ``kind`` is most like; or why there is none.

    Structure and excitation must be the same. Of the others those where the cause acts alike come first, then those
    whose drawing is at least as far off, the nearest of them, then the nearest that are easier.
    """
    same = [own for own in known.columns if (own.structure, own.excitation) == (kind.structure, kind.excitation)]
    if not same:
        return NO_SUCH.format(structure=SORTS[kind.structure], moved=MOVED[kind.excitation])
    wanted = TIERS.index(kind.tier)

    def distance(own: Column) -> tuple[bool, bool, int]:
        harder = TIERS.index(own.tier) - wanted
        return own.acts != kind.acts, harder < 0, abs(harder)

    return min(same, key=distance)


def words_of(column: Column) -> str:
    """Return what the cases of a column are, for a sentence."""
    acts = ", with a cause in one recording alone" if column.acts == "one" else ""
    return f"simulated {STRUCTURES[column.structure]} {MOVED[column.excitation]}, {DRAWINGS[column.tier]}{acts}"


def _excitation(recording: Recording, found: Answer) -> str:
    """Return what moved a structure, as the answer took it: unknown forces where the motion does not die away."""
    if recording.base:
        return "base"
    if recording.is_driven:
        return "measured"
    taken = found.identified.get(recording.name)
    return "ambient" if taken is not None and taken.is_ambient else recording.excitation or "free"
