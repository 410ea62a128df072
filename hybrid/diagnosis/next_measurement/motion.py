"""How channels move by a hypothesis near its best fit: to first order in its parameters and in initial states.

y = y_0 + J (theta - theta_0) + B (z - z_0)
"""

from dataclasses import dataclass, replace

import numpy as np

from fe_models.arrays import FloatArray
from hybrid.diagnosis.fitting.config import LINEARISATION
from hybrid.diagnosis.fitting.least_squares import Fit
from hybrid.diagnosis.nominal.loads import Loads
from hybrid.diagnosis.recorded.sensor_outputs import SensorOutputs
from hybrid.diagnosis.response.hypothesis import Hypothesis
from hybrid.diagnosis.response.marching import respond
from hybrid.diagnosis.response.state_space import system_of
from hybrid.diagnosis.response.system import System, observability


@dataclass(frozen=True, eq=False)
class Motion:
    """What channels show every ``stride`` samples: ``mean`` (recording, time, sensor), and its slopes ``by_theta``
    (parameter, recording, time, sensor) and ``by_state`` (recording, time, sensor, state).
    """

    mean: FloatArray
    by_theta: FloatArray
    by_state: FloatArray
    stride: int

    @property
    def is_finite(self) -> bool:
        """Whether it stays within bounds."""
        return all(np.isfinite(part).all() for part in (self.mean, self.by_theta, self.by_state))


@dataclass(frozen=True, eq=False)
class NearFit:
    """A ``hypothesis`` as it acts in some recordings, at its best ``theta`` (parameter,): the ``kept`` ones of its
    fit's.
    """

    hypothesis: Hypothesis
    theta: FloatArray
    kept: list[int]

    @staticmethod
    def of(item: Fit, off: tuple[int, ...]) -> "NearFit":
        """Return a fit without the candidates that are ``off``."""
        kept = item.hypothesis.parameters_of(off)
        return NearFit(item.hypothesis.less(off), item.theta[kept], kept)

    @property
    def steps(self) -> FloatArray:
        """Steps of finite differences (parameter,)."""
        return LINEARISATION.difference_step * self.hypothesis.width

    def varied(self, outputs: SensorOutputs) -> System:
        """Return the system, and behind it one for each parameter, a step further there."""
        thetas = np.vstack([self.theta, self.theta + np.diag(self.steps)])
        return system_of(self.hypothesis, thetas, outputs, first_order=True)

    def motion(
        self, outputs: SensorOutputs, starts: FloatArray, samples: int, stride: int, loads: Loads | None = None
    ) -> Motion:
        """Return the motion from ``starts`` (variant or 1, recording, state)."""
        varied = self.varied(outputs)
        starts = np.broadcast_to(starts, (len(varied.A), *starts.shape[1:]))
        y = _shown(varied, starts, samples, stride, loads)
        by_theta = (y[1:] - y[0]) / self.steps[:, None, None, None]
        return Motion(y[0], by_theta, self._by_state(varied, outputs, starts[0], samples, stride, loads), stride)

    def _by_state(
        self,
        varied: System,
        outputs: SensorOutputs,
        starts: FloatArray,
        samples: int,
        stride: int,
        loads: Loads | None,
    ) -> FloatArray:
        """Return the slopes by each entry of ``starts`` (recording, state), as of `Motion`."""
        recordings, states = starts.shape
        if varied.is_linear:
            coarse = _every(varied.only(0), stride)
            found = observability(coarse, -(-samples // stride))[0]  # (time, sensor, state), alike for all
            return np.broadcast_to(found, (recordings, *found.shape))
        size = LINEARISATION.difference_step * np.maximum(
            np.sqrt(np.mean(starts**2, axis=0)), LINEARISATION.least_state
        )
        moved = np.repeat(starts[None], 1 + states, axis=0)
        moved[1:] += np.diag(size)[:, None]
        first = system_of(self.hypothesis, self.theta[None], outputs)
        y = _shown(first, moved.reshape(1, -1, states), samples, stride, loads)
        y = y.reshape(1 + states, recordings, *y.shape[2:])
        return np.asarray(((y[1:] - y[0]) / size[:, None, None, None]).transpose(1, 2, 3, 0))


def _every(system: System, stride: int) -> System:
    """Return a linear system seen every ``stride`` samples."""
    return replace(system, step=stride * system.step)


def _shown(system: System, starts: FloatArray, samples: int, stride: int, loads: Loads | None) -> FloatArray:
    """Return the channels (variant, recording, time, sensor) every ``stride`` samples."""
    if system.is_linear and loads is None:
        return respond(_every(system, stride), starts, -(-samples // stride))
    return respond(system, starts, samples, loads, oversampling=1)[:, :, ::stride]
