"""The paper's 4-DOF example: accuracy, the oracle beside it, whole records, bands, and the time it takes."""

import time
from collections.abc import Callable, Iterator
from dataclasses import dataclass, replace

import numpy as np
import torch

from benchmarks.row import Row
from fe_models.arrays import FloatArray
from fe_models.assembly import linearise
from fe_models.built_in.four_dof import four_dof
from fe_models.causes.laws import force_laws
from fe_models.four_dof_data import paper_dataset
from fe_models.linear import ModalModel
from fe_models.modes import natural_modes
from fe_models.progress import nothing
from fe_models.recordings import Dataset
from fe_models.simulation import FreeConfig, simulate_free
from hybrid.config import Config, places_preset
from hybrid.estimation.forecast import forecast_windows
from hybrid.estimation.uncertainty import BandedForecast, coverage, set_relative_error
from hybrid.neural_modal_ode.model import NeuralModalODE
from hybrid.neural_modal_ode.residuals.free_residual import NoResidual
from hybrid.neural_modal_ode.scaling import StateScale
from hybrid.neural_modal_ode.state_prior import StatePrior
from hybrid.training.forecast_comparison import compare
from hybrid.training.preparation import prepare
from hybrid.training.scoring import nrmse, r2
from hybrid.training.trainers import trainer_for

PUBLISHED = {0.0: 0.0264, 0.5: 0.0454, 1.0: 0.1334}  # NRMSE of the paper's own weights on all 200 test motions
AIMS = {0.0: 0.0143, 0.5: 0.0160, 1.0: 0.0240}
ORACLE_SUBSTEPS = 8  # the true equations, integrated until nothing changes
MOTIONS = 1000  # of the paper
NOISE = 0.03  # of the paper's data, relative


def own_modal_model(rng: np.random.Generator) -> ModalModel:
    """Return a modal model as wrong as the paper's: frequencies and shapes with 3 % noise, damping of 1 %."""
    true = natural_modes(linearise(four_dof()), 4)
    factors = 1 + 0.03 * rng.standard_normal((5, 4))
    shapes = true.shapes.copy()
    shapes[true.dofs.free] *= factors[:4]
    return ModalModel(true.omega * factors[4], np.full(4, 0.01), shapes, true.dofs)


def clean_test_motions(cubic_stiffness: float, realisations: int = MOTIONS) -> FloatArray:
    """Return the test motions (realisation, time, 12) of `paper_dataset` without noise."""
    start = np.random.RandomState(0).randn(8, realisations)[:, round(0.8 * realisations) :]
    config = FreeConfig(duration=50.0, sampling_rate=10.0)
    motion = simulate_free(four_dof(cubic_stiffness), start[:4].T, start[4:].T, config, (), progress=False)
    return np.concatenate([motion.displacement, motion.velocity, motion.acceleration], axis=2)


def oracle(dataset: Dataset, cubic_stiffness: float) -> NeuralModalODE:
    """Return a model with the true equations, the true noise and the true prior z0 ~ N(0, I)."""
    truth = four_dof(cubic_stiffness)
    modal = natural_modes(linearise(truth), 4)
    config = replace(places_preset().model, substeps=ORACLE_SUBSTEPS)
    scale, count = StateScale.unit(4), len(dataset.sensors)
    laws = force_laws(truth)
    model = NeuralModalODE(config, modal, laws, dataset.sensors, torch.ones(count), scale, 1 / dataset.sampling_rate)
    model.dynamics.residual = NoResidual(4)
    # The residual has no law: C of the chain is not diagonal in the modes, and enters as it is.
    damping = modal.shapes[modal.dofs.free].T @ linearise(truth).damping.toarray() @ modal.shapes[modal.dofs.free]
    shapes = torch.tensor(modal.shapes[modal.dofs.free], dtype=torch.float32)
    metric = shapes.T @ shapes
    model.dynamics.physical[:, 4:] = torch.tensor(-damping, dtype=torch.float32)
    size = np.array([recording.data.std() for recording in dataset.select("train")]).mean()
    noise = torch.full((len(model.measured),), NOISE * size)
    model.encoder = StatePrior(torch.block_diag(metric, metric), noise)
    return model


@dataclass(frozen=True)
class ChainScore:
    """Scores of one k_n, all over all test motions and channels; seconds of one process, scoring left out."""

    cubic_stiffness: float
    error: FloatArray  # (motion, channel), from ten samples
    fit: FloatArray  # R2, likewise
    fe_error: FloatArray
    oracle_error: FloatArray
    whole_error: FloatArray
    floor: FloatArray
    band: float
    whole_band: float
    seconds_past_paper: float
    seconds_to_aim: float
    seconds: float


