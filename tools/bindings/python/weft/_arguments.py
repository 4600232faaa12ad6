"""Arguments of simple kinds, checked by the annotations of functions, so that what is wrong is said by name. Arrays, meshes
and options are checked where they are read."""

import functools
import os
from operator import index
from typing import Any, Callable, Mapping, TypeVar

from ._errors import UsageError

_Function = TypeVar("_Function", bound=Callable[..., Any])


def _number(value: Any) -> float:
    if isinstance(value, (str, bytes)):
        raise TypeError
    return float(value)


def _whole(value: Any) -> int:
    number = index(value)
    if not -2**31 <= number < 2**31:
        raise OverflowError
    return number


def _yes_or_no(value: Any) -> bool:
    if not isinstance(value, (bool, int)) and type(value).__name__ != "bool_" or value not in (0, 1):
        raise TypeError
    return bool(value)


def _text(value: Any) -> str:
    if not isinstance(value, str):
        raise TypeError
    value.encode()  # fails where halves of UTF-16's pairs stand alone
    return value


def _path(value: Any) -> bytes:
    path = os.fsencode(value)
    if b"\0" in path:
        raise ValueError
    return path


def _point(value: Any) -> list:
    x, y, z = value
    return [_number(x), _number(y), _number(z)]


def _several(value: Any, kind: Callable[[Any], Any]) -> list:
    if isinstance(value, (str, bytes)):
        raise TypeError
    return [kind(one) for one in value]


def _fields(value: Any) -> dict:
    if not isinstance(value, Mapping):
        raise TypeError
    return dict(value)


def _function(value: Any) -> Any:
    if not callable(value):
        raise TypeError
    return value


#: Annotation -> what values of its kind are called, and a function that makes one or raises.
_KINDS = {
    "float": ("a number", _number),
    "int": ("a whole number of 32 bits", _whole),
    "bool": ("True or False", _yes_or_no),
    "str": ("a text", _text),
    "_Path": ("a path", _path),
    "_Point": ("three numbers", _point),
    "_Fields": ("a dictionary from names to arrays", _fields),
    "Progress": ("a function", _function),
    "Callable[[Mesh], _Fields]": ("a function", _function),
    "Sequence[_Path]": ("a list of paths", lambda value: _several(value, _path)),
    "Sequence[float]": ("a list of numbers", lambda value: _several(value, _number)),
    "Sequence[str]": ("a list of texts", lambda value: _several(value, _text)),
}


def of_kind(name: str, value: Any, annotation: str) -> Any:
    """The argument as a value of the kind that its annotation names."""
    if annotation.startswith("Optional["):
        if value is None:
            return None
        annotation = annotation[len("Optional["):-1]
    if annotation not in _KINDS:
        return value
    text, make = _KINDS[annotation]
    try:
        return make(value)
    except (TypeError, ValueError, OverflowError):
        raise UsageError(f"{name}: is a {type(value).__name__}, not {text}") from None


def checked(function: _Function) -> _Function:
    """The function with its arguments as values of their kinds. Not for what the ranks of a communicator call: one that
    raises alone leaves the others waiting."""
    code, kinds = function.__code__, function.__annotations__
    names = code.co_varnames[:code.co_argcount + code.co_kwonlyargcount]

    @functools.wraps(function)
    def call(*values: Any, **named: Any) -> Any:
        made = [of_kind(name, value, kinds.get(name, "")) for name, value in zip(names, values)]
        named = {name: of_kind(name, value, kinds.get(name, "") if name in names else "") for name, value in named.items()}
        return function(*made, *values[len(made):], **named)

    return call
