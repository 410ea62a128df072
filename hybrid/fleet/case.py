"""One dataset of a fleet as a task of its own: what is to be done, and the work, which prints nothing."""

import hashlib
from collections.abc import Iterable
from dataclasses import dataclass
from math import isfinite
from pathlib import Path

from fe_models.errors import InputError
from hybrid.fleet.diagnosed_file import Diagnosed, Options, diagnosed_file


@dataclass(frozen=True)
class Case:
    """A dataset ``file`` by its ``name``, whose results go into the folder ``out``, both absolute; the ``digest`` of
    its inputs and options, "" where they cannot be read.
    """

    name: str
    file: str
    out: str
    options: Options
    digest: str


@dataclass(frozen=True)
class Told:
    """An answer in a line: its ``verdict`` as in reports, and in ``words``, with a ``tone``; the ``sentence`` and its
    ``probability``, forecast errors ``before`` and ``after``, the ``noise_floor``, and the time it took, ``seconds``;
    None of what there is not. ``change_gain``: of what acts in some recordings alone, the share of what forecasts of
    these get wrong that it takes away. ``notes``: what could not be made beside the report.
    """

    verdict: str
    words: str
    tone: str
    sentence: str
    probability: float | None
    before: float | None
    after: float | None
    noise_floor: float | None
    seconds: float
    notes: tuple[str, ...] = ()
    change_gain: float | None = None


def case_of(name: str, file: Path, folder: Path, options: Options) -> Case:
    """Return the case of a dataset in a fleet whose results are in ``folder``."""
    own = file.absolute()
    return Case(name, str(own), str(folder.absolute() / name), options, digest_of(own, options))


def digest_of(file: Path, options: Options) -> str:
    """Return the SHA-256 of all that an answer depends on: what is read, the options, and the program's version."""
    from hybrid.report.provenance import inputs_of, versions

    own = dict(versions()).get("hybrid-modal", "")
    digest = hashlib.sha256(repr((own, options)).encode())
    try:
        for part in inputs_of(file):
            digest.update(repr((part.name, part.size, part.sha256)).encode())
    except OSError:
        return ""
    return digest.hexdigest()


def diagnosed_case(case: Case) -> Told | tuple[str, ...]:
    """Diagnose a dataset; return the answer in a line, or the faults of its input.

    A function of the case and the files it names alone, so that it may run on another machine.
    """
    from fe_models.progress import silent

    notes = list[str]()
    words = ["hybrid-modal", "diagnose", case.file, "--out", case.out, *case.options.words]

    def say(said: Iterable[str]) -> None:
        notes.extend(said)

    with silent():
        try:
            done = diagnosed_file(Path(case.file), Path(case.out), case.options, words, say=say)
        except InputError as error:
            return error.faults
    return told(done, tuple(notes))


def told(done: Diagnosed, notes: tuple[str, ...] = ()) -> Told:
    """Return an answer in a line."""
    from hybrid.report.answer import sentence_of, verdict_of

    found = done.found
    words, tone = verdict_of(found)
    before, after = (_finite(found.scores[name]["measured"]) for name in ("baseline", "extended"))
    return Told(
        verdict=found.verdict.value,
        words=words,
        tone=tone.value,
        sentence=sentence_of(found, done.dataset).replace("\N{NO-BREAK SPACE}", " "),
        probability=found.findings[0].probability if found.findings else None,
        before=before,
        after=after,
        noise_floor=_finite(found.noise_floor),
        seconds=round(found.seconds, 2),
        notes=notes,
        change_gain=_finite(found.findings[0].gain) if found.findings else None,
    )


def _finite(value: float | None) -> float | None:
    return None if value is None or not isfinite(value) else float(value)
