"""MJCF models against MuJoCo: poses of links within 1e-9 and contacts, at 1000 configurations.

The models are written here; benchmarks/models.py compares those of other people.
"""

from __future__ import annotations

import importlib.util
from pathlib import Path
from types import ModuleType

import cranny
import pytest

from conftest import REPOSITORY, package

ARM = """<mujoco model="arm">
  <compiler angle="degree" meshdir="parts"/>
  <default>
    <joint range="-150 150"/>
    <geom friction="0.8 0.1 0.1" rgba="0.7 0.7 0.7 1"/>
    <default class="shell"><geom type="mesh" mesh="link"/></default>
  </default>
  <asset><mesh name="link" file="link.obj" scale="0.1 0.1 0.3" refpos="0 0 -0.5"/></asset>
  <worldbody>
    <geom name="ground" type="plane" size="3 3 0.1"/>
    <body name="base" pos="0 0 0.1">
      <geom type="cylinder" size="0.08 0.1"/>
      <body name="shoulder" pos="0 0 0.12">
        <joint name="j1" axis="0 0 1"/><joint name="j2" axis="0 1 0" pos="0 0 0.02" ref="10"/>
        <geom type="capsule" size="0.05" fromto="0 0 0.05 0 0 0.35"/>
        <body name="elbow" pos="0 0 0.4" euler="0 20 0">
          <joint name="j3" axis="0 1 0"/>
          <geom class="shell"/>
          <geom type="ellipsoid" size="0.06 0.04 0.08" pos="0 0.08 0.1" contype="0" conaffinity="0" group="1"/>
          <body name="wrist" pos="0 0 0.35">
            <joint name="j4" axis="1 0 0"/>
            <geom type="box" size="0.04" fromto="0 0 0 0.1 0.05 0.1"/>
            <geom type="sphere" size="0.05" pos="0 0 0.1" contype="2" conaffinity="3"/>
            <body name="hand" pos="0 0 0.16" axisangle="0 0 1 45">
              <geom type="box" size="0.02 0.08 0.02"/>
              <body name="left" pos="0 0.01 0.06"><joint name="left" type="slide" axis="0 1 0" range="0 0.05"/>
                <geom type="box" size="0.01 0.008 0.04"/></body>
              <body name="right" pos="0 -0.01 0.06"><joint name="right" type="slide" axis="0 -1 0" range="0 0.05"/>
                <geom type="box" size="0.01 0.008 0.04"/></body>
            </body>
          </body>
        </body>
      </body>
    </body>
  </worldbody>
  <contact><exclude body1="base" body2="shoulder"/><exclude body1="left" body2="right"/></contact>
  <equality><joint joint1="right" joint2="left"/></equality>
</mujoco>
"""

OBJ = "".join(
    f"v {x} {y} {z}\n" for x in (-0.5, 0.5) for y in (-0.5, 0.5) for z in (-0.5, 0.5)
) + "f 1 2 4 3\nf 5 7 8 6\nf 1 5 6 2\nf 3 4 8 7\nf 1 3 7 5\nf 2 6 8 4\n"


@pytest.fixture(scope="module")
def models() -> ModuleType:
    """The program that compares models."""
    path = REPOSITORY / "benchmarks/models.py"
    spec = importlib.util.spec_from_file_location("models", path)
    assert spec is not None and spec.loader is not None
    module = importlib.util.module_from_spec(spec)
    import sys

    sys.modules["models"] = module
    spec.loader.exec_module(module)
    return module


def test_an_arm_is_where_mujoco_puts_it_and_touches_what_mujoco_lets_it_touch(models: ModuleType, tmp_path: Path) -> None:
    package("mujoco")
    (tmp_path / "parts").mkdir()
    (tmp_path / "parts/link.obj").write_text(OBJ)
    (tmp_path / "arm.xml").write_text(ARM)
    row = models.compare(tmp_path / "arm.xml", "arm", 1000)
    assert row is not None and not row.reason, row
    assert row.pose < 1e-9, row
    assert row.touching > 100, row
    assert row.grave == 0, row
    # Rounding decides where two just touch.
    assert row.differing <= row.verdicts / 1000, row


def test_a_world_becomes_a_scenario(tmp_path: Path) -> None:
    world = REPOSITORY / "examples/tutorial/cabinet.xml"
    scenario = cranny.Scenario.from_world(
        world, tmp_path / "cabinet", robot="panda_mobile", target="can", joints={"drawer": 0.2}, at=[0.1, -0.9, 0.05, 90]
    )
    assert scenario.target is not None and scenario.target.name == "can"
    assert {body.name for body in scenario.world} == {"table", "cabinet", "drawer", "can", "floor"}
    with pytest.raises(cranny.CrannyError, match="no body 'cup'"):
        cranny.Scenario.from_world(world, tmp_path / "other", robot="panda_mobile", target="cup")
