"""The one small network used throughout: a multilayer perceptron with two hidden layers."""

from torch import nn


def mlp(inputs: int, hidden: int, outputs: int) -> nn.Sequential:
    """Return inputs -> hidden -> hidden -> outputs with tanh between, as in Lai et al. 2022."""
    return nn.Sequential(
        nn.Linear(inputs, hidden), nn.Tanh(), nn.Linear(hidden, hidden), nn.Tanh(), nn.Linear(hidden, outputs)
    )


def start_at_zero(network: nn.Sequential) -> None:
    """Set the last layer of ``network`` to zero, so that training starts from what surrounds it."""
    for parameter in network[-1].parameters():
        nn.init.zeros_(parameter)
