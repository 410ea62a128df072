"""The chain with a cubic spring under known random loads: forecasts by the trained model beside the true equations'."""

import time
from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import Literal

import numpy as np
from scipy.signal import butter, sosfiltfilt

from benchmarks.chain import NOISE, oracle
from benchmarks.row import Row
from fe_models.arrays import FloatArray
from fe_models.built_in.four_dof import four_dof
from fe_models.drive import drive_of
from fe_models.linear import ModalModel
from fe_models.progress import nothing
from fe_models.recordings import Assumptions, Dataset, Load, Recording
from fe_models.simulated_recordings import sensor_at
from fe_models.simulation import simulate_driven
from hybrid.config import Config
from hybrid.estimation.uncertainty import coverage, set_relative_error
from hybrid.training.forecast_comparison import Comparison, compare
from hybrid.training.preparation import prepare
from hybrid.training.scoring import nrmse
from hybrid.training.trainers import trainer_for

RATE, BEGIN, SAMPLES = 10.0, 100, 501  # Hz; samples from rest that are left out, so that motions begin moving; kept
CUTOFF = 0.4  # Hz: the chain's modes lie between 0.04 and 0.34 Hz
SIZE = 0.5  # N, rms of each load: mass 1 then moves by 0.9 m rms, and its spring is four times as stiff at the ends
LOADED = (1, 3)
MEASURED = ("x4", "a1", "a3", "a4")
MAX_RATIO = 1.1  # of the true equations' error: what was to be reached
MOTIONS = 80  # four fifths of them for training


@dataclass(frozen=True)
class LoadedScore:
    """Mean NRMSE over all test motions and channels: from ten samples, and given whole records."""

    cubic_stiffness: float
    error: float
    fe_error: float
    oracle_error: float
    whole_error: float
    oracle_whole_error: float
    band: float
    seconds: float


def loaded_dataset(
    cubic_stiffness: float, modal: ModalModel, motions: int, advance: Callable[[], object] = nothing
) -> tuple[Dataset, FloatArray]:
    """Return motions under two random loads, simulated in Exudyn, and those for testing without noise."""
    truth, rng = four_dof(cubic_stiffness), np.random.default_rng(0)
    sensors = tuple(
        sensor_at(name, truth) if name in MEASURED else replace(sensor_at(name, truth), role="held_out")
        for name in (f"{letter}{node}" for letter in "xva" for node in range(1, 5))
    )
    low = butter(3, CUTOFF, fs=RATE, output="sos")
    recordings, trained = list[Recording](), round(0.8 * motions)
    for number in range(motions):
        values = sosfiltfilt(low, rng.standard_normal((BEGIN + SAMPLES, len(LOADED))), axis=0)
        values *= SIZE / values.std(axis=0)
        loads = tuple(Load(node, "x", course) for node, course in zip(LOADED, values.T, strict=True))
        response = simulate_driven(truth, drive_of(truth, loads, RATE), progress=False)
        data = np.column_stack([response.shown(sensor) for sensor in sensors])[None]
        role: Literal["train", "test"] = "train" if number < trained else "test"
        recordings.append(Recording(f"motion {number}", data, role, loads).part(BEGIN))
        advance()
    clean = np.concatenate([recording.data for recording in recordings])
    noisy = clean + NOISE * clean.std() * rng.standard_normal(clean.shape)
    kept = tuple(replace(each, data=data[None]) for each, data in zip(recordings, noisy, strict=True))
    return Dataset(four_dof(), RATE, sensors, kept, assumptions=Assumptions(modal_model=modal)), clean[trained:]


def score_loaded_chain(
    cubic_stiffness: float,
    modal: ModalModel,
    config: Config,
    motions: int = MOTIONS,
    advance: Callable[[], object] = nothing,
) -> LoadedScore:
    """Train on four fifths of the motions, test on the others; ``advance`` is called for each motion and epoch."""
    dataset, clean = loaded_dataset(cubic_stiffness, modal, motions, advance)
    started = time.perf_counter()
    prepared = prepare(dataset, config)
    trainer = trainer_for(prepared.model, prepared.windows, config.training, driving=prepared.driving)
    for _ in trainer.epochs():
        advance()
    seconds = time.perf_counter() - started
    set_relative_error(prepared.model, prepared.windows, prepared.driving)
    found = compare(prepared.model, dataset, SAMPLES, 1)
    best = compare(oracle(dataset, cubic_stiffness), dataset, SAMPLES, 1)
    if found is None or best is None:
        raise TypeError("a fifth of the motions are for testing")
    inside = coverage(clean - found.hybrid.forecast.channels, found.hybrid.std)
    return LoadedScore(
        cubic_stiffness=cubic_stiffness,
        error=_mean(found.windows, found.hybrid.forecast.channels),
        fe_error=_mean(found.windows, found.fe.channels),
        oracle_error=_mean(best.windows, best.hybrid.forecast.channels),
        whole_error=_whole(found),
        oracle_whole_error=_whole(best),
        band=float(inside.mean()),
        seconds=seconds,
    )


def rows(score: LoadedScore) -> list[Row]:
    """Return the score as lines of the benchmark."""
    section, aim = f"chain under loads, k_n = {score.cubic_stiffness:g}", f"{MAX_RATIO * score.oracle_error:.4f}"
    return [
        Row(section, "NRMSE from 10 samples", score.error, "true equations", score.oracle_error, aim=aim),
        Row(section, "", score.error, "FE model, same start", score.fe_error),
        Row(section, "NRMSE given whole records", score.whole_error, "true equations", score.oracle_whole_error),
        Row(section, "truth inside the 90 % band", score.band, aim="0.87 to 0.93"),
        Row(section, "seconds of the whole training", score.seconds),
    ]


def _mean(windows: FloatArray, channels: FloatArray) -> float:
    return float(nrmse(channels, windows).mean())


def _whole(found: Comparison) -> float:
    if found.whole_record is None:
        raise TypeError("places solve for states")
    return _mean(found.windows, found.whole_record.forecast.channels)