def score_chain(
    cubic_stiffness: float,
    modal: ModalModel,
    config: Config,
    advance: Callable[[], object] = nothing,
    realisations: int = MOTIONS,
) -> ChainScore:
    """Train on four fifths of the motions, test on the others; ``advance`` is called after each epoch.

    1000 ``realisations`` are the paper's own data, of which 800 are for training.
    """
    dataset = paper_dataset(cubic_stiffness, modal, realisations=realisations, progress=False)
    windows = dataset.select("test")[0].data
    truth = clean_test_motions(cubic_stiffness, realisations)
    started = time.perf_counter()
    prepared = prepare(dataset, config)
    trainer = trainer_for(prepared.model, prepared.windows, config.training)
    trained, spent = dict[float, float](), time.perf_counter() - started
    for seconds, error in _errors_while_training(trainer.epochs(), prepared.model, windows, spent):
        trained[seconds] = error
        advance()
    model = prepared.model
    set_relative_error(model, prepared.windows)
    found = compare(model, dataset, windows.shape[1], 1)
    if found is None or found.whole_record is None:
        raise TypeError("the paper's data have test motions, and places solve for states")
    best = forecast_windows(oracle(dataset, cubic_stiffness), windows).channels
    return ChainScore(
        cubic_stiffness=cubic_stiffness,
        error=nrmse(found.hybrid.forecast.channels, windows),
        fit=r2(found.hybrid.forecast.channels, windows),
        fe_error=nrmse(found.fe.channels, windows),
        oracle_error=nrmse(best, windows),
        whole_error=nrmse(found.whole_record.forecast.channels, windows),
        floor=nrmse(truth, windows),
        band=_covered(found.hybrid, truth),
        whole_band=_covered(found.whole_record, truth),
        seconds_past_paper=_first_below(trained, PUBLISHED[cubic_stiffness]),
        seconds_to_aim=_first_below(trained, AIMS[cubic_stiffness]),
        seconds=max(trained),
    )


def rows(score: ChainScore) -> list[Row]:
    """Return the score as lines of the benchmark."""
    k = score.cubic_stiffness
    section, paper = f"chain, k_n = {k:g}", "paper's weights"
    mean, floor = float(score.error.mean()), float(score.floor.mean())
    best, whole = float(score.oracle_error.mean()), float(score.whole_error.mean())
    return [
        Row(section, "NRMSE from 10 samples", mean, paper, PUBLISHED[k], measured_peer=False, aim=f"{AIMS[k]:.4f}"),
        Row(section, "", mean, "true equations", best),
        Row(section, "", mean, "FE model, same start", float(score.fe_error.mean())),
        Row(section, "R2 about the mean", float(score.fit.mean())),
        Row(section, "worst motion's NRMSE", float(score.error.mean(axis=1).max())),
        Row(section, "NRMSE given whole records", whole, "noise floor", floor, aim=f"{1.15 * floor:.4f}"),
        Row(section, "worst motion's", float(score.whole_error.mean(axis=1).max())),
        Row(section, "truth inside the 90 % band", score.band, aim="0.87 to 0.93"),
        Row(section, "the same given whole records", score.whole_band, aim="0.87 to 0.93"),
        Row(section, "seconds until past the paper's weights", score.seconds_past_paper, "paper", 36e3, False, "120"),
        Row(section, "seconds until at the aim", score.seconds_to_aim, aim="600"),
        Row(section, "seconds of the whole training", score.seconds),
    ]


def _errors_while_training(
    epochs: Iterator[object], model: NeuralModalODE, windows: FloatArray, spent: float
) -> Iterator[tuple[float, float]]:
    """Give the seconds of training and the test's mean NRMSE after each epoch; the scoring's own time is left out."""
    started = time.perf_counter()
    for _ in epochs:
        spent += time.perf_counter() - started
        error = nrmse(forecast_windows(model, windows).channels, windows)
        yield spent, float(np.nan_to_num(error, nan=np.inf).mean())
        started = time.perf_counter()


def _first_below(trained: dict[float, float], limit: float) -> float:
    return min((seconds for seconds, error in trained.items() if error < limit), default=np.inf)


def _covered(banded: BandedForecast, truth: FloatArray) -> float:
    return float(coverage(truth - banded.forecast.channels, banded.std).mean())
