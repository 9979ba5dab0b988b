"""Source code of notebook functions as a module, with everything that they refer to."""

from __future__ import annotations

import dis
import inspect
import textwrap
import types
from collections.abc import Callable
from typing import Any


def source_of(function: Callable[..., Any]) -> str:
    """Source of a module with the function and with all notebook functions, classes, imports and plain values that it
    uses.

    Raises ValueError for anything else that it uses; define such a function in a file.
    """
    module = _Module()
    module.gather(function.__name__, function)
    parts = ["from __future__ import annotations", *module.imports.values(), *module.values.values(), ""]
    return "\n".join(parts) + "\n" + "\n\n\n".join(module.definitions.values()) + "\n"


class _Module:
    """Statements of a module, by the names that they define."""

    def __init__(self) -> None:
        self.imports: dict[str, str] = {}
        self.values: dict[str, str] = {}
        self.definitions: dict[str, str] = {}

    def gather(self, name: str, value: Any) -> None:
        if any(name in part for part in (self.imports, self.values, self.definitions)):
            return
        module = getattr(value, "__module__", None)
        if isinstance(value, types.ModuleType):
            self.imports[name] = f"import {value.__name__} as {name}"
        elif isinstance(value, types.FunctionType | type) and module == "__main__":
            self._define(name, value)
        elif isinstance(module, str) and module != "__main__" and hasattr(value, "__qualname__"):
            self.imports[name] = f"from {module} import {value.__qualname__} as {name}"
        elif _is_plain(value):
            self.values[name] = f"{name} = {value!r}"
        else:
            raise ValueError(f"`{name}`, a {type(value).__name__}, cannot be written down; put the planner into a file")

    def _define(self, name: str, value: Any) -> None:
        try:
            text = textwrap.dedent(inspect.getsource(value))
        except (OSError, TypeError) as reason:
            raise ValueError(f"the source of `{name}` is not known ({reason}); put it into a file") from reason
        lines = text.splitlines()
        # Decorators are omitted, so that the worker, which finds the function by name, registers nothing.
        begin = next(index for index, line in enumerate(lines) if line.startswith(("def ", "class ")))
        self.definitions[name] = "\n".join(lines[begin:])
        functions = [value] if isinstance(value, types.FunctionType) else [
            member for member in vars(value).values() if isinstance(member, types.FunctionType)
        ]
        for function in functions:
            for used in _names_of(function.__code__):
                if used in function.__globals__:
                    self.gather(used, function.__globals__[used])


def _names_of(code: types.CodeType) -> list[str]:
    """Module-level names that code reads, including those of nested functions; attributes do not count."""
    names = [step.argval for step in dis.get_instructions(code) if step.opname in ("LOAD_GLOBAL", "LOAD_NAME")]
    for constant in code.co_consts:
        if isinstance(constant, types.CodeType):
            names.extend(_names_of(constant))
    return names


def _is_plain(value: Any) -> bool:
    if isinstance(value, list | tuple | set):
        return all(_is_plain(item) for item in value)
    if isinstance(value, dict):
        return all(_is_plain(key) and _is_plain(item) for key, item in value.items())
    return value is None or isinstance(value, bool | int | float | str | bytes)
