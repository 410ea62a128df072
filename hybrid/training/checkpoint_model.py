"""The model of a checkpoint, built anew and given its weights once these are known to fit, and its trainer's state."""

from typing import Any

import torch
from torch import Tensor

from fe_models.causes.laws import force_laws
from fe_models.errors import InputError, raise_faults
from hybrid.config import ModelConfig
from hybrid.estimation.experts import Experts, Hybrid
from hybrid.estimation.start_evidence import StartEvidence
from hybrid.neural_modal_ode.model import NeuralModalODE
from hybrid.neural_modal_ode.scaling import StateScale
from hybrid.neural_modal_ode.state_prior import StatePrior
from hybrid.training.origin import Origin

Weights = dict[str, Tensor]


def rebuilt(config: ModelConfig, origin: Origin, weights: Weights) -> Hybrid:
    """Return the model that has these ``weights``, its `state_dict`; `InputError` with all that does not fit."""
    model: Hybrid
    if config.experts:
        counts = _required(weights, "counts", None, torch.int64)
        if len(counts) > len(weights) or bool((counts < 1).any()):
            raise InputError(f"counts: {len(counts)} members, expected windows of each")
        width = config.encoder_samples * sum(sensor.role == "measured" for sensor in origin.sensors)
        members, evidence = list[NeuralModalODE](), list[StartEvidence]()
        for i in range(len(counts)):
            members.append(_blank(config, origin, _under(f"_members.{i}.", weights)))
            evidence.append(StartEvidence(_required(weights, f"_evidence.{i}.root", (width, width))))
        model = Experts(members, evidence, counts.tolist())
    else:
        model = _blank(config, origin, weights)
    expected: Weights = model.state_dict()
    faults = [f"{name}: is missing" for name in expected.keys() - weights.keys()]
    faults += [f"{name}: is unknown" for name in weights.keys() - expected.keys()]
    for name in expected.keys() & weights.keys():
        found, wanted = (f"{each.dtype} of shape {tuple(each.shape)}" for each in (weights[name], expected[name]))
        faults += [] if found == wanted else [f"{name}: is {found}, expected {wanted}"]
    raise_faults(sorted(faults))
    model.load_state_dict(weights)
    return model


def state_faults(model: Hybrid, state: dict[str, Any]) -> list[str]:
    """Return what is wrong with the ``state`` of the trainer of ``model``."""
    if not isinstance(model, Experts):
        return _member_faults(model, state, "trainer")
    members = state.get("members")
    if state.keys() != {"members"} or not isinstance(members, list) or len(members) != len(model.members):
        return [f"trainer: expected members, the states of {len(model.members)}"]
    pairs = enumerate(zip(model.members, members, strict=True), start=1)
    return [fault for n, (member, each) in pairs for fault in _member_faults(member, each, f"trainer.members[{n}]")]


def _member_faults(model: NeuralModalODE, state: Any, where: str) -> list[str]:
    kind = _search_faults if isinstance(model.encoder, StatePrior) else _optimiser_faults
    return (
        [f"{where}: {fault}" for fault in kind(model, state)] if isinstance(state, dict) else [f"{where}: is no table"]
    )


def _search_faults(model: NeuralModalODE, state: dict[str, Any]) -> list[str]:
    """Return the faults of the state of a `GaussNewtonTrainer`."""
    kinds = {"states": Tensor | None, "horizon": int, "damping": float, "converged": bool}
    faults = _part_faults(state, kinds)
    if faults:
        return faults
    states, modes = state["states"], model.dynamics.modes
    if states is not None and (states.ndim != 2 or states.shape[1] != 2 * modes or not _are_numbers(states)):
        faults.append(f"states: expected finite numbers of shape (window, {2 * modes})")
    if state["horizon"] < 1 or not 0 < state["damping"] < float("inf"):
        faults.append("horizon, damping: expected positive numbers")
    return faults


