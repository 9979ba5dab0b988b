"""Display of scenarios and plans in notebooks."""

from __future__ import annotations

import atexit
import base64
import html
import os
import tempfile
import webbrowser
from pathlib import Path
from typing import Literal, overload

from cranny._cranny import LivePage, Plan, Scenario, moving_picture, page, picture

NOTEBOOK_RATE_HZ = 4
"""Pictures per second in a notebook; each takes some tenths of a second to draw."""


class View:
    """View of a scenario in a notebook, with a plan if there is one; returned by `scenario.show(plan)`.

    A notebook displays the result of `_repr_html_`, in which a plan moves.
    """

    def __init__(
        self,
        scenario: Scenario,
        plan: Plan | None = None,
        *,
        view: str = "three-quarter",
        width: int = 640,
        height: int = 480,
    ) -> None:
        self._scenario, self._plan = scenario, plan
        self._view, self._width, self._height = view, width, height

    def png(self) -> bytes:
        """PNG of the end of the plan with the path to it, or of the scenario at its start."""
        return picture(self._scenario, self._plan, view=self._view, width=self._width, height=self._height)

    def apng(self, rate: int = 10) -> bytes:
        """Animated PNG of the motion with `rate` pictures per second, which browsers display like a picture."""
        if self._plan is None:
            raise ValueError("there is no plan to move along")
        return moving_picture(
            self._scenario, self._plan, view=self._view, width=self._width, height=self._height, rate=rate
        )

    def save(self, path: str | os.PathLike[str]) -> None:
        """Writes a picture (`.png`), a moving picture (`.apng`), or the viewer as one file (`.html`)."""
        path = Path(path)
        if path.suffix == ".html":
            viewer = page(self._scenario, self._plan)
            if viewer is None:
                raise RuntimeError("this package was built without the viewer: build it where Node 20 is")
            path.write_text(viewer, encoding="utf-8")
        elif path.suffix in (".png", ".apng"):
            path.write_bytes(self.apng() if path.suffix == ".apng" else self.png())
        else:
            raise ValueError(f"{path}: views are .png, .apng or .html")

    def html(self) -> str:
        """HTML for the notebook: the viewer in its own frame, or a picture if the package was built without the
        viewer."""
        viewer = page(self._scenario, self._plan)
        if viewer is not None:
            return (
                f'<iframe width="{self._width}" height="{self._height}" style="border: 0" '
                f'sandbox="allow-scripts" srcdoc="{html.escape(viewer)}"></iframe>'
            )
        moves = self._plan is not None and bool(self._plan)
        data = base64.b64encode(self.apng(NOTEBOOK_RATE_HZ) if moves else self.png()).decode("ascii")
        return f'<img width="{self._width}" height="{self._height}" src="data:image/png;base64,{data}">'

    def _repr_html_(self) -> str:
        return self.html()

    def _repr_png_(self) -> bytes:
        return self.png()


@overload
def show(scenario: Scenario, plan: Plan | None = None, *, live: Literal[False] = False) -> View: ...
@overload
def show(scenario: Scenario, plan: Plan | None = None, *, live: Literal[True], open_browser: bool = True) -> LivePage: ...
def show(
    scenario: Scenario, plan: Plan | None = None, *, live: bool = False, open_browser: bool = True
) -> View | LivePage:
    """Shows a scenario, with its plan if given: returns a View, which a notebook displays.

    With `live`, opens the viewer in the browser and returns its page. `page.pose(q)` and `page.plan(plan)` update it
    from a running script, `cranny.plan(scenario, watch=page)` shows the growth of a search, and `page.close()` or the end
    of a `with` block closes it. With `open_browser=False` nothing opens; the address is `page.url`.

    >>> import cranny
    >>> scenario = cranny.Scenario("021")
    >>> with cranny.show(scenario, live=True, open_browser=False) as page:
    ...     for q in cranny.plan(scenario).path:
    ...         page.pose(q)
    """
    if not live:
        return View(scenario, plan)
    served = LivePage(scenario, plan)
    if open_browser:
        _open(served.url)
    return served


def _open(url: str) -> None:
    """Opens the address by a private file: other users of the machine can read a browser's command line."""
    number, name = tempfile.mkstemp(prefix="cranny-", suffix=".html")
    with os.fdopen(number, "w", encoding="utf-8") as file:
        file.write(f'<!doctype html><meta name="referrer" content="no-referrer">'
                   f'<meta http-equiv="refresh" content="0; url={url}"><a href="{url}">Cranny</a>')
    atexit.register(lambda: Path(name).unlink(missing_ok=True))
    webbrowser.open(Path(name).as_uri())
