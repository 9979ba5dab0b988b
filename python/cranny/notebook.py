"""What a notebook shows of a scenario and a plan."""

from __future__ import annotations

import base64
import html
import os
from pathlib import Path

from cranny._cranny import Plan, Scenario, moving_picture, page, picture

NOTEBOOK_RATE_HZ = 4
"""Pictures a second in a notebook: each takes some tenths of a second to draw."""


class View:
    """A scenario as a notebook shows it, with a plan where there is one: what `scenario.show(plan)` gives.

    A notebook calls `_repr_html_` and shows what it returns; a plan moves.
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
        """A still picture: the end of the plan with the way to it, or the scenario at its start."""
        return picture(self._scenario, self._plan, view=self._view, width=self._width, height=self._height)

    def apng(self, rate: int = 10) -> bytes:
        """The motion as an animated PNG, `rate` pictures a second, which browsers show like a picture."""
        if self._plan is None:
            raise ValueError("there is no plan to move along")
        return moving_picture(
            self._scenario, self._plan, view=self._view, width=self._width, height=self._height, rate=rate
        )

    def save(self, path: str | os.PathLike[str]) -> None:
        """Writes a picture: `.png`, or `.apng` for the motion; or the viewer as one file, `.html`."""
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
        """What stands in the notebook: the viewer in a frame of its own, or a picture where the package was
        built without the viewer."""
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
