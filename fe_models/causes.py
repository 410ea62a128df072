"""All kinds of causes that a diagnosis may name, by the word of each: effects, sensor faults, the simulation itself."""

from fe_models.effects import EFFECTS, Cause
from fe_models.sensor_effects import SensorDelay, SensorDrift, SensorEffect, SensorGain
from fe_models.time_integration import TimeIntegration
from fe_models.wrong_modal_model import WrongModalModel

SENSOR_EFFECTS: dict[str, type[SensorEffect]] = {cause.kind: cause for cause in (SensorGain, SensorDelay, SensorDrift)}
SIMULATION_FAULTS: dict[str, type[Cause]] = {cause.kind: cause for cause in (TimeIntegration, WrongModalModel)}
CAUSES: dict[str, type[Cause]] = {**EFFECTS, **SENSOR_EFFECTS, **SIMULATION_FAULTS}
