"""The encoders: what they see, in which order, and how they scale."""

from collections.abc import Iterator

import numpy as np
import pytest
import torch
from torch import Tensor

from hybrid.neural_modal_ode.config import ENCODER
from hybrid.neural_modal_ode.encoder import PaperEncoder, WindowEncoder
from tests.hybrid_problems import double_precision

CHANNELS, MODES, SAMPLES = 3, 2, 10


@pytest.fixture(autouse=True)
def _double() -> Iterator[None]:
    with double_precision():
        torch.manual_seed(0)
        yield


def samples(batch: int = 5) -> Tensor:
    return torch.randn(batch, SAMPLES, CHANNELS)


def test_the_paper_reads_q0_from_the_first_sample_only() -> None:
    """Its MLP gives mean and log-variance of q0; all other samples change those of q0' alone."""
    encoder, x = PaperEncoder(CHANNELS, MODES, 8, 6), samples()
    later = x.clone()
    later[:, 1:] += 1.0
    for before, after in zip(encoder(x), encoder(later), strict=True):
        assert before.shape == (5, 2 * MODES)
        assert torch.equal(before[:, :MODES], after[:, :MODES])
        assert not torch.isclose(before[:, MODES:], after[:, MODES:]).any()


def test_the_paper_reads_q0_dot_by_an_elman_network_newest_first() -> None:
    """By hand: h <- tanh(W x_k + U h + c) for k = n_t .. 0, then a linear layer; 1e-14 is rounding."""
    encoder, x = PaperEncoder(CHANNELS, MODES, 8, 6), samples()
    weights = {name: value.detach().numpy() for name, value in encoder.recurrent.named_parameters()}
    h = np.zeros((5, 6))
    for k in reversed(range(SAMPLES)):
        inputs = x[:, k].numpy() @ weights["weight_ih_l0"].T + weights["bias_ih_l0"]
        h = np.tanh(inputs + h @ weights["weight_hh_l0"].T + weights["bias_hh_l0"])
    out = h @ encoder.velocity.weight.detach().numpy().T + encoder.velocity.bias.detach().numpy()
    mean, log_variance = (part.detach().numpy()[:, MODES:] for part in encoder(x))
    np.testing.assert_allclose(np.hstack([mean, log_variance]), out, rtol=0, atol=1e-14)


def test_a_vibration_of_twice_the_size_starts_from_twice_the_state() -> None:
    """The window encoder is linear, and so is its standard deviation, down to a thousandth of a channel's size."""
    encoder, x = WindowEncoder(CHANNELS, MODES, SAMPLES), samples()
    mean, log_variance = encoder(x)
    for factor in (2.0, -3.0):
        scaled_mean, scaled_log_variance = encoder(factor * x)
        assert torch.allclose(scaled_mean, factor * mean)
        growth = torch.exp(0.5 * (scaled_log_variance - log_variance))
        assert torch.allclose(growth, torch.full_like(growth, abs(factor)), rtol=1e-5)  # 1e-6 is the least size
    together, _ = encoder(x[:2] + x[2:4])
    assert torch.allclose(together, mean[:2] + mean[2:4])


def test_the_first_draws_are_within_five_percent() -> None:
    encoder = WindowEncoder(CHANNELS, MODES, SAMPLES)
    _, log_variance = encoder(torch.ones(1, SAMPLES, CHANNELS))  # rms one
    assert torch.allclose(log_variance, torch.full((1, 2 * MODES), ENCODER.initial_log_variance), atol=1e-5)
    assert log_variance[0, 0].mul(0.5).exp().item() == pytest.approx(0.05, abs=0.001)


def test_silence_gives_finite_numbers() -> None:
    for encoder in (WindowEncoder(CHANNELS, MODES, SAMPLES), PaperEncoder(CHANNELS, MODES, 8, 6)):
        for part in encoder(torch.zeros(2, SAMPLES, CHANNELS)):
            assert bool(torch.isfinite(part).all())
