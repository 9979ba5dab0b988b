"""The package as a whole: help texts, types, content of the wheel."""

from __future__ import annotations

import doctest
import importlib
import inspect
import os
import pkgutil
import re
import subprocess
import sys
from importlib.metadata import files, version
from pathlib import Path

import cranny
import pytest
from conftest import HERE, REPOSITORY, package
from cranny import _cranny

MODULES = ["cranny", *(f"cranny.{module.name}" for module in pkgutil.iter_modules(cranny.__path__))]


def public_names() -> list[tuple[str, object]]:
    """All public names, including members of classes."""
    names: list[tuple[str, object]] = []
    for module_name in MODULES:
        module = importlib.import_module(module_name)
        names.append((module_name, module))
        for name, value in vars(module).items():
            if name.startswith("_") or getattr(value, "__module__", module_name) not in (module_name, "cranny", None):
                continue
            if inspect.isclass(value) or inspect.isroutine(value):
                names.append((f"{module_name}.{name}", value))
            if inspect.isclass(value):
                own = vars(value).items()
                fields = getattr(value, "__dataclass_fields__", {})
                names += [
                    (f"{module_name}.{name}.{member}", entry)
                    for member, entry in own
                    if not member.startswith("_") and member not in fields
                ]
    return names


def test_every_public_name_has_help_text() -> None:
    names = public_names()
    assert len(names) > 150
    bare = [name for name, value in names if len(inspect.getdoc(value) or "") < 5]
    assert not bare, f"without help text: {bare}"
    assert "(N, 4, 4)" in (inspect.getdoc(cranny.Robot.fk) or ""), "help says shapes"


@pytest.mark.parametrize("name", [name for name in MODULES if name != "cranny.worker"])
def test_examples_in_help_texts_run(name: str) -> None:
    result = doctest.testmod(importlib.import_module(name))
    assert result.failed == 0


def mypy(*words: str) -> None:
    """Runs mypy or stubtest with the project's configuration."""
    package("mypy")
    environment = {**os.environ, "MYPYPATH": str(HERE)}
    told = subprocess.run(
        [sys.executable, "-m", *words], capture_output=True, text=True, cwd=REPOSITORY, env=environment
    )
    assert told.returncode == 0, told.stdout + told.stderr


def test_examples_and_the_package_have_strict_types() -> None:
    configuration = str(REPOSITORY / "python/pyproject.toml")
    package("pandas"), package("matplotlib")
    examples = [str(path) for path in sorted((REPOSITORY / "examples").glob("*.py"))]
    mypy("mypy", "--strict", "--config-file", configuration, *examples)
    mypy("mypy", "--strict", "--config-file", configuration, "-p", "cranny")


def test_the_code_in_the_readme_has_strict_types(tmp_path: Path) -> None:
    """Users begin with the code of the README, which their editors check."""
    package("pandas"), package("matplotlib")
    blocks = re.findall(r"^```python\n(.*?)^```$", (REPOSITORY / "README.md").read_text(encoding="utf-8"), re.M | re.S)
    assert blocks and "import cranny" in blocks[0]
    for index, block in enumerate(blocks):
        (tmp_path / f"readme_{index}.py").write_text(block, encoding="utf-8")
    configuration = str(REPOSITORY / "python/pyproject.toml")
    mypy("mypy", "--strict", "--config-file", configuration, *(str(path) for path in sorted(tmp_path.glob("*.py"))))


def test_the_stubs_are_what_the_module_has() -> None:
    mypy("mypy.stubtest", "cranny._cranny", "--mypy-config-file", str(REPOSITORY / "python/pyproject.toml"))


def test_the_installed_package_is_whole() -> None:
    installed = [Path(str(file.locate())) for file in files("cranny") or []]
    assert any(path.name.startswith("_cranny") for path in installed)
    assert {"py.typed", "_cranny.pyi"} <= {path.name for path in installed}
    assert version("cranny") == cranny.__version__ == _cranny.__version__


def test_the_import_brings_nothing_that_is_slow_to_load() -> None:
    slow = ("numpy", "pandas", "matplotlib", "trimesh", "IPython")
    told = subprocess.run(
        [sys.executable, "-c", f"import sys, cranny; print([m for m in {slow} if m in sys.modules])"],
        capture_output=True,
        text=True,
        check=True,
    )
    assert told.stdout.strip() == "[]"
