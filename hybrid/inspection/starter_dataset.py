"""A dataset file to start from: what the recording says is filled in, and what only its user knows is asked for."""

from collections.abc import Sequence
from pathlib import Path

from fe_models.files.recording_checks import UNITS, UNITS_BESIDE
from fe_models.files.signals import Signals
from fe_models.files.unit_words import known_unit
from fe_models.recordings import Quantity
from hybrid.inspection.channel_facts import ChannelFacts
from hybrid.inspection.likely_excitation import Guess, Moved

QUANTITY_OF: dict[str, Quantity] = {si: quantity for (quantity, _), si in UNITS.items()}
READABLE = {"1", *UNITS.values(), *(word for units in UNITS_BESIDE.values() for word in units)}
WORDS = {Moved.AMBIENT: "ambient", Moved.FREE: "free"}
DECAYS = (
    '# These look like several decays, one behind the other. "ambient" takes them as they are; better, cut the file\n'
    "# into one recording for each decay."
)


def starter_dataset(signals: Signals, facts: Sequence[ChannelFacts], guess: Guess, file: str) -> str:
    """Return the text of a dataset on a recording, named ``file`` in it; CHECK marks what to fill in."""
    rate = signals.sampling_rate
    lines = [
        "schema = 1",
        'model = "model.toml"   # CHECK: your structure file, matrices, or "bridge", "four_dof"',
        f"sampling_rate = {rate:.10g}   # Hz, {signals.rate_from}"
        if rate
        else "# sampling_rate = 100.0   # CHECK: Hz; the file does not say it",
        "# lowpass = 30.0   # Hz, if the recordings passed a filter",
        "",
    ]
    for number, fact in enumerate(facts):
        if number not in guess.channels:
            lines += _sensor(fact, signals.key is None)
    lines += _recording(signals, guess, file)
    return "\n".join(lines) + "\n"


def _sensor(fact: ChannelFacts, may_be_left_out: bool) -> list[str]:
    """Return the table of a sensor; of a dead one as a comment, but for an array, each column of which is a sensor."""
    known = known_unit(fact.unit)
    quantity = None if known is None else QUANTITY_OF.get(known.si)
    unit = "1" if quantity is None or known is None else fact.unit if fact.unit in READABLE else known.si
    is_rotation = known is not None and known.si.startswith("rad")
    asked = "CHECK: acceleration, velocity or displacement" if quantity is None else f"from its unit, {fact.unit}"
    lines = [
        "[[sensors]]",
        f"name = {_quoted(fact.name)}",
        "node = 1   # CHECK: where it sits in the model, from 1",
        'direction = "rz"' if is_rotation else 'direction = "y"   # CHECK: "x", "y" or "rz"',
        f'quantity = "{quantity or "acceleration"}"   # {asked}',
        f'unit = "{unit}"' + ("" if quantity else '   # CHECK: "m/s^2", "g", "mm", ...; "1" if it is normalised'),
        "",
    ]
    if not fact.is_dead:
        return lines
    if not may_be_left_out:
        return [f"# {fact.name} never changes: a dead channel, which a diagnosis leaves out.", *lines]
    return [f"# {fact.name} never changes: a dead channel, left out.", *(f"# {line}" for line in lines if line), ""]


def _recording(signals: Signals, guess: Guess, file: str) -> list[str]:
    lines = [
        "[[recordings]]",
        f"name = {_quoted(Path(file).stem)}",
        f"file = {_quoted(file)}",
        *([f"key = {_quoted(signals.key)}"] if signals.key and Path(file).suffix.lower() != ".npy" else []),
        'role = "train"   # "test": only scored; give at least one of each, from other recordings',
    ]
    if guess.moved is Moved.DECAYS:
        lines.append(DECAYS)
    if guess.moved in WORDS:
        lines.append(f'excitation = "{WORDS[guess.moved]}"   # CHECK: it looks like {guess.moved.value}')
    elif guess.moved is Moved.MEASURED:
        place = ["node = 1   # CHECK: where it acts", 'direction = "y"   # CHECK']
        lines += ["[[recordings.loads]]", *place, *_driving(signals, guess, file)]
    elif guess.moved is Moved.BASE:
        unit = signals.units[guess.channels[0]]
        lines += ["[[recordings.base]]", 'direction = "x"   # CHECK', *_driving(signals, guess, file)]
        lines.append(f'unit = "{unit}"' if unit in READABLE else 'unit = "m/s^2"   # CHECK: or "g"')
    else:
        lines.append('# excitation = "ambient"   # CHECK: or "free"; or name a force in loads, an earthquake in base')
    return lines


def _driving(signals: Signals, guess: Guess, file: str) -> list[str]:
    """Return where the values of a load or a base motion stand."""
    first, *others = guess.channels
    lines = [f"file = {_quoted(file)}", f"key = {_quoted(signals.names[first])}"]
    return [*lines, *(f"# {signals.names[other]}: give it a table like this one" for other in others)]


def _quoted(text: str) -> str:
    return '"' + text.replace("\\", "\\\\").replace('"', '\\"') + '"'
