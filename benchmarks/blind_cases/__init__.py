"""Blind cases: an effect hidden in simulated recordings, drawn from a seed; the truth is kept apart.

The recordings come from a simulation finer than the diagnosis' own and, where asked for, of a structure that is off by
what its user considers normal everywhere at once, or far from its drawing. Outside of the list of causes are `OUTSIDE`:
a stiffness that drifts during each recording or swings to and fro, and a spring that creeps.
"""

from benchmarks.blind_cases.bridge import bridge_case
from benchmarks.blind_cases.case import Acts, BlindCase, BlindConfig, Noisy, Tier, check_config
from benchmarks.blind_cases.chain import SENSORS, chain_case
from benchmarks.blind_cases.kinds import BRIDGE_KINDS, FAR_KINDS, KINDS, OUTSIDE, Excitation, StructureName
from benchmarks.blind_cases.saving import save_case

__all__ = [
    "BRIDGE_KINDS",
    "FAR_KINDS",
    "KINDS",
    "OUTSIDE",
    "SENSORS",
    "Acts",
    "BlindCase",
    "BlindConfig",
    "Excitation",
    "Noisy",
    "StructureName",
    "Tier",
    "blind_case",
    "save_case",
]


def blind_case(seed: int, config: BlindConfig | None = None) -> BlindCase:
    """Return the case of a seed: everything random in it comes from there."""
    config = config or BlindConfig()
    check_config(config)
    return bridge_case(seed, config) if config.structure == "bridge" else chain_case(seed, config)
