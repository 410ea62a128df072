"""One dataset file diagnosed: read, answered, saved with its page."""

from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING

from fe_models.errors import InputError, noting, raise_faults

if TYPE_CHECKING:
    from fe_models.recordings import Dataset
    from hybrid.diagnosis.answer import Answer
    from hybrid.diagnosis.learned.gain import Gain
    from hybrid.diagnosis.track_record.trust import Trust

HYBRID_OF_MATRICES = "a diagnosis of matrices trains no hybrid models; use hybrid-modal train"
HYBRID_OF_MODES = "training needs recordings, and the dataset has only modes; leave it out"


@dataclass(frozen=True)
class Options:
    """What a diagnosis does besides: also train hybrid models (``hybrid``), go ``by_modes`` in any case."""

    hybrid: bool = False
    by_modes: bool = False

    @property
    def words(self) -> list[str]:
        """The options as on a command line."""
        return ["--hybrid"] * self.hybrid + ["--by-modes"] * self.by_modes


@dataclass(frozen=True)
class Diagnosed:
    """What was ``found`` in a ``dataset``; ``trust``: how often answers like it were right; ``gain``: what was learned
    on top, where it was.
    """

    dataset: "Dataset"
    found: "Answer"
    trust: "Trust"
    gain: "Gain | None"


def diagnosed_file(
    file: Path,
    out: Path,
    options: Options,
    words: Sequence[str],
    *,
    read: Callable[["Dataset"], object] = lambda dataset: None,
    say: Callable[[Iterable[str]], object] = lambda notes: None,
) -> Diagnosed:
    """Diagnose the dataset of a ``file``, and leave report, extended structure, pictures and page in ``out``.

    ``words`` of the command that repeats it. ``read`` is given the dataset before the work, ``say`` notes on what could
    not be made. `InputError` carries all faults of the input.
    """
    from fe_models.progress import progress_bar, stage_bar
    from hybrid.diagnosis.stage_names import STAGE_NAMES
    from hybrid.result_sets import diagnosis_in

    data = _dataset(file, out, options)
    read(data)
    if options.hybrid and not data.recordings:
        raise InputError(f"--hybrid: {HYBRID_OF_MODES}")
    with progress_bar("loading", 1):
        from hybrid.diagnosis import diagnosis  # only now: it takes longer to load than a mistake to be reported
        from hybrid.diagnosis.modes_and_motion.modal_diagnosis import diagnose_modes
        from hybrid.diagnosis.recorded.amount import before_it_begins
        from hybrid.diagnosis.report_files import add_gain, save_diagnosis
        from hybrid.diagnosis.track_record.trust import trust_in
    say(before_it_begins(data))
    with stage_bar(STAGE_NAMES) as begin:
        found = diagnose_modes(data, begin) if options.by_modes else diagnosis.diagnose(data, begin)
    trust = trust_in(data, found)
    say(save_diagnosis(found, out, trust))  # now: the training below takes minutes
    gain = _learned(data, found) if options.hybrid else None
    if gain is not None:
        add_gain(found, gain, out, trust)
    from hybrid.report.diagnosis_page import page_from_files
    from hybrid.report.page_files import save_page

    say(save_page(diagnosis_in(out), lambda: page_from_files(found, data, words, file, gain)))
    return Diagnosed(data, found, trust, gain)


def _dataset(file: Path, out: Path, options: Options) -> "Dataset":
    """Return the dataset of a file once it is clear that results can be written."""
    from fe_models.files.dataset_file import load_dataset
    from fe_models.files.inputs import files_read
    from fe_models.linear import LinearModel
    from hybrid.result_sets import diagnosis_in

    faults = list[str]()
    noting(faults, "--out", diagnosis_in(out).check, files_read(file))
    data = noting(faults, "", load_dataset, file, dead_channels=True)
    raise_faults(faults)
    assert data is not None  # else there were faults
    if options.hybrid and isinstance(data.model, LinearModel):
        raise InputError(f"--hybrid: {HYBRID_OF_MATRICES}")
    return data


def _learned(data: "Dataset", found: "Answer") -> "Gain":
    """Return what hybrid models learn on top of the nominal and of the extended structure."""
    from fe_models.progress import progress_bar
    from hybrid.diagnosis.learned.gain import hybrid_gain
    from hybrid.diagnosis.learned.learning import learning_preset

    epochs = 2 * learning_preset(data.model).training.epochs  # of two models
    with progress_bar("training hybrid models", epochs, "epoch") as bar:
        return hybrid_gain(data, found, advance=bar.update)
