"""What the options of `hybrid-modal benchmark` ask for: one of six runs, and the options that each of them heeds."""

from collections.abc import Mapping
from enum import Enum
from typing import Any

from benchmarks.row import Section
from fe_models.errors import raise_faults


class RunKind(Enum):
    """What one call measures; the value is the option that asks for it, none for the table."""

    TABLE = ""
    BLIND = "--blind"
    RATES = "--rates"
    NEXT = "--next"
    CERTIFICATE = "--certificate"
    AUDIT = "--audit"


ALWAYS = frozenset({"out", "quiet"})
# on blind cases, however many
CASES = frozenset({"kinds", "structure", "tier", "off", "acts", "excitation", "jobs", "seed"})
HEEDED: dict[RunKind, frozenset[str]] = {
    RunKind.TABLE: frozenset({"only", "modal_model", "recordings", "seed", "quick"}),
    RunKind.BLIND: CASES | {"noise", "noisy", "changed", "step", "train", "test", "sensors", "peers"},
    RunKind.RATES: CASES,
    RunKind.NEXT: frozenset({"seed"}),
    RunKind.CERTIFICATE: frozenset({"jobs", "minutes", "dirty"}),
    RunKind.AUDIT: frozenset({"quick"}),
}
"""Names of the parameters that each run heeds, beside those that all do."""


def run_kind(given: Mapping[str, Any]) -> RunKind:
    """Return what the parameters that a user has ``given`` ask for; `InputError` where they do not go together."""
    asked = [kind for kind in RunKind if kind.value and kind.value[2:] in given]
    if len(asked) > 1:
        raise_faults([f"{' and '.join(kind.value for kind in asked)} are different runs: give one of them"])
    kind = asked[0] if asked else RunKind.TABLE
    useless = sorted(set(given) - ALWAYS - HEEDED[kind] - {kind.value[2:]})
    raise_faults([_useless(name, given[name], kind) for name in useless] + _needing_another(given))
    return kind


def _useless(name: str, value: object, kind: RunKind) -> str:
    negated = "no-" if value is False else ""
    here = f"with {kind.value}" if kind.value else "in the table"
    none = f"none of {', '.join(other.value for other in RunKind if other.value)}"
    homes = [other.value or none for other in RunKind if name in HEEDED[other]]
    return f"--{negated}{name.replace('_', '-')} has no effect {here}: it goes with {' or '.join(homes)}"


def _needing_another(given: Mapping[str, Any]) -> list[str]:
    """Return a fault for each option that another one's value leaves without effect."""
    only, faults = given.get("only"), list[str]()
    if only and Section.BRIDGE in only and "recordings" not in given:
        faults.append("--only bridge needs --recordings FOLDER, with the authors' acc_measured1..4.mat")
    if only and Section.BRIDGE not in only and "recordings" in given:
        faults.append("--recordings has no effect: --only leaves the bridge out")
    if "step" in given and given.get("structure") != "bridge":
        faults.append("--step has no effect on the chain: it goes with --structure bridge")
    if given.get("off") and given.get("tier", "off") != "off":
        faults.append(f"--off and --tier {given['tier']} contradict each other: give one of them")
    return faults
