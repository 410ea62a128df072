"""The results of a command in a folder: made beside, then exchanged as a set; never in the place of a user's file.

A command first asks `ResultSet.check`, which refuses before any work what would be written over or removed although it
is an input, another command's, the user's own, or changed by the user since. Then it writes into the new folder that
`ResultSet.replacing` gives; at its end those files take the place of all that the same command wrote before. What may
fail or takes long comes after the most valuable, with `ResultSet.adding`.

The new folder lies, hidden, within the results' folder. Once whole it is renamed (from ``.new-...`` to
``.exchange-...``), and only then are its files moved: a run that is interrupted before has changed nothing, and one
that is interrupted after is completed by whoever next reads or writes there (`finish_exchanges`).
"""

import shutil
from collections.abc import Callable, Iterable, Iterator
from contextlib import contextmanager, suppress
from dataclasses import dataclass
from errno import ENOENT, ENOTEMPTY
from fnmatch import fnmatchcase
from pathlib import Path
from secrets import token_hex

from fe_models.errors import InputError, OutputError, raise_faults
from fe_models.files.atomic import check_folder, is_of_no_other, own_token, remove_left
from fe_models.files.result_list import Files, digest, read_list, write_list
from fe_models.files.run_guard import lock_folder, remember
from fe_models.files.size_limit import file_fault

NEW_PREFIX = ".new-"
EXCHANGE_PREFIX = ".exchange-"


@dataclass(frozen=True)
class ResultSet:
    """What ``command`` writes into ``folder``: files of these ``names``, which may be patterns (``mode_*.png``)."""

    folder: Path
    command: str
    names: tuple[str, ...]

    def check(self, inputs: Iterable[Path] = ()) -> None:
        """Raise `InputError` with every reason why the results, made from ``inputs``, must not be written there."""
        read = tuple(inputs)
        check_folder(self.folder)
        lock_folder(self.folder)
        remember(read)
        finish_exchanges(self.folder)
        remove_left(self.folder)
        raise_faults(self._obstacles(self._makes, read))

    @contextmanager
    def replacing(self) -> Iterator[Path]:
        """Give a new folder to write to; at the end its files replace all that the command wrote before.

        Where the block fails, or is interrupted, the older results stay as they are.
        """
        with self._beside(adding=False) as new:
            yield new

    @contextmanager
    def adding(self) -> Iterator[Path]:
        """Give a new folder to write to; at the end its files stand beside what the command wrote before.

        Files of the same name are replaced. Where the block fails, or is interrupted, what was written before stays.
        """
        with self._beside(adding=True) as new:
            yield new

    @contextmanager
    def _beside(self, adding: bool) -> Iterator[Path]:
        check_folder(self.folder)
        finish_exchanges(self.folder)
        kept = read_list(self.folder).get(self.command, {}) if adding else {}
        new = self.folder / f"{NEW_PREFIX}{self.command}-{own_token()}"
        whole = f"those written before are whole ({', '.join(kept)})" if kept else "older ones are as they were"
        outcome = f"{self.folder}: not all results of {self.command} could be written; {whole}"
        try:
            for left in self.folder.glob(f"{NEW_PREFIX}{self.command}-*"):  # by a run that was killed
                if is_of_no_other(left, left.name.rsplit("-", 1)[1]):
                    shutil.rmtree(left)
            new.mkdir(parents=True)
            yield new
        except OSError as error:
            raise OutputError(f"{outcome} ({error.strerror or error})") from error
        except Exception as error:
            error.add_note(outcome)
            raise
        else:
            self._exchange(new, kept)
        finally:
            shutil.rmtree(new, ignore_errors=True)

    def _exchange(self, new: Path, kept: Files) -> None:
        made = {path.name: digest(path) for path in sorted(new.iterdir())}
        undeclared = [name for name in made if not self._makes(name)]
        if undeclared:
            raise ValueError(f"{self.command} writes {', '.join(undeclared)}, which {self.names} do not name")
        faults = self._obstacles(made.__contains__)
        if faults:  # of what the user did meanwhile: the work must not be lost for that
            rescued = new.rename(self.folder / f"{self.command}-{token_hex(4)}")
            raise InputError([*faults, f"the new results of {self.command} are in {rescued}"])
        write_list(new, {self.command: kept | made}, new)
        new.rename(self.folder / f"{EXCHANGE_PREFIX}{self.command}")
        finish_exchanges(self.folder)

    def _makes(self, name: str) -> bool:
        return any(fnmatchcase(name, pattern) for pattern in self.names)

    def _obstacles(self, makes: Callable[[str], bool], inputs: Iterable[Path] = ()) -> list[str]:
        """Return a fault for each reason why files must stay that a command which ``makes`` them would replace."""
        sets, read = read_list(self.folder), [path for path in inputs if not file_fault(path)]
        own = sets.get(self.command, {})
        owners = {name: command for command, files in sets.items() for name in files if command != self.command}
        reasons = dict[str, list[str]]()
        for path in sorted(self.folder.iterdir()) if self.folder.is_dir() else ():
            name = path.name
            if name not in own and not makes(name):
                continue
            if path.exists() and any(path.samefile(each) for each in read):
                reason = "read by this run"
            elif name in owners:
                reason = f"written by {owners[name]}"
            elif name not in own:
                reason = "not on the list of files that this program wrote there"
            elif digest(path) != own[name]:
                reason = f"changed since {self.command} wrote it"
            else:
                continue
            reasons.setdefault(reason, []).append(name)
        remedy = f"give another folder, such as {self.folder / self.command}"
        return [
            f"{self.folder}: {', '.join(names)} would be replaced, but {_agree(names, reason)}; {remedy}"
            for reason, names in reasons.items()
        ]


