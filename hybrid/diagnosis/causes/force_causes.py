"""Causes that are forces of their own at a place: force laws that are not linear in the motion, harmonic forces."""

from collections.abc import Callable
from functools import partial
from typing import Literal

import numpy as np

from fe_models.causes import Cause, CoulombFriction, CubicSpring, GapStop, HarmonicForce, QuadraticDamper, SlackCable
from hybrid.diagnosis.causes.candidate import SMALL, Candidate
from hybrid.diagnosis.causes.places import UNMOVED, Motion, Place
from hybrid.diagnosis.nominal.plant import Plant

CREEP = (0.005, 0.01, 0.1)  # of the rms rate at its place: below it friction is a dashpot; at least (less would need
# steps finer than a search can afford), usual, at most
REACHES = (0.1, 0.25, 0.45, 0.65, 0.85)  # of the largest elongation: where a search for a gap starts
FARTHEST = 0.999  # quantile of an elongation that counts as its largest
HARDLY = 0.8  # of the pretension with which a cable never goes slack
LEAST = 1e-3  # of the rms elongation: what a gap, or the largest elongation of one side, is at least
SIDES: tuple[Literal[1, -1], ...] = (1, -1)
RUBBING = 0.3  # of a usual dashpot's force: the usual friction


def force_laws_of(plant: Plant, places: list[Place], motion: Motion) -> list[Candidate]:
    """Return every force law at every place that moves, as large as the ``motion`` there would feel."""
    sizes = [float(np.std(motion.displacement @ place.pull)) for place in places]
    least = UNMOVED * max(sizes, default=0.0)
    moving = [place for place, size in zip(places, sizes, strict=True) if size > least]
    return [law for place in moving for law in _laws_at(place, motion)] + _slack_cables(plant, motion, least)


def _laws_at(place: Place, motion: Motion) -> list[Candidate]:
    u, v = motion.displacement @ place.pull, motion.velocity @ place.pull
    size, rate = float(np.std(u)), float(np.std(v))
    at = place.nodes, place.direction
    hardening = place.stiffness / (3 * size**2)
    cubic = _law(place, ("stiffness",), partial(CubicSpring, *at), (hardening,), (-np.inf,))
    drag = _law(place, ("coefficient",), partial(QuadraticDamper, *at), (place.coefficient / rate,), (0.0,))
    rubbing, (least, usual, most) = RUBBING * place.coefficient * rate, (share * rate for share in CREEP)
    dry = _law(
        place,
        ("force", "regularisation"),
        partial(CoulombFriction, *at),
        width=(rubbing, usual),
        lower=(0.0, least),
        upper=(np.inf, most),
        neutral=(0.0, usual),
        starts=((SMALL * rubbing, usual),),
    )
    stops = []
    for side in SIDES:
        farthest = max(float(np.quantile(side * u, FARTHEST)), LEAST * size)
        stops.append(
            _law(
                place,
                ("stiffness", "gap"),
                _stop(place, side),
                width=(place.stiffness, size),
                lower=(0.0, LEAST * size),
                starts=tuple((SMALL * place.stiffness, reach * farthest) for reach in REACHES),
                side=side,
            )
        )
    return [cubic, drag, dry, *stops]


def _stop(place: Place, side: Literal[1, -1]) -> Callable[..., Cause]:
    return lambda stiffness, gap: GapStop(place.nodes, place.direction, gap, stiffness, side)


def _law(
    place: Place,
    names: tuple[str, ...],
    build: Callable[..., Cause],
    width: tuple[float, ...],
    lower: tuple[float, ...],
    upper: tuple[float, ...] = (),
    neutral: tuple[float, ...] = (),
    starts: tuple[tuple[float, ...], ...] = (),
    **more: int,
) -> Candidate:
    """Return a law at a place; ``more``: what tells apart two of a kind there."""
    return Candidate(
        kind=build(*width).kind,
        location=place.location | more,
        names=names,
        build=build,
        neutral=neutral or (0.0,) * len(names),
        width=width,
        lower=lower,
        upper=upper,
        starts=starts,
        pull=place.pull,
        twins=tuple(twin | more for twin in place.twins),
    )


def _slack_cables(plant: Plant, motion: Motion, least: float) -> list[Candidate]:
    """Return every cable that may go slack whose rms elongation is more than the ``least``."""
    found = []
    for number in range(1, len(plant.structure.elements) + 1):
        effect = SlackCable(number, 1.0)
        law = None if effect.faults(plant.structure) else effect.law(plant.built)
        if law is not None:
            pull = plant.pull(law)
            u = motion.displacement @ pull
            if np.std(u) <= least:
                continue
            most = max(float(np.quantile(-u, FARTHEST)), LEAST * float(np.std(u))) * law.stiffness
            taut = 2.0 * most  # never slack
            found.append(
                Candidate(
                    kind=SlackCable.kind,
                    location={"element": number},
                    names=("pretension",),
                    build=partial(SlackCable, number),
                    neutral=(taut,),
                    width=(most,),
                    lower=(LEAST * most,),
                    starts=tuple((reach * most,) for reach in REACHES),
                    scalable=False,
                    hardly=(HARDLY * taut,),
                    pull=pull,
                )
            )
    return found


def harmonic_forces(places: list[Place], slowest: float, fastest: float) -> list[Candidate]:
    """Return a harmonic force at every place against the ground; amplitude and phase are each recording's own.

    ``slowest``: the lowest frequency (Hz); below one cycle in a recording it would be any constant force or drift.
    ``fastest``: the highest that recordings show.
    """
    return [
        Candidate(
            kind=HarmonicForce.kind,
            location=place.location,
            names=("frequency",),
            build=partial(HarmonicForce, place.nodes[0], place.direction, 1.0),
            neutral=(0.0,),
            width=(fastest,),
            lower=(slowest,),
            pull=place.pull,
            oscillator=True,
            twins=place.twins,
        )
        for place in places
        if len(place.nodes) == 1
    ]
