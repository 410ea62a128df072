"""The code that runs: its commit, and whether anything in it is not committed."""

import subprocess
from dataclasses import dataclass
from hashlib import sha256
from pathlib import Path

from fe_models.errors import InputError

ROOT = Path(__file__).parents[2]
NO_CLONE = "is no clone of the repository; a certificate states the commit that ran, so run it from a clone"
INSTALLED = Path("hybrid/diagnosis/track_record/certified.json")  # what a certificate writes: no result depends on it
PRODUCT = ("fe_models", "hybrid", "benchmarks", f":(exclude){INSTALLED}")  # what a case's result depends on


@dataclass(frozen=True)
class Code:
    """A ``commit``, and the SHA-256 of the ``changes`` to the product that are not committed; "" where all is."""

    commit: str
    changes: str = ""

    @property
    def words(self) -> str:
        """Commit and changes in words."""
        return f"commit {self.commit[:12]}" + (" with changes that are not committed" if self.changes else "")


def code_of(root: Path = ROOT) -> Code:
    """Return the code in a clone of the repository; `InputError` where it is none."""
    commit, top = _git(root, "rev-parse", "HEAD", "--show-toplevel").decode().split("\n", 1)
    if not root.samefile(top.strip()):
        raise InputError(f"{root}: {NO_CLONE}")
    changes = _git(root, "diff", "HEAD", "--", *PRODUCT)
    new = _git(root, "ls-files", "--others", "--exclude-standard", "-z", "--", *PRODUCT).decode()
    for name in filter(None, new.split("\0")):
        changes += name.encode() + (root / name).read_bytes()
    return Code(commit, sha256(changes).hexdigest() if changes else "")


def _git(root: Path, *words: str) -> bytes:
    try:
        return subprocess.run(["git", *words], cwd=root, capture_output=True, check=True).stdout
    except (OSError, subprocess.CalledProcessError) as error:
        raise InputError(f"{root}: {NO_CLONE}") from error
