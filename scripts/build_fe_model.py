"""Build a finite element model in Exudyn: matrices, natural modes, their pictures and, on request, synthetic data."""

from collections.abc import Callable, Iterable
from dataclasses import dataclass, replace
from functools import partial
from pathlib import Path
from typing import Annotated, Literal, TypeVar

import numpy as np
import typer
from scipy.sparse import csr_array

from fe_models.arrays import FloatArray
from fe_models.assembly import linearise
from fe_models.built_in.bridge import PAPER_FREQUENCIES
from fe_models.built_in.four_dof import PAPER_OMEGA, four_dof
from fe_models.causes.dead_load import dead_load_share
from fe_models.damping import full_damping
from fe_models.dofs import structure_dofs
from fe_models.errors import InputError, bad_input_exits, noting, raise_faults
from fe_models.files.bridge_recordings import bridge_sensors
from fe_models.files.dataset_file import save_dataset
from fe_models.files.matrices_file import LARGEST_DENSE, save_linear_model
from fe_models.files.modal_file import load_modal_model
from fe_models.files.models import load_model
from fe_models.files.recording_checks import UNITS
from fe_models.files.structure_file import save_structure
from fe_models.four_dof_data import paper_dataset
from fe_models.linear import LinearModel, ModalModel
from fe_models.modes import natural_modes
from fe_models.recordings import Dataset, Quantity, Sensor
from fe_models.simulation import FreeConfig, ReleaseConfig
from fe_models.statics import STANDARD_GRAVITY, PointLoad
from fe_models.structure import Beam, Cable, Direction, Structure
from fe_models.synthetic import Acquisition, check_release, free_dataset, release_dataset

DEFAULT_MODES = 10
BRIDGE_PULLS = ("19:y:-9.81", "13:y:-9.81", "9:y:-9.81", "15:y:-9.81")
Role = Literal["measured", "held_out"]
Word = TypeVar("Word", bound=str)
Value = TypeVar("Value")
QUANTITIES: tuple[Quantity, ...] = ("displacement", "velocity", "acceleration")
DIRECTIONS: tuple[Direction, ...] = ("x", "y", "rz")
ROLES: tuple[Role, ...] = ("measured", "held_out")


@dataclass(frozen=True)
class Wishes:
    """The options on recordings as given; None where the choice is left to the program."""

    pull: list[str] | None
    sensor: list[str] | None
    realisations: int | None
    cubic_stiffness: float | None
    duration: float | None
    step: float | None
    sampling_rate: float | None
    lowpass: float | None
    noise: float | None
    gravity: float | None
    modal_model: Path | None = None

    def useless(self, *names: str, because: str) -> list[str]:
        """Return one fault for each of the options ``names`` that was given although it has no effect."""
        given = [name for name in names if getattr(self, name) is not None]
        return [f"--{name.replace('_', '-')}: {because}" for name in given]


# Plain help: the richer one reads ":x:" in an example as the name of a picture.
app = typer.Typer(add_completion=False, rich_markup_mode=None, pretty_exceptions_enable=False)


