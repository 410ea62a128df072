"""What a blind case is: what may be asked of it, what it hands over, and what it keeps apart."""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Literal

import numpy as np

from benchmarks.blind_cases.far import TrueFactor
from benchmarks.blind_cases.kinds import OUTSIDE, Excitation, StructureName, kinds_of, outside_of
from fe_models.arrays import BoolArray, FloatArray
from fe_models.base_motion import BaseMotion
from fe_models.causes import Cause, SensorDelay, SensorEffect, TimeIntegration
from fe_models.errors import InputError, raise_faults
from fe_models.measurement import lowpassed
from fe_models.recordings import Assumptions, Dataset, Load, Recording, Sensor, Uncertainty
from fe_models.structure import Structure

Tier = Literal["exact", "off", "far"]
Acts = Literal["all", "one"]
Noisy = Literal["alike", "uneven", "unfiltered"]


@dataclass(frozen=True)
class Campaign:
    """How much is recorded: ``train`` and ``test`` recordings of ``duration`` (s) at ``sampling_rate`` (Hz)."""

    train: int
    test: int
    duration: float
    sampling_rate: float

    @property
    def count(self) -> int:
        """The number of recordings."""
        return self.train + self.test

    @property
    def samples(self) -> int:
        """Samples in each recording, the first at 0 s."""
        return round(self.duration * self.sampling_rate) + 1


CAMPAIGNS = {
    "four_dof": Campaign(train=9, test=3, duration=50.0, sampling_rate=10.0),
    "bridge": Campaign(train=3, test=1, duration=19.99, sampling_rate=100.0),  # as in the laboratory, but shorter
}
AMBIENT_CAMPAIGNS = {  # nothing is forecast under unknown forces, so that nothing is kept for testing
    "four_dof": Campaign(train=3, test=0, duration=1440.0, sampling_rate=10.0),  # 57 periods of the slowest mode
    "bridge": Campaign(train=3, test=0, duration=600.0, sampling_rate=100.0),
}


def campaign_of(structure: StructureName, excitation: Excitation) -> Campaign:
    """Return what is recorded of a structure, unless a case says otherwise."""
    return (AMBIENT_CAMPAIGNS if excitation == "ambient" else CAMPAIGNS)[structure]


@dataclass(frozen=True)
class BlindConfig:
    """What a case is like: ``kinds`` to hide, and ``noise`` over each channel's rms.

    ``tier``: how near the drawing is to the truth: "exact", "off" by the stated uncertainty, or "far": off by much more
    than is stated, which stays as it is (see `far`). ``acts``: in which recordings the last of the kinds acts, "all" or
    "one": the last training recording, so that it had gone again when those for testing were made.
    ``excitation``: what moves the structure. "free": its state alone; "ambient": unknown forces, while it is linear;
    of the chain alone "measured": forces that are recorded, too, or "base": a motion of its support that is.
    ``noisy``: whether noise is "alike" in all recordings, "uneven", over the rms of each channel in each of them, or
    "unfiltered", come after the low-pass. ``size``: from 0, barely detectable, to 1, large; None draws it. ``changed``:
    number of training recordings made before the last of the kinds came; those before it act in all of them.
    ``train``, ``test``, ``duration`` (s) and ``sampling_rate`` (Hz): see `Campaign`; None leaves them to the
    ``structure``'s `CAMPAIGNS`. ``measured``: how many of its measured sensors there are, drawn; None: all. ``rich``,
    of the bridge alone: the truth is geometrically nonlinear, on a finer mesh, and all its parts differ a little from
    the drawing; without, it is the diagnosis' own linear model plus what is hidden. ``step`` (s), of the bridge alone:
    its frequencies are those of Newmark's method in such steps; None: exact.
    """

    kinds: tuple[str, ...] = ()
    tier: Tier = "exact"
    acts: Acts = "all"
    excitation: Excitation = "free"
    noise: float = 0.03
    noisy: Noisy = "alike"
    size: float | None = None
    train: int | None = None
    test: int | None = None
    duration: float | None = None
    sampling_rate: float | None = None
    measured: int | None = None
    changed: int = 0
    structure: StructureName = "four_dof"
    rich: bool = True
    step: float | None = None

    @property
    def campaign(self) -> Campaign:
        """What is recorded."""
        names = ("train", "test", "duration", "sampling_rate")
        given = {name: value for name in names if (value := getattr(self, name)) is not None}
        return replace(campaign_of(self.structure, self.excitation), **given)

    @property
    def hidden(self) -> tuple[str, ...]:
        """Those of the ``kinds`` that a diagnosis can name."""
        return tuple(kind for kind in self.kinds if kind not in OUTSIDE)

    @property
    def outside(self) -> tuple[str, ...]:
        """Those of the ``kinds`` that no cause of the list is."""
        return tuple(kind for kind in self.kinds if kind in OUTSIDE)

    @property
    def affected(self) -> BoolArray:
        """Which recordings, (recording,), what came last acts in."""
        numbers = np.arange(self.campaign.count)
        return numbers == self.campaign.train - 1 if self.acts == "one" else numbers >= self.changed

    def lasting(self, causes: Sequence[Cause]) -> tuple[Cause, ...]:
        """Return which of the hidden ``causes`` act in all recordings, whatever comes between them."""
        passing = not self.affected.all() and not self.outside
        return tuple(causes[:-1] if passing else causes)


