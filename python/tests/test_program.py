"""The program in the wheel, as `cranny` and as `python -m cranny`."""

from __future__ import annotations

import signal
import subprocess
import sys
from pathlib import Path

import cranny
import pytest
from conftest import lacking
from cranny import __main__ as command


@pytest.fixture(scope="module")
def program() -> Path:
    """The program of the installed wheel."""
    try:
        return command.program()
    except SystemExit:
        lacking("the package was installed without its program")
        raise


def answer(*words: str | Path, folder: Path | None = None) -> subprocess.CompletedProcess[str]:
    """Runs a command to its end."""
    return subprocess.run(words, capture_output=True, text=True, cwd=folder, check=False)


def test_the_program_has_the_version_of_the_package(program: Path) -> None:
    by_name, by_module = answer(program, "--version"), answer(sys.executable, "-m", "cranny", "--version")
    assert by_name.stdout == by_module.stdout
    assert cranny.__version__ in by_name.stdout


def test_exit_codes_and_messages_are_those_of_the_program(program: Path, tmp_path: Path) -> None:
    words = ["plan", "021", "--planner", "nobody"]
    by_name = answer(program, *words, folder=tmp_path)
    by_module = answer(sys.executable, "-m", "cranny", *words, folder=tmp_path)
    assert by_name.returncode == by_module.returncode == 2
    assert by_name.stderr == by_module.stderr


@pytest.mark.skipif(sys.platform == "win32", reason="Ctrl-C has no signal to send here")
def test_ctrl_c_ends_it_with_the_exit_code_of_the_program(program: Path) -> None:
    words = [sys.executable, "-m", "cranny", "view", "021", "--no-open"]
    with subprocess.Popen(words, stdout=subprocess.PIPE, text=True) as viewer:
        assert viewer.stdout is not None and "http://" in viewer.stdout.readline()
        viewer.send_signal(signal.SIGINT)
        assert viewer.wait(timeout=30) == 0


def test_without_the_program_one_message_states_where_it_comes_from(
    monkeypatch: pytest.MonkeyPatch, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.setattr(command, "files", lambda name: None)
    monkeypatch.setattr(command, "__file__", str(tmp_path / "cranny" / "__main__.py"))
    with pytest.raises(SystemExit) as ended:
        command.program()
    assert ended.value.code == 2
    assert "cargo install" in capsys.readouterr().err
