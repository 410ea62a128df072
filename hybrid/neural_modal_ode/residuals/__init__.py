"""All that can be learned of the dynamics: nothing, a free map, one with backbone curves, or forces at places."""

from hybrid.neural_modal_ode.residuals.at_connectors import ConnectorResidual
from hybrid.neural_modal_ode.residuals.backbone import BackboneResidual
from hybrid.neural_modal_ode.residuals.free import FreeResidual, NoResidual

Residual = NoResidual | FreeResidual | BackboneResidual | ConnectorResidual
