"""All that can be learned of the dynamics: nothing, a free map, one with backbone curves, or forces at places."""

from hybrid.neural_modal_ode.residuals.backbone_residual import BackboneResidual
from hybrid.neural_modal_ode.residuals.connector_residual import ConnectorResidual
from hybrid.neural_modal_ode.residuals.free_residual import FreeResidual, NoResidual

Residual = NoResidual | FreeResidual | BackboneResidual | ConnectorResidual
