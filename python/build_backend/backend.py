"""Build backend of the package: that of maturin, which also packs the program `cranny` into the wheel.

maturin builds either a module or a program (https://github.com/PyO3/maturin/issues/368). Beside the module it packs the
folder `DATA`, though, and an installer puts the files of its folder `scripts` where commands belong.
"""

from __future__ import annotations

import json
import shutil
import subprocess
from pathlib import Path
from typing import Any

import maturin
from maturin import (
    build_editable,
    get_requires_for_build_editable,
    get_requires_for_build_wheel,
    prepare_metadata_for_build_editable,
    prepare_metadata_for_build_wheel,
)

__all__ = [
    "build_editable",
    "build_wheel",
    "get_requires_for_build_editable",
    "get_requires_for_build_wheel",
    "prepare_metadata_for_build_editable",
    "prepare_metadata_for_build_wheel",
]

DATA = Path("cranny._cranny.data")
"""Folder that maturin packs. It exists during a build alone, so that no later build packs an old program."""


def build_wheel(
    wheel_directory: str, config_settings: dict[str, Any] | None = None, metadata_directory: str | None = None
) -> str:
    """Builds the wheel and returns its name (PEP 517)."""
    scripts = DATA / "scripts"
    shutil.rmtree(DATA, ignore_errors=True)
    scripts.mkdir(parents=True)
    try:
        shutil.copy2(built_program(), scripts)
        name: str = maturin.build_wheel(wheel_directory, config_settings, metadata_directory)
        return name
    finally:
        shutil.rmtree(DATA, ignore_errors=True)


def built_program() -> Path:
    """Builds the program and returns its path."""
    if shutil.which("cargo") is None:
        raise SystemExit("cranny is built by Rust, and there is no `cargo`: install it from https://rustup.rs")
    command = ["cargo", "build", "--release", "--package", "cranny-cli", "--bin", "cranny"]
    # The folder of the program depends on the environment and on the configuration of cargo.
    messages = subprocess.run(
        [*command, "--message-format", "json-render-diagnostics"], stdout=subprocess.PIPE, text=True, check=False
    )
    if messages.returncode != 0:
        raise SystemExit(f"`{' '.join(command)}` failed")
    programs = [message.get("executable") for message in map(json.loads, messages.stdout.splitlines())]
    return Path(next(path for path in programs if path))
