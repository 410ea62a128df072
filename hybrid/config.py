"""What can be chosen about the hybrid model and its training, with the reason beside each number."""

from collections.abc import Iterable, Mapping
from dataclasses import dataclass, replace
from typing import Annotated, Any, Literal, get_args, get_type_hints

from annotated_types import Interval

from fe_models.errors import raise_faults
from fe_models.files.tables import did_you_mean, read_value

PresetName = Literal["default", "paper", "places", "experts"]
EncoderKind = Literal["window", "paper", "map"]
ResidualKind = Literal["free", "backbone", "places"]
IntegratorKind = Literal["propagator", "rk4", "dopri5"]
Width = Annotated[int, Interval(ge=1, le=4096)]  # of a layer: 64 MB of weights between two of the widest
Samples = Annotated[int, Interval(ge=1, le=1_000_000)]
Count = Annotated[int, Interval(ge=1, le=1_000_000)]
FewCount = Annotated[int, Interval(ge=1, le=1000)]
Threads = Annotated[int, Interval(ge=1, le=256)]
Rate = Annotated[float, Interval(ge=1e-8, le=1e6)]
Share = Annotated[float, Interval(ge=1e-6, le=1e3)]
Weight = Annotated[float, Interval(ge=0.0, le=1e6)]
Seed = Annotated[int, Interval(ge=0, le=2**32 - 1)]


@dataclass(frozen=True)
class ModelConfig:
    """Sizes of the Neural Modal ODE."""

    modes: FewCount = 10  # the bridge's first ten lie below its low-pass of 30 Hz; fewer where the model has fewer
    encoder: EncoderKind = "window"  # linear in all samples; "paper": MLP and RNN; "map": solves for the state itself
    residual: ResidualKind = "free"  # NN(z); "backbone": and curves over size; "places": at a chain's parts
    encoder_samples: Annotated[int, Interval(ge=2, le=10_000)] = 10  # n_t of the paper
    encoder_hidden: Width = 128  # width of the MLP (2 layers) of the paper's encoder
    rnn_hidden: Width = 128  # of the paper's encoder: 32 for the chain, 128 for the bridge
    net_hidden: Width = 64  # width of NN(z) (2 layers), or of each place's net (1 layer); the paper has 128
    zero_at_rest: bool = True  # the net exerts no force on a structure at rest; the paper leaves it free
    integrator: IntegratorKind = "propagator"
    substeps: FewCount = 1  # of the propagator, a sample; more where an effect of the structure needs them
    experts: bool = False  # one model a training recording, weighed by a window's first samples, instead of one of all


@dataclass(frozen=True)
class TrainingConfig:
    """How the model is trained."""

    calibrate: bool = True  # start the learned rest at the linear model that least squares finds in seconds
    window: Samples | None = None  # samples a window; None: 500, as in the paper, or fewer where recordings are short
    stride: Samples = 20  # samples between the starts of windows, as in the paper
    epochs: Count = 20
    batch: Count = 16  # as in the paper
    learning_rate: Rate = 1e-3
    first_horizon: Samples = 100  # samples forecast in the first epoch; grows to the whole window by half of the epochs
    noise_std: Share = 0.1  # standard deviation of the Gaussian likelihood, relative to each window's channels
    kl_weight: Weight = 1.0
    seed: Seed = 0
    threads: Threads = 1  # matrices this small gain little from two, and lose much where the cores are busy


@dataclass(frozen=True)
class Config:
    """The whole configuration, as it is kept in a checkpoint."""

    model: ModelConfig = ModelConfig()
    training: TrainingConfig = TrainingConfig()


def places_preset() -> Config:
    """Return the configuration for chains, whose modes are as many as their degrees of freedom.

    There a residual can be tied to the places where the structure has parts, which leaves few numbers to learn; with
    them the initial state is solved for, through the learned forces, instead of being read off by a network.
    """
    model = ModelConfig(encoder="map", residual="places", net_hidden=8, substeps=2)
    return Config(model, TrainingConfig(epochs=30, batch=100, window=501, first_horizon=20))


def experts_preset() -> Config:
    """Return the configuration for recordings that are not quite of one structure, as of a real one on different days.

    A model each, weighed by how well its recording explains a window's first samples, with frequencies and damping
    that may change with the size of the motion: sharp models are worth more where these are right.
    """
    return Config(ModelConfig(residual="backbone", experts=True))


def paper_preset(structure_name: str) -> Config:
    """Return the sizes and the training of Lai et al. 2022: nothing calibrated, rk4 with one step a sample.

    The chain has 4 modes and an RNN of 32 units, everything else the bridge's 10 modes and 128 units.
    """
    small = structure_name == "four_dof"
    model = ModelConfig(
        modes=4 if small else 10,
        encoder="paper",
        net_hidden=128,
        zero_at_rest=False,
        rnn_hidden=32 if small else 128,
        integrator="rk4",
    )
    window = 501 if small else 500
    return Config(model, TrainingConfig(calibrate=False, epochs=1600, window=window, first_horizon=window))


def configuration(preset: PresetName, structure_name: str, options: Mapping[str, Any]) -> Config:
    """Return a preset's configuration with ``options`` of the model and of the training; those that are None are left.

    ``structure_name``: the preset "paper" has other sizes for the chain. `InputError` with all that is unknown.
    """
    presets = {
        "default": Config(),
        "paper": paper_preset(structure_name),
        "places": places_preset(),
        "experts": experts_preset(),
    }
    parts = {name: part for part in ("model", "training") for name in vars(getattr(presets["default"], part))}
    faults = [] if preset in presets else [_unknown("preset", preset, get_args(PresetName))]
    faults += [_unknown("option", name, parts) for name in options if name not in parts]
    raise_faults(faults)
    chosen = presets[preset]
    given = {name: value for name, value in options.items() if value is not None}
    model, training = (
        replace(getattr(chosen, part), **{name: value for name, value in given.items() if parts[name] == part})
        for part in ("model", "training")
    )
    raise_faults([*range_faults(model), *range_faults(training)])
    return Config(model, training)


def range_faults(part: ModelConfig | TrainingConfig) -> list[str]:
    """Return a fault for each value that is not of the kind, or not in the range, that its field allows."""
    faults = list[str]()
    for name, annotation in get_type_hints(type(part), include_extras=True).items():
        read_value(annotation, getattr(part, name), name, faults)
    return faults


def _unknown(what: str, name: str, known: Iterable[str]) -> str:
    return f"{what} {name!r} is unknown{did_you_mean(name, known)}"
