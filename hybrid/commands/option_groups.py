"""Options that belong together: a dataclass describes them once, for every command that takes them."""

from collections.abc import Callable
from dataclasses import fields, is_dataclass
from functools import wraps
from inspect import Parameter, signature
from typing import Any, get_type_hints


def with_option_groups(command: Callable[..., None]) -> Callable[..., None]:
    """Return a command that has an option for each field of its parameters that are dataclasses.

    The fields are annotated as options of Typer are, and have defaults.
    """
    groups: dict[str, Any] = {}
    parameters = []
    for name, parameter in signature(command).parameters.items():
        group = parameter.annotation
        if not is_dataclass(group):
            parameters.append(parameter)
            continue
        groups[name], hints = group, get_type_hints(group, include_extras=True)
        parameters += [
            Parameter(item.name, parameter.kind, default=item.default, annotation=hints[item.name])
            for item in fields(group)
        ]

    @wraps(command)
    def with_groups(**given: Any) -> None:
        grouped = {
            name: group(**{item.name: given.pop(item.name) for item in fields(group)}) for name, group in groups.items()
        }
        command(**given, **grouped)

    with_groups.__signature__ = signature(command).replace(parameters=parameters)  # type: ignore[attr-defined]
    with_groups.__annotations__ = {parameter.name: parameter.annotation for parameter in parameters}
    return with_groups


def options_in_words(given: object) -> list[str]:
    """Return the options of a group that are given, as on a command line."""
    options = {name: value for name, value in vars(given).items() if value is not None}
    return [word for name, value in options.items() for word in (f"--{name.replace('_', '-')}", str(value))]
