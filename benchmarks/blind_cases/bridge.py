"""Blind cases of the cable-stayed bridge: of its free decay after a weight on the deck is cut loose, or under wind and
traffic.
"""

from dataclasses import replace

import numpy as np

from benchmarks.blind_cases.ambient import UnknownForces
from benchmarks.blind_cases.bridge_draw import SPAN, TOWERS, draw_cause, draw_outside
from benchmarks.blind_cases.bridge_scene import Scene, free_motion
from benchmarks.blind_cases.bridge_truth import (
    OUTPUT_RATE,
    SCATTER,
    SCATTER_OFF,
    Start,
    Truth,
    ambient_at,
    modal_state,
    motion_at,
    off_by_uncertainty,
    scattered,
)
from benchmarks.blind_cases.case import CAMPAIGNS, BlindCase, BlindConfig, as_recorded, sensors_of
from benchmarks.blind_cases.drawing import amount_between, causes_apart
from benchmarks.blind_cases.far import far_from
from fe_models.arrays import BoolArray, FloatArray
from fe_models.assembly import linearise
from fe_models.built_in.bridge import bridge
from fe_models.causes import Effect
from fe_models.errors import InputError
from fe_models.files.bridge_recordings import LOWPASS, bridge_sensors
from fe_models.measurement import lowpassed
from fe_models.modes import natural_modes
from fe_models.recordings import Sensor, Uncertainty
from fe_models.structure import Direction, Structure

SENSORS = bridge_sensors("A2", "m/s^2")
WEIGHTS = (1.0, 3.0)  # N: 3 N at mid-span are 2 mm
LIVELINESS = 0.5  # m kg^0.5 / s^2, rms: acceleration of each mode on top of what the weights bring
MOVING_MODES = 10  # modes below the low-pass
DELAY_SAMPLES = 5  # samples before and after each recording that a late or early sensor may show
FORCES = (0.01, 0.1)  # N, rms at each node: traffic on the deck, wind on the towers
CORNERS = (3.0, 15.0)  # Hz: up to where these forces are white
MARGIN_TIME = 0.3  # s before and after each recording, which the ends of the low-pass filter spoil


def bridge_case(seed: int, config: BlindConfig) -> BlindCase:
    """Return the case of a seed: everything random in it comes from there."""
    campaign = config.campaign
    if OUTPUT_RATE % campaign.sampling_rate:
        raise InputError(f"sampling_rate = {campaign.sampling_rate:g} Hz; expected a divisor of {OUTPUT_RATE:g} Hz")
    rng = np.random.default_rng(seed)
    design = bridge()
    sensors = sensors_of(SENSORS, config, rng)
    far = far_from(design.without_prestress(), rng) if config.tier == "far" else None
    starts, scene = _calm(far.structure if far else design.without_prestress(), config, sensors, rng)
    unknown = _unknown_forces(config, rng)
    causes = causes_apart(config.hidden, lambda kind: draw_cause(kind, scene, rng, config.size))
    more = tuple(draw_outside(kind, scene, rng, config.size, campaign.duration) for kind in config.outside)
    lasting, effects = (
        tuple(cause for cause in some if isinstance(cause, Effect)) for some in (config.lasting(causes), causes)
    )
    built, ratios = scene.design, far.ratios if far else np.ones(len(scene.modal.omega))
    if config.tier == "off":
        built = off_by_uncertainty(built, rng)
        ratios = 1 + Uncertainty().damping * rng.standard_normal(len(ratios))
    if config.rich:
        built = scattered(built, SCATTER if config.tier == "exact" else SCATTER_OFF, rng)

    def recorded(which: BoolArray, acts: bool) -> FloatArray:
        truth = Truth(built.with_effects(*(effects if acts else lasting)), ratios, config.rich, config.step)
        if unknown:
            forces = [own for own, taken in zip(unknown, which, strict=True) if taken]
            parts = [ambient_at(truth, own, sensors, campaign.duration, MARGIN_TIME) for own in forces]
            shown = np.concatenate(parts)
        else:
            moved = tuple(start for start, taken in zip(starts, which, strict=True) if taken)
            shown = motion_at(truth, moved, sensors, campaign.duration, MARGIN_TIME, more if acts else (), LOWPASS)
        every = round(OUTPUT_RATE / campaign.sampling_rate)
        first = round(MARGIN_TIME * OUTPUT_RATE) - DELAY_SAMPLES * every
        filtered = np.stack([lowpassed(part, OUTPUT_RATE, LOWPASS) for part in shown])
        return filtered[:, first::every][:, : campaign.samples + 2 * DELAY_SAMPLES]

    affected = config.affected
    clean = recorded(affected, acts=True)
    if not affected.all():
        begin, without = int(affected.argmax()), recorded(~affected, acts=False)
        clean = np.concatenate([without[:begin], clean, without[begin:]])  # it acts in one recording, or to the end
    case = as_recorded(design, sensors, clean, tuple(causes), config, rng, LOWPASS, DELAY_SAMPLES)
    return replace(case, factors=far.factors if far else ())


def _unknown_forces(config: BlindConfig, rng: np.random.Generator) -> tuple[UnknownForces, ...]:
    """Return the wind and traffic of each recording; none where the bridge moves freely."""
    if config.excitation == "free":
        return ()
    found = []
    for _ in range(config.campaign.count):
        deck, towers = (amount_between(*FORCES, rng, None) for _ in range(2))
        places: list[tuple[int, Direction]] = [(node, "y") for node in SPAN]
        places += [(node, "x") for node in TOWERS]
        sizes = np.repeat([deck, towers], [len(SPAN), len(TOWERS)])
        found.append(UnknownForces(tuple(places), sizes, float(rng.uniform(*CORNERS)), int(rng.integers(2**32))))
    return tuple(found)


def _calm(
    design: Structure, config: BlindConfig, sensors: tuple[Sensor, ...], rng: np.random.Generator
) -> tuple[tuple[Start, ...], Scene]:
    """Return how each recording begins, and the bridge moving so without what is to be hidden.

    Under unknown forces, too, it is a free decay that gives scales.
    """
    campaign = config.campaign if config.excitation == "free" else CAMPAIGNS["bridge"]
    model = linearise(design)
    modal = natural_modes(model, model.mass.shape[0])
    starts = []
    for _ in range(campaign.count):
        nodes = rng.choice(SPAN, size=int(rng.integers(1, 3)), replace=False)
        weights = tuple((int(node), float(rng.uniform(*WEIGHTS))) for node in nodes)
        starts.append(Start(weights, LIVELINESS / modal.omega[:MOVING_MODES] * rng.standard_normal(MOVING_MODES)))
    states = [modal_state(modal, start, LOWPASS) for start in starts]
    q, p = (np.stack(part, axis=-1)[:MOVING_MODES] for part in zip(*states, strict=True))
    time = np.arange(campaign.samples) / campaign.sampling_rate
    return tuple(starts), Scene(design, model, modal, free_motion(modal, q, p, time), sensors)