@app.command()
def main(
    model: Annotated[
        str, typer.Argument(help="four_dof, bridge, a structure (.toml), or your own M, K, C (.npz, or .toml on them).")
    ],
    out: Annotated[Path, typer.Option(help="Folder for the results; made where it is missing.")],
    refine: Annotated[int, typer.Option(min=1, max=10_000, help="Finite elements per beam.")] = 1,
    modes: Annotated[
        int | None, typer.Option(min=1, help="Natural modes, from the lowest. [default: 10, or all of a small model]")
    ] = None,
    pictures: Annotated[bool, typer.Option(help="Draw the mode shapes.")] = True,
    simulate: Annotated[
        bool, typer.Option("--simulate", help="Also write simulated recordings, OUT/dataset.toml.")
    ] = False,
    pull: Annotated[
        list[str] | None,
        typer.Option(
            help="NODE:DIRECTION:FORCE (N; N m for rz) let go, several joined by +. Repeat for more recordings."
        ),
    ] = None,
    sensor: Annotated[
        list[str] | None, typer.Option(help="NODE:DIRECTION[:QUANTITY[:held_out]], acceleration unless told. Repeat.")
    ] = None,
    realisations: Annotated[
        int | None, typer.Option(min=1, help="Chains: motions from random initial states. [default: 1000]")
    ] = None,
    cubic_stiffness: Annotated[float | None, typer.Option(help="four_dof: cubic spring k_n at node 1, N/m^3.")] = None,
    duration: Annotated[
        float | None, typer.Option(max=1e5, help="Length of a recording, s. [default: 20; chains 50]")
    ] = None,
    step: Annotated[float | None, typer.Option(help="Integrator step, s. [default: 0.001; chains 0.05]")] = None,
    sampling_rate: Annotated[float | None, typer.Option(max=1e5, help="Hz. [default: 100; chains 10]")] = None,
    lowpass: Annotated[float | None, typer.Option(help="Hz, 0 for none. [default: 30; chains none]")] = None,
    noise: Annotated[
        float | None, typer.Option(help="Standard deviation over that of the channel. [default: 0.02]")
    ] = None,
    gravity: Annotated[float | None, typer.Option(help="m/s^2, along -y. [default: 9.81]")] = None,
    modal_model: Annotated[
        Path | None, typer.Option(help="four_dof: modal model (.npz: omega, xi, phi) that the dataset is given.")
    ] = None,
    seed: Annotated[int, typer.Option(min=0, max=2**32 - 1, help="Of noise and random initial states.")] = 0,
) -> None:
    """Build a finite element model: matrices, natural modes and their pictures; with --simulate also recordings.

    OUT/model.npz holds M, K and C over the free degrees of freedom (in sparse parts where large), dof_node and
    dof_direction of their rows, frequencies (Hz), damping_ratio, and mode_shapes over all degrees of freedom.
    OUT/structure.toml is the structure, to edit and build again.

    Simulated recordings have what the linear model lacks. Frames come to rest under gravity, prestress and the pulls,
    which then let go: large displacements, P-delta, slack cables, noise. A recording starts 0.1 s after the release,
    when its jump, smeared by the low-pass, has died down. Of several recordings the last is for testing.
    Chains start from random states; four_dof gives the data of the paper (its own numbers with seed 0, 1000 motions).

    \b
    Examples:
      python scripts/build_fe_model.py bridge --out runs/bridge
      python scripts/build_fe_model.py bridge --out runs/data --simulate \\
          --pull 19:y:-9.81 --pull 9:y:-5+21:y:-5
      python scripts/build_fe_model.py four_dof --out runs/four_dof \\
          --simulate --cubic-stiffness 1
      python scripts/build_fe_model.py frame.toml --out runs/frame --refine 4 \\
          --simulate --pull 3:x:100 --sensor 2:x
    """
    wishes = Wishes(
        pull, sensor, realisations, cubic_stiffness, duration, step, sampling_rate, lowpass, noise, gravity, modal_model
    )
    with bad_input_exits():
        subject = load_model(model, Path())
        if isinstance(subject, Structure):
            subject = subject.refined(subject.divisions * refine)
        elif refine > 1:
            raise InputError(f"{model} holds matrices only: --refine needs a structure (.toml)")
        if not simulate:
            raise_faults(wishes.useless(*vars(wishes), because="is for simulated recordings; add --simulate"))
        simulation = recordings_of(model, subject, wishes, seed) if simulate else None
        recordings = simulation() if simulation else None  # before anything is written: it may fail
        modal = build(subject, out, modes)
        print(f"Natural modes {described(subject)}:")
        print(frequency_table(modal, paper_frequencies(model)))
        if pictures:
            from fe_models.pictures.render import draw_modes  # loads the graphics library only where it is needed

            print(f"Mode shapes: {draw_modes(subject, modal, out)[-1]}")
        if recordings is not None:
            print(f"Recordings: {save_dataset(recordings, out)}")