@dataclass(frozen=True)
class BlindCase:
    """A ``dataset`` and, apart, its ``truth``: the hidden causes, and the names of the recordings where the last acts.

    ``outside``: words of what was hidden that no cause of the list is. ``clean``: the test recordings without noise.
    ``factors``: how far the groups of a structure are from their drawing, where they are far.
    """

    dataset: Dataset
    truth: tuple[Cause, ...]
    outside: tuple[str, ...]
    recordings: tuple[str, ...]
    clean: FloatArray
    factors: tuple[TrueFactor, ...] = ()


def sensors_of(every: tuple[Sensor, ...], config: BlindConfig, rng: np.random.Generator) -> tuple[Sensor, ...]:
    """Return those of ``every`` sensor that a case has: as many measured ones as wanted, drawn, and those held out."""
    if config.measured is None:
        return every
    measured = [sensor for sensor in every if sensor.role == "measured"]
    if not 1 <= config.measured <= len(measured):
        raise InputError(
            f"measured = {config.measured}; expected 1 to {len(measured)}, the sensors of {config.structure}"
        )
    kept = set(rng.choice([sensor.name for sensor in measured], size=config.measured, replace=False))
    return tuple(sensor for sensor in every if sensor.role != "measured" or sensor.name in kept)


def check_config(config: BlindConfig) -> None:
    """Raise an `InputError` with all that cannot be hidden, or not there."""
    known = kinds_of(config.structure, config.excitation) + outside_of(config.excitation)
    unknown = [kind for kind in config.kinds if kind not in known]
    faults = [f"kinds {', '.join(unknown)} are unknown; expected {', '.join(known)}"] if unknown else []
    if config.structure == "bridge" and config.excitation not in ("free", "ambient"):
        faults.append(f"excitation = {config.excitation} of the bridge; expected free or ambient, or the chain")
    if config.noisy == "unfiltered" and config.structure != "bridge":
        faults.append(f"noisy = {config.noisy}: recordings of {config.structure} have no low-pass")
    if config.step is not None and config.structure != "bridge":
        faults.append(f"step = {config.step:g} s: {config.structure} moves so slowly that its steps do not show")
    if not 0 <= config.changed <= config.campaign.train:
        faults.append(f"changed = {config.changed}; expected 0 to {config.campaign.train}, the training recordings")
    if config.acts == "one":
        if config.changed:
            faults.append(f"changed = {config.changed}: what acts in one recording has no beginning; expected 0")
        if config.campaign.train < 1:
            faults.append("train = 0: nothing can act in the last training recording; expected 1 or more")
        if config.kinds[-1:] == ("time_integration",):
            faults.append("time_integration is in the simulation, which all recordings share; it cannot act in one")
    raise_faults(faults)


def _faulty(
    shown: FloatArray, faults: list[tuple[SensorEffect, BoolArray]], sensors: tuple[Sensor, ...], rate: float
) -> FloatArray:
    """Return what is ``shown`` (recording, time, sensor) with each fault where it acts (recording,)."""
    for fault, acts in faults:
        faulty = fault.apply(shown, [sensor.name for sensor in sensors], rate)
        shown = np.where(acts[:, None, None], faulty, shown)
    return shown


def as_recorded(
    design: Structure,
    sensors: tuple[Sensor, ...],
    clean: FloatArray,
    causes: tuple[Cause, ...],
    config: BlindConfig,
    rng: np.random.Generator,
    lowpass: float | None = None,
    margin: int = 0,
    driving: Sequence[tuple[tuple[Load, ...], tuple[BaseMotion, ...]]] = (),
) -> BlindCase:
    """Return the case of the motion at the sensors, ``clean`` (recording, time, sensor): sensor faults, noise, names.

    ``design`` is what the user believes in. Behind a ``lowpass`` (Hz), the noise has nothing above it either, unless it
    is unfiltered.
    ``margin``: samples before and after each recording that are known, too: what a late sensor shows at its beginning.
    ``driving``: the recorded loads and base motions of each recording, where there are some.
    """
    campaign, affected = config.campaign, config.affected
    names = tuple(f"r{number:02d}" for number in range(1, campaign.count + 1))
    faults = [(c, affected | (c in config.lasting(causes))) for c in causes if isinstance(c, SensorEffect)]
    late, others = ([item for item in faults if isinstance(item[0], SensorDelay) is side] for side in (True, False))
    shown = _faulty(clean, late, sensors, campaign.sampling_rate)[:, margin : clean.shape[1] - margin]
    shown = _faulty(shown, others, sensors, campaign.sampling_rate)
    white = rng.standard_normal(shown.shape)
    if lowpass is not None and config.noisy != "unfiltered":
        white = np.stack([lowpassed(part, campaign.sampling_rate, lowpass) for part in white])
        white /= white.std(axis=(0, 1))
    size = shown.std(axis=1, keepdims=True) if config.noisy == "uneven" else shown.std(axis=(0, 1))
    data = shown + config.noise * size * white
    recordings = tuple(
        Recording(name, data[i : i + 1], "train" if i < campaign.train else "test") for i, name in enumerate(names)
    )
    if config.excitation == "ambient":
        recordings = tuple(replace(recording, excitation="ambient") for recording in recordings)
    for i, (loads, base) in enumerate(driving):
        driven = replace(recordings[i], loads=loads, base=base, excitation="measured")
        recordings = (*recordings[:i], driven, *recordings[i + 1 :])
    step = next((cause.step for cause in causes if isinstance(cause, TimeIntegration)), None)
    assumptions = Assumptions(integrator="newmark" if step else "exact", step=step, uncertainty=Uncertainty())
    dataset = Dataset(design, campaign.sampling_rate, sensors, recordings, lowpass, assumptions)
    acting = tuple(name for name, acts in zip(names, affected, strict=True) if acts)
    return BlindCase(dataset, causes, config.outside, acting, shown[campaign.train :])
