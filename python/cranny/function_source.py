"""Source code of notebook functions as a module, with everything that they refer to."""

from __future__ import annotations

import ast
import dis
import inspect
import textwrap
import types
from collections.abc import Callable
from typing import Any


def source_of(function: Callable[..., Any]) -> str:
    """Source of a module with the function and with all notebook functions, imports and plain values that it uses.

    Raises ValueError for anything else that it uses, such as a class of the notebook, whose source Python does not keep.
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
        elif isinstance(value, types.FunctionType) and module == "__main__":
            self._define(name, value)
        elif isinstance(value, type) and module == "__main__":
            raise ValueError(
                f"the source of class `{name}` is not known outside of a file; put the class and the planner into a file, "
                "and import the planner from there"
            )
        elif isinstance(module, str) and module != "__main__" and hasattr(value, "__qualname__"):
            self.imports[name] = f"from {module} import {value.__qualname__} as {name}"
        else:
            try:
                self.values[name] = f"{name} = {_written(value)}"
            except TypeError as reason:
                raise ValueError(f"`{name}`, a {reason}, cannot be written down; put the planner into a file") from None

    def _define(self, name: str, function: types.FunctionType) -> None:
        try:
            text = textwrap.dedent(inspect.getsource(function))
            definition = ast.parse(text).body[0]
        except (OSError, TypeError, SyntaxError) as reason:
            raise ValueError(f"the source of `{name}` is not known ({reason}); put the planner into a file") from reason
        if not isinstance(definition, ast.FunctionDef):
            raise ValueError(f"`{name}` is not defined by `def`; define it so, or put the planner into a file")
        # Defaults are computed at the definition, so what they use comes before it.
        defaults = [*definition.args.defaults, *filter(None, definition.args.kw_defaults)]
        nodes = (node for default in defaults for node in ast.walk(default))
        self._gather_all([node.id for node in nodes if isinstance(node, ast.Name)], function)
        # Decorators are omitted, so that the worker, which finds the function by name, registers nothing.
        self.definitions[name] = "\n".join(text.splitlines()[definition.lineno - 1 :])
        self._gather_all(_names_of(function.__code__), function)

    def _gather_all(self, names: list[str], function: types.FunctionType) -> None:
        for name in names:
            if name in function.__globals__:
                self.gather(name, function.__globals__[name])


def _names_of(code: types.CodeType) -> list[str]:
    """Module-level names that code reads, including those of nested functions; attributes do not count."""
    names = [step.argval for step in dis.get_instructions(code) if step.opname in ("LOAD_GLOBAL", "LOAD_NAME")]
    for constant in code.co_consts:
        if isinstance(constant, types.CodeType):
            names.extend(_names_of(constant))
    return names


def _written(value: Any) -> str:
    """Expression of a plain value. Raises TypeError with the type of any other."""
    if isinstance(value, float):
        # The names inf and nan are not defined; 1e999 is infinite.
        return repr(float(value)).replace("inf", "1e999").replace("nan", "(1e999 - 1e999)")
    kind = type(value)
    if kind in (list, tuple):
        return f"{kind.__name__}([{', '.join(map(_written, value))}])"
    if kind in (set, frozenset):
        # Sorted, since the order of a set differs from process to process, and the source identifies the planner.
        return f"{kind.__name__}([{', '.join(sorted(map(_written, value)))}])"
    if kind is dict:
        return "{" + ", ".join(f"{_written(key)}: {_written(item)}" for key, item in value.items()) + "}"
    if kind in (type(None), bool, int, str, bytes):
        return repr(value)
    raise TypeError(kind.__name__)