def build(subject: Structure | LinearModel, out: Path, modes: int | None) -> ModalModel:
    """Write ``out``/model.npz and, of a structure, structure.toml; return the modes."""
    linear = subject if isinstance(subject, LinearModel) else linearise(subject)
    size = linear.mass.shape[0]
    modal = natural_modes(linear, modes or min(DEFAULT_MODES, size))
    if linear.has_modal_damping and size <= LARGEST_DENSE:  # C complete where it can be
        linear = replace(linear, damping=csr_array(full_damping(linear)), modal_ratios=(), replaced_ratios=())
    results = {
        "frequencies": modal.frequencies,
        "damping_ratio": modal.damping_ratio,
        "mode_shapes": modal.shapes,
    }
    save_linear_model(linear, out / "model.npz", results)
    if isinstance(subject, Structure):
        save_structure(subject, out / "structure.toml")
    print(f"{size} free degrees of freedom; matrices and modes: {out / 'model.npz'}")
    return modal


def paper_frequencies(model: str) -> FloatArray:
    """Return the frequencies (Hz) that the paper gives for a built-in structure, else none."""
    known = {"bridge": np.array(PAPER_FREQUENCIES), "four_dof": np.array(PAPER_OMEGA) / (2 * np.pi)}
    return known.get(model, np.zeros(0))


def described(subject: Structure | LinearModel) -> str:
    """Return about which state a model moves, in words."""
    loaded = isinstance(subject, Structure) and dead_load_share(subject) > 0
    return "about the state at rest under weight and prestress" if loaded else "without loads and prestress"


def frequency_table(modal: ModalModel, paper: FloatArray) -> str:
    """Return the modes as a table, beside the paper's frequencies where there are any."""
    lines = ["mode   frequency   damping ratio" + ("   paper" if len(paper) else "")]
    for number, (frequency, ratio) in enumerate(zip(modal.frequencies, modal.damping_ratio, strict=True), start=1):
        line = f"{number:4d}   {frequency:6.4f} Hz   {100 * ratio:z11.3f} %"
        known = paper[number - 1 : number]
        lines.append(line + "".join(f"   {value:.4f} Hz ({100 * (frequency / value - 1):+.3f} %)" for value in known))
    return "\n".join(lines)


def recordings_of(model: str, subject: Structure | LinearModel, wishes: Wishes, seed: int) -> Callable[[], Dataset]:
    """Check the options on recordings, all at once, and return the simulation that they ask for."""
    if isinstance(subject, LinearModel):
        raise InputError(f"{model} holds matrices only: --simulate needs a structure (.toml)")
    if model == "four_dof":
        return _paper_chain(wishes, seed)
    faults = wishes.useless("cubic_stiffness", because="is for four_dof; write effects into the structure file")
    faults += wishes.useless("modal_model", because="is for four_dof; name it in your dataset's [simulation] instead")
    sensors = _all_of(wishes.sensor or (), _sensor, faults)
    if model == "bridge" and not wishes.sensor:
        sensors = bridge_sensors(unit="m/s^2")
    elif not wishes.sensor:
        faults.append("--simulate needs sensors: give at least one --sensor NODE:DIRECTION, such as --sensor 2:x")
    is_frame = any(isinstance(element, Beam | Cable) for element in subject.elements)
    make = _frame if is_frame else _chain
    return make(model, subject, sensors, wishes, np.random.default_rng(seed), faults)


def _paper_chain(wishes: Wishes, seed: int) -> Callable[[], Dataset]:
    options = ("pull", "sensor", "duration", "step", "sampling_rate", "lowpass", "noise", "gravity")
    because = "four_dof gives the paper's data; for others build its structure.toml instead"
    raise_faults(wishes.useless(*options, because=because))
    rng = np.random.RandomState(seed)  # the legacy generator of the paper's data
    modal = load_modal_model(wishes.modal_model, structure_dofs(four_dof())) if wishes.modal_model else None
    return partial(paper_dataset, wishes.cubic_stiffness or 0.0, modal, rng, wishes.realisations or 1000)