def _agree(names: list[str], reason: str) -> str:
    return f"is {reason}" if len(names) == 1 else f"are {reason.replace(' it', ' them')}"


def finish_exchanges(folder: Path) -> None:
    """Complete the exchanges of results that were interrupted in ``folder``.

    Several processes may do so at once, as whoever reads there does: what is gone has been done by another one.
    `InputError` where a file has been changed since that would be written over.
    """
    for exchange in sorted(folder.glob(f"{EXCHANGE_PREFIX}*")):
        for command, new in read_list(exchange).items():  # one; none where only the end was interrupted
            sets = read_list(folder)
            old = sets.get(command, {})
            waiting = [name for name in new if (exchange / name).is_file()]
            raise_faults(
                f"{folder / name}: was changed after {command} was interrupted, whose results wait in {exchange.name}; "
                "move it away and try again"
                for name in waiting
                if (folder / name).exists() and digest(folder / name) not in (old.get(name), new[name])
            )
            for name in waiting:
                with suppress(FileNotFoundError):
                    (exchange / name).replace(folder / name)
            for name in old.keys() - new.keys():
                with suppress(FileNotFoundError):
                    if digest(folder / name) == old[name]:
                        (folder / name).unlink()
            _write_list(folder, sets | {command: new}, exchange)
        shutil.rmtree(exchange, onerror=_unless_done)


def _write_list(folder: Path, sets: dict[str, Files], exchange: Path) -> None:
    """Write the list of ``folder`` by way of ``exchange``, unless that is gone."""
    if not exchange.is_dir():
        return
    try:
        write_list(folder, sets, exchange)
    except FileNotFoundError:
        return
    except OutputError as error:
        if not isinstance(error.__cause__, FileNotFoundError):
            raise


def _unless_done(function: object, path: str, error: tuple[object, BaseException, object]) -> None:
    """Raise what stopped the removal of ``path``, unless another process removes it at the same time."""
    reason = error[1]
    if not isinstance(reason, OSError) or reason.errno not in (ENOENT, ENOTEMPTY):
        raise reason