def _optimiser_faults(model: NeuralModalODE, state: dict[str, Any]) -> list[str]:
    """Return the faults of the state of Adam, whose settings are those of a new one but for the learning rate."""
    faults = _part_faults(state, {"state": dict, "param_groups": list})
    if faults:
        return faults
    new = torch.optim.Adam(model.parameters(), lr=1.0).state_dict()["param_groups"]
    groups = [{**group, "lr": 1.0} if _has_rate(group) else None for group in state["param_groups"]]
    if not _are_plain(state["param_groups"]) or groups != new:
        faults.append("param_groups: are not those of the model's weights")
    parameters = dict(enumerate(model.parameters()))
    if state["state"].keys() not in (set(), parameters.keys()):
        return [*faults, "state: is not of all weights"]
    for number, each in state["state"].items():
        shapes = {"step": (), "exp_avg": parameters[number].shape, "exp_avg_sq": parameters[number].shape}
        if not isinstance(each, dict) or each.keys() != shapes.keys():
            faults.append(f"state[{number}]: expected {', '.join(shapes)}")
            continue
        wrong = [name for name, shape in shapes.items() if not _are_numbers(each[name]) or each[name].shape != shape]
        faults += [f"state[{number}].{name}: expected finite numbers of shape {tuple(shapes[name])}" for name in wrong]
    return faults


def _part_faults(state: dict[str, Any], kinds: dict[str, Any]) -> list[str]:
    if state.keys() != kinds.keys():
        return [f"expected {', '.join(kinds)}"]
    return [
        f"{name}: is a {type(state[name]).__name__}"
        for name, kind in kinds.items()
        if not isinstance(state[name], kind)
    ]


def _has_rate(group: Any) -> bool:
    return isinstance(group, dict) and isinstance(group.get("lr"), float) and 0 <= group["lr"] < float("inf")


def _are_plain(groups: list[Any]) -> bool:
    """Return whether no tensor stands where a comparison would not be true or false."""
    return all(isinstance(group, dict) and not any(isinstance(v, Tensor) for v in group.values()) for group in groups)


def _are_numbers(value: Any) -> bool:
    return type(value) is Tensor and value.is_floating_point() and bool(torch.isfinite(value).all())


def _under(prefix: str, weights: Weights) -> Weights:
    return {name.removeprefix(prefix): value for name, value in weights.items() if name.startswith(prefix)}


def _required(weights: Weights, name: str, shape: tuple[int, ...] | None, dtype: torch.dtype | None = None) -> Tensor:
    """Return one of the weights, which a model cannot be built without; ``shape`` None: one dimension of any length."""
    value = weights.get(name)
    if value is None:
        raise InputError(f"{name}: is missing")
    fits = value.ndim == 1 and len(value) > 0 if shape is None else value.shape == shape
    if not fits or (value.dtype != dtype if dtype else not value.is_floating_point()):
        raise InputError(f"{name}: is {value.dtype} of shape {tuple(value.shape)}, expected {shape or 'one dimension'}")
    return value


def _blank(config: ModelConfig, origin: Origin, weights: Weights) -> NeuralModalODE:
    """Return a model with the scales of ``weights``, the rest of which are yet to be loaded."""
    effects = force_laws(origin.structure) if origin.structure else ()
    modes = (len(origin.modal.omega),)
    sizes = [_required(weights, f"dynamics.{part}", modes).double().numpy() for part in ("a", "b")]
    channel_scale = _required(weights, "channel_scale", (len(origin.sensors),))
    if any((size <= 0).any() for size in sizes) or bool((channel_scale < 0).any()):
        raise InputError("channel_scale, dynamics.a, dynamics.b: expected positive numbers")
    return NeuralModalODE(
        config,
        origin.modal,
        effects,
        origin.sensors,
        channel_scale,
        StateScale(*sizes),
        1 / origin.sampling_rate,
        origin.connectors,
    )