def _frame(
    model: str,
    structure: Structure,
    sensors: tuple[Sensor, ...],
    wishes: Wishes,
    rng: np.random.Generator,
    faults: list[str],
) -> Callable[[], Dataset]:
    faults += wishes.useless("realisations", because="is for chains; a frame is pulled and released, repeat --pull")
    texts = wishes.pull or (BRIDGE_PULLS if model == "bridge" else ())
    releases = _all_of(texts, _loads, faults)
    if not texts:
        faults.append("--simulate needs something to let go: give --pull NODE:DIRECTION:FORCE, such as --pull 3:y:-10")
    acquisition = _acquisition(wishes, sampling_rate=100.0, lowpass=30.0)
    config = ReleaseConfig(
        duration=_either(wishes.duration, 20.0),
        sampling_rate=5 * acquisition.sampling_rate,
        step=_either(wishes.step, 1e-3),
        gravity=_either(wishes.gravity, STANDARD_GRAVITY),
    )
    raise_faults(faults + check_release(structure, releases, sensors, acquisition))
    return lambda: release_dataset(structure, releases, sensors, acquisition, rng, config).dataset


def _chain(
    model: str,
    structure: Structure,
    sensors: tuple[Sensor, ...],
    wishes: Wishes,
    rng: np.random.Generator,
    faults: list[str],
) -> Callable[[], Dataset]:
    faults += wishes.useless("pull", "gravity", because=f"is for frames; {model} is a chain, see --realisations")
    acquisition = _acquisition(wishes, sampling_rate=10.0, lowpass=0.0)
    config = FreeConfig(_either(wishes.duration, 50.0), acquisition.sampling_rate, _either(wishes.step, 0.05))
    raise_faults(faults + check_release(structure, (), sensors, acquisition))
    return partial(free_dataset, structure, wishes.realisations or 1000, sensors, acquisition, rng, config)


def _acquisition(wishes: Wishes, sampling_rate: float, lowpass: float) -> Acquisition:
    lowpass = _either(wishes.lowpass, lowpass)
    return Acquisition(_either(wishes.sampling_rate, sampling_rate), lowpass or None, _either(wishes.noise, 0.02))


def _either(wish: float | None, default: float) -> float:
    return default if wish is None else wish


def _all_of(texts: Iterable[str], read: Callable[[str], Value], faults: list[str]) -> tuple[Value, ...]:
    """Return what ``read`` makes of each text, noting the faults of those it cannot read."""
    values = (noting(faults, "", read, text) for text in texts)
    return tuple(value for value in values if value is not None)


def _loads(text: str) -> tuple[PointLoad, ...]:
    """Return the loads of one release, NODE:DIRECTION:FORCE joined by +."""
    loads = []
    for part in text.split("+"):
        try:
            node, direction, force = part.split(":")
            loads.append(PointLoad(int(node), _one_of(DIRECTIONS, direction), float(force)))
        except ValueError:
            raise InputError(f"--pull {text}: expected NODE:DIRECTION:FORCE, such as 19:y:-9.81, joined by +") from None
    return tuple(loads)


def _sensor(text: str) -> Sensor:
    """Return the sensor that NODE:DIRECTION[:QUANTITY[:held_out]] describes, named by it: "12:y" of acceleration."""
    parts = text.split(":")
    try:
        node, direction = int(parts[0]), _one_of(DIRECTIONS, parts[1])
        quantity = _one_of(QUANTITIES, parts[2] if len(parts) > 2 else "acceleration")
        role = _one_of(ROLES, parts[3] if len(parts) > 3 else "measured")
    except (ValueError, IndexError):
        parts = []
    if not 2 <= len(parts) <= 4:
        raise InputError(f"--sensor {text}: expected NODE:DIRECTION[:QUANTITY[:held_out]], such as 12:y:acceleration")
    name = f"{quantity[0]}{node}{direction}"
    return Sensor(name, node, direction, quantity, UNITS[quantity, direction == "rz"], role)


def _one_of(known: tuple[Word, ...], text: str) -> Word:
    """Return the word of ``known`` that ``text`` is; `ValueError` where it is none."""
    return known[known.index(text)]


if __name__ == "__main__":
    app()
