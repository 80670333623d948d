"""What every model is: made from its arguments, and nothing else. So it can be copied, sent to another process and compared."""

from __future__ import annotations

import copy
import inspect
from collections.abc import Mapping
from functools import cache
from typing import Any, ClassVar, Self

import numpy as np

labelled: dict[tuple[str, str], type[Model]] = {}  # by module and name, so that a class that is made again replaces itself


class Model:
    """A value made by a class from arguments, which the class keeps as they were given.

    It pickles and copies as these: the other process calls the class again, so that no compiled function travels. Two are equal
    if they are of one class and were made of equal arguments, as they have them now under the arguments' names: GGX(0.3) is
    GGX(0.3, 0.3). Arrays are equal if shapes and all numbers are. A subclass has all this without a line of its own; what is
    put on a model afterwards is not part of it.
    """

    _given: tuple[tuple[Any, ...], dict[str, Any]]
    __signature__: ClassVar[inspect.Signature]
    label: ClassVar[str]  # the name of a family in tables, and `cite` its source; see `families`
    cite: ClassVar[str] = ""

    def __init_subclass__(cls) -> None:
        """A class with a label of its own is a family; help shows the constructor's arguments, which `__new__` would hide."""
        super().__init_subclass__()
        made: Any = cls
        cls.__signature__ = signature(made)
        if "label" in vars(cls):
            labelled[cls.__module__, cls.__qualname__] = cls

    def __new__(cls, *args: Any, **kwargs: Any) -> Self:
        made = super().__new__(cls)
        object.__setattr__(made, "_given", _own((args, kwargs)))
        return made

    def __init__(self) -> None:
        """Without arguments, unless a class says which."""

    def __reduce__(self) -> tuple[Any, ...]:
        return _made, (type(self), *self._given)

    def __eq__(self, other: object) -> bool:
        return _identity(self) == _identity(other) if type(self) is type(other) else NotImplemented

    def __hash__(self) -> int:
        return hash(_identity(self))


def _made(cls: type[Model], args: tuple[Any, ...], kwargs: dict[str, Any]) -> Model:
    return cls(*args, **kwargs)


def _own(given: Any) -> Any:
    """The arguments, and arrays and lists among them as copies: who called may change theirs."""
    if isinstance(given, np.ndarray | list | set | bytearray):
        return copy.deepcopy(given)
    if isinstance(given, dict):
        return {name: _own(value) for name, value in given.items()}
    return tuple(map(_own, given)) if type(given) is tuple else given


@cache
def signature(cls: Any) -> inspect.Signature:
    """Of its constructor, without self."""
    whole = inspect.signature(cls.__init__)
    return whole.replace(parameters=list(whole.parameters.values())[1:])


def arguments(model: Model) -> inspect.BoundArguments:
    """The arguments of its class by name, as the model has them now or else as they were given."""
    args, kwargs = model._given
    cls: Any = type(model)
    bound = signature(cls).bind(*args, **kwargs)
    bound.apply_defaults()
    for name, value in bound.arguments.items():
        bound.arguments[name] = vars(model).get(name, value)
    return bound


def _identity(model: Model) -> tuple[Any, ...]:
    return type(model), tuple((name, _comparable(value)) for name, value in arguments(model).arguments.items())


def _comparable(value: Any) -> Any:
    """Something that is equal for equal values, and has a hash if they consist of numbers, text, arrays and models."""
    if isinstance(value, np.ndarray):
        return value.shape, tuple(value.ravel().tolist())
    if isinstance(value, Mapping):
        return frozenset((name, _comparable(one)) for name, one in value.items())
    return tuple(map(_comparable, value)) if isinstance(value, list | tuple) else value
