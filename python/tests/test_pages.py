"""The Python code of README and docs runs unchanged: the blocks of each page in order, in their own folder."""

import re
import subprocess
import sys
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[2]
PAGES = [ROOT / "README.md", ROOT / "python" / "README.md", *sorted((ROOT / "docs").glob("*.md"))]


def script(page: Path) -> str:
    """All Python blocks of a page as one program, except those that a comment excludes."""
    blocks = re.findall(r"^(<!-- not run: [^\n]*\n)?```python\n(.*?)^```", page.read_text(encoding="utf-8"), re.M | re.S)
    return "\n".join(block for left_out, block in blocks if not left_out)


def test_some_pages_have_python() -> None:
    assert sum(bool(script(page)) for page in PAGES) >= 3


@pytest.mark.parametrize("page", [page for page in PAGES if script(page)], ids=lambda page: page.stem)
def test_the_python_of_a_page_runs(page: Path, tmp_path: Path) -> None:
    program = tmp_path / "page.py"
    program.write_text(script(page), encoding="utf-8")
    run = subprocess.run([sys.executable, program], cwd=tmp_path, capture_output=True, text=True, timeout=300)
    assert run.returncode == 0, run.stderr
