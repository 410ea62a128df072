"""All that can be learned of the dynamics: nothing, a free map, one with backbone curves, or forces at places."""

from hybrid.backbone_residual import BackboneResidual
from hybrid.connector_residual import ConnectorResidual
from hybrid.residual import FreeResidual, NoResidual

Residual = NoResidual | FreeResidual | BackboneResidual | ConnectorResidual
