"""Several picks and places in order: what `cranny plan --steps` does."""

from __future__ import annotations

import os
from collections.abc import Sequence
from typing import Any, overload

from cranny._cranny import Plan, Scenario, Verification, _judged_steps, _load_steps, _save_steps, plan


class StepsPlan(Sequence[Plan]):
    """The plans of a scenario's steps, each in the world that the one before leaves: all, or up to the first that found
    none. True if all of them hold. `scenario.show(steps)` and `cranny.show` show them as one motion.

    `StepsPlan(scenario, plans)` judges each plan anew, as one of that step of that scenario, wherever it was made, and
    refuses one that does not put down what the step picks.
    """

    def __init__(self, scenario: Scenario, plans: Sequence[Plan]) -> None:
        self._scenario = scenario
        self._plans = _judged_steps(scenario, list(plans))

    @classmethod
    def _judged(cls, scenario: Scenario, plans: Sequence[Plan]) -> StepsPlan:
        """Plans that were made or judged as those of the steps."""
        steps = cls.__new__(cls)
        steps._scenario, steps._plans = scenario, list(plans)
        return steps

    @property
    def scenario(self) -> Scenario:
        """The scenario whose steps these are plans of."""
        return self._scenario

    @property
    def plans(self) -> list[Plan]:
        """The plans, in the order of the steps."""
        return list(self._plans)

    @staticmethod
    def load(path: str | os.PathLike[str], scenario: Scenario | None = None) -> StepsPlan:
        """Reads a `.plan.json` of several steps; None: of the built-in scenario that it names. Each is judged anew."""
        return StepsPlan._judged(*_load_steps(path, scenario))

    def save(self, path: str | os.PathLike[str]) -> None:
        """Writes a `.plan.json` of all steps, as a whole or not at all."""
        _save_steps(path, self._scenario, self._plans)

    @property
    def solved(self) -> bool:
        """Whether each step has a path, and all of them hold."""
        return 0 < len(self.scenario.steps) == len(self.plans) and all(self.plans)

    @property
    def duration_s(self) -> float | None:
        """From the first way point to the last, in seconds; None where a step has no path, or no time."""
        durations = [step.duration_s for step in self.plans]
        known = [duration_s for duration_s in durations if duration_s is not None]
        return sum(known) if self.solved and len(known) == len(durations) else None

    def verify(self) -> list[Verification]:
        """Judges each plan again, from the way points alone, in the world that it was made in: for the plans of `plan_steps`
        and `load` that which those before it leave."""
        return [step.verify() for step in self.plans]

    def __bool__(self) -> bool:
        return self.solved

    def __len__(self) -> int:
        return len(self.plans)

    @overload
    def __getitem__(self, index: int) -> Plan: ...
    @overload
    def __getitem__(self, index: slice) -> list[Plan]: ...
    def __getitem__(self, index: int | slice) -> Plan | list[Plan]:
        return self.plans[index]

    def __repr__(self) -> str:
        return f"<cranny.StepsPlan of '{self.scenario.id}': {len(self.plans)} of {len(self.scenario.steps)} steps>"


def plan_steps(scenario: Scenario, planner: str | None = None, **keywords: Any) -> StepsPlan:
    """Plans the `steps` of `scenario` in order, each in the world that the one before leaves; what is no target of the
    scenario gets a grasp of the planner's own. The keywords are those of `plan`, but for `place`, `then` and `carry`, which
    the steps say.

    >>> import cranny
    >>> steps = cranny.plan_steps(cranny.Scenario("235"))
    >>> bool(steps), len(steps)
    (True, 3)

    Anything else is done step by step: `scenario.with_target(name)` makes another body the target, `plan(…, place=…)`
    plans for it, and `scenario.after(plan)` is the world that this leaves.
    """
    said = {"place", "then", "carry", "clear_m"} & set(keywords)
    if said:
        raise TypeError(f"{', '.join(sorted(said))}: the steps of the scenario say what is put down where")
    if not scenario.steps:
        raise ValueError(f"'{scenario.id}' has no steps (`steps` in its scenario.yaml)")
    now = scenario
    plans: list[Plan] = []
    for step in scenario.steps:
        found = plan(now.with_target(step["pick"]), planner, place=step["place"], then=step["then"], **keywords)
        plans.append(found)
        if not found:
            break
        now = now.after(found)
    return StepsPlan._judged(scenario, plans)
