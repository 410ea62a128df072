"""What stands in an encoder's place where the initial state is solved for: what is known of it before any sample."""

import torch
from torch import Tensor, nn


class StatePrior(nn.Module):
    """What is known before: z0 ~ N(0, P) with ``precision`` P^-1 (2 mode, 2 mode), and the sensors' noise.

    ``noise_std`` (measured,): standard deviation of each measured channel, in its unit.
    """

    def __init__(self, precision: Tensor, noise_std: Tensor) -> None:
        super().__init__()
        self.precision: Tensor
        self.noise_std: Tensor
        self.register_buffer("precision", precision.to(torch.get_default_dtype()))
        self.register_buffer("noise_std", noise_std.to(torch.get_default_dtype()))
