"""All kinds of causes that a diagnosis may name, by the word of each: effects, sensor faults, the simulation's step."""

from fe_models.effects import EFFECTS, Cause
from fe_models.sensor_effects import SensorDelay, SensorDrift, SensorEffect, SensorGain
from fe_models.time_integration import TimeIntegration

SENSOR_EFFECTS: dict[str, type[SensorEffect]] = {cause.kind: cause for cause in (SensorGain, SensorDelay, SensorDrift)}
CAUSES: dict[str, type[Cause]] = {**EFFECTS, **SENSOR_EFFECTS, TimeIntegration.kind: TimeIntegration}
