"""Worlds of depth images and point clouds."""

from __future__ import annotations

import pickle
from collections.abc import Callable
from typing import Any

import cranny
import numpy as np
import pytest
from depth_camera import ABOVE, FLOOR, INTRINSICS, REGION, SIZE, arm, image, moved, post_at

MAP: dict[str, Any] = {"region": REGION, "cell_m": 0.01}
START, GOAL, POST = [-0.9, 0.0], [1.2, 0.3], (0.6, 0.35)


@pytest.fixture(scope="module")
def robot() -> cranny.Robot:
    return arm()


@pytest.fixture(scope="module")
def known(robot: cranny.Robot) -> cranny.Scenario:
    """The arm on a floor, and its goal: all that is known."""
    return cranny.Scenario.of(robot, [cranny.Body.floor(FLOOR)], start=START).with_goals(GOAL)


@pytest.fixture(scope="module")
def truth(robot: cranny.Robot) -> cranny.Cell:
    return cranny.Cell(robot, [cranny.Body.floor(FLOOR), post_at(*POST)])


@pytest.fixture(scope="module")
def world(robot: cranny.Robot, known: cranny.Scenario) -> cranny.World:
    """What a camera above sees."""
    return cranny.World.from_depth([image(robot, START, [POST])], INTRINSICS, [ABOVE], scenario=known, **MAP)


def test_what_is_free_in_seen_space_is_free_in_truth(
    world: cranny.World, truth: cranny.Cell, robot: cranny.Robot
) -> None:
    q = robot.sample(4000, seed=1)
    seen, true = world.is_free(q), truth.is_free(q)
    wrong = seen & ~true
    # Corners that are thinner than the details of the map may be missed.
    report = world.report["seen"]
    depths = [contact.depth_m for row in q[wrong] for contact in truth.contacts(row)]
    assert max(depths, default=0.0) <= report["detail_m"] / 3.0
    assert 0.25 < seen.mean() < true.mean()
    assert (world.clearance(q[seen]) > 0.0).all()
    assert report["views"] == 1 and report["region"][0] == pytest.approx(REGION[0]) and report["free_m3"] > 0.4
    assert "unseen space counts as free" in report["statement"] and world.scenario.seen == report
    # The post and its shadow are no free space, and neither is the rest of the world.
    assert not world.is_free([np.arctan2(POST[1], POST[0]), 0.0])


def test_a_plan_leads_around_what_the_camera_sees(world: cranny.World, truth: cranny.Cell) -> None:
    plan = world.plan(seed=1)
    assert plan and np.allclose(plan.path[0], START) and np.allclose(plan.path[-1], GOAL)
    assert world.motion_is_free(plan.path[:-1], plan.path[1:]).all()
    assert truth.motion_is_free(plan.path[:-1], plan.path[1:]).all()
    assert not world.motion_is_free(START, GOAL)
    # From where the robot is now.
    now = plan.path[0] + 0.2 * (plan.path[1] - plan.path[0])
    again = world.plan(start=now)
    assert again and np.array_equal(again.path[0], now)
    assert cranny.plan(world.scenario, start=now).path.tolist() == again.path.tolist()
    assert cranny.plan(world.scenario.with_start(now)).path.tolist() == again.path.tolist()
    copy = pickle.loads(pickle.dumps(again))
    assert copy and (copy.path == again.path).all()


def test_images_in_millimetres_are_the_same_world(robot: cranny.Robot, known: cranny.Scenario) -> None:
    exact = np.round(1000.0 * image(robot, START, [POST]))
    sensor = {"depth_error_m": 0.0015}
    matrix = np.array([[INTRINSICS[0], 0.0, INTRINSICS[2]], [0.0, INTRINSICS[1], INTRINSICS[3]], [0.0, 0.0, 1.0]])

    def of(pixels: Any, intrinsics: Any, scale: float | None) -> cranny.World:
        return cranny.World.from_depth(
            [pixels], intrinsics, ABOVE[None], scenario=known, **MAP, scale=scale, sensor=sensor
        )

    q = robot.sample(500, seed=2)
    first = of(exact.astype(np.uint16), matrix, None).is_free(q)
    for other in (
        of((exact / 1000.0).astype(np.float32), [matrix], None),
        of(exact / 1000.0, [INTRINSICS], None),
        of((10.0 * exact).astype(np.uint16), INTRINSICS, 0.0001),
        of(exact.astype(">u2")[:, ::-1][:, ::-1], INTRINSICS, None),
    ):
        assert (other.is_free(q) == first).all()
    assert first.any() and not first.all()


def test_an_update_replaces_or_adds_views(robot: cranny.Robot, known: cranny.Scenario) -> None:
    world = cranny.World.from_depth(
        [image(robot, START, [POST])], INTRINSICS, [ABOVE], scenario=known, **MAP, names=["top"]
    )
    at_post = [np.arctan2(POST[1], POST[0]), 0.0]
    assert not world.is_free(at_post)
    before = world.scenario
    # The post is taken away, and the arm has moved.
    now = [-1.2, 0.4]
    world.update([image(robot, now, [], seed=1)], q=now)
    assert world.is_free(at_post) and world.is_free(now) and [view.name for view in world.views] == ["top"]
    assert world.scenario.start.tolist() == now and before.start.tolist() == START
    free_m3 = world.report["seen"]["free_m3"]
    # A second camera sees what the arm hides from the first.
    other = ABOVE @ moved(0.3, 0.2, 0.0)
    world.update([image(robot, now, [], other, seed=2)], poses=[other], add=True)
    assert [view.name for view in world.views] == ["top", "view2"]
    assert world.report["seen"]["views"] == 2 and world.report["seen"]["free_m3"] > free_m3
    # The robot moves: the views that are kept show it where it was, and it hides no longer what is there.
    before_m3 = world.report["seen"]["free_m3"]
    world.update([image(robot, START, [])], poses=[ABOVE], add=True, q=START)
    assert [view.q is None for view in world.views] == [False, False, True]
    assert world.report["seen"]["free_m3"] > before_m3
    assert np.array_equal(world.scenario.start, START)
    with pytest.raises(ValueError, match="view 'top': the configuration has 3 values, but the robot has 2 joints"):
        cranny.World(known, views=[world.views[0].with_q([0.1, 0.2, 0.3])])
    with pytest.raises(ValueError, match="q"):
        world.views[0].with_q([float("nan")] * 6)
    # An update that fails changes nothing.
    kept = world.scenario
    with pytest.raises(ValueError, match="shape"):
        world.update([np.zeros(5)])
    assert world.scenario is kept
    for names in (["top"], ["a", "a"]):
        with pytest.raises(ValueError, match=f"there is a view '{names[0]}' already"):
            world.update([image(robot, START, [])] * len(names), INTRINSICS, [ABOVE] * len(names), add=True, names=names)
    assert world.scenario is kept
    world.update([image(robot, START, [POST])], INTRINSICS, [ABOVE], q=START, names=["view2"])
    assert not world.is_free(at_post) and len(world.views) == 1
    world.update([image(robot, START, [POST])], INTRINSICS, [ABOVE], add=True)
    assert [view.name for view in world.views] == ["view2", "view3"]


def test_space_that_no_camera_saw_is_solid_or_free(robot: cranny.Robot, known: cranny.Scenario) -> None:
    pixels = image(robot, START, [])
    # The camera sees nothing on one side.
    pixels[: SIZE // 2] = np.nan
    hidden = [0.8, 0.0]

    def of(unseen: Any) -> cranny.World:
        return cranny.World.from_depth([pixels], INTRINSICS, [ABOVE], scenario=known, **MAP, unseen=unseen)

    assert not of("solid").is_free(hidden) and of("free").is_free(hidden)
    report = of("solid").report["views"][0]
    assert report["valid"] == SIZE * SIZE // 2 and report["dropped"]["nan"] == SIZE * SIZE // 2


def test_depths_that_are_none_are_counted() -> None:
    pixels = np.full((4, 6), 1.0, dtype=np.float32)
    pixels[0] = [np.nan, np.inf, -np.inf, -1.0, 0.0, 9.0]
    view = cranny.DepthView(pixels, (5.0, 5.0, 2.5, 1.5), np.eye(4))
    assert view.dropped == {"zero": 1, "nan": 1, "infinite": 2, "negative": 1, "masked": 0, "out_of_range": 1}
    assert view.valid == 18 and view.shape == (4, 6) and view.name == "view"
    assert np.isnan(view.depths[0]).all() and (view.depths[1:] == 1.0).all()
    masked = np.ma.masked_array(pixels, mask=pixels > 0.5)
    hidden = cranny.DepthView(masked, (5.0, 5.0, 2.5, 1.5), np.eye(4))
    assert hidden.valid == 0 and hidden.dropped == {
        "zero": 1, "nan": 1, "infinite": 1, "negative": 1, "masked": 20, "out_of_range": 0
    }
    assert pickle.loads(pickle.dumps(hidden)).dropped == hidden.dropped
    whole = np.ma.masked_array(np.full((4, 6), 1000, dtype=np.uint16), mask=np.eye(4, 6, dtype=bool))
    whole[3, 5] = 0
    parted = cranny.DepthView(whole, (5.0, 5.0, 2.5, 1.5), np.eye(4))
    assert (parted.dropped["masked"], parted.dropped["zero"], parted.dropped["nan"], parted.valid) == (4, 1, 0, 19)
    assert np.nanmax(parted.depths) == np.float32(1.0) and np.isnan(np.diag(parted.depths)).all()


def test_points_of_a_view_are_where_its_pixels_look(robot: cranny.Robot) -> None:
    depth = image(robot, START, [POST])
    view = cranny.DepthView(depth, INTRINSICS, ABOVE, name="top", depth_error_m=0.002)
    v, u = np.divmod(np.arange(SIZE * SIZE), SIZE)
    rays = np.stack([(u - INTRINSICS[2]) / INTRINSICS[0], (v - INTRINSICS[3]) / INTRINSICS[1], np.ones_like(u)], axis=1)
    expected = (rays * depth.reshape(-1, 1)) @ ABOVE[:3, :3].T + ABOVE[:3, 3]
    np.testing.assert_allclose(view.points(), expected, atol=2e-6)
    copy = pickle.loads(pickle.dumps(view))
    assert repr(copy) == repr(view) and np.array_equal(copy.depths, view.depths)
    assert np.array_equal(copy.pose, view.pose) and copy.intrinsics == INTRINSICS


def test_a_cloud_is_an_obstacle(robot: cranny.Robot, known: cranny.Scenario) -> None:
    view = cranny.DepthView(image(robot, START, [POST]), INTRINSICS, ABOVE)
    points = np.vstack([view.points(), [[np.nan, 0.0, 0.0], [0.0, 50.0, 0.0]]])
    world = cranny.World.from_cloud(
        points, 0.006, scenario=known, voxel_m=0.01, crop=[[-1, -1, -0.25], [1, 1, 1]], own_margin_m=0.02
    )
    counts = world.report["clouds"][0]
    assert counts["name"] == "cloud" and counts["points"] == SIZE * SIZE + 2 and counts["not_finite"] == 1
    assert counts["own"] > 500 and counts["thinned"] > 0 and counts["cropped"] > SIZE * SIZE // 2
    assert counts["points"] == counts["kept"] + sum(counts[key] for key in ("not_finite", "cropped", "own", "known", "thinned"))
    # The camera sees the sides of the post that face it; what it does not see counts as free.
    assert not world.is_free([np.arctan2(POST[1], POST[0]), 0.0]) and world.is_free(START)
    plan = world.plan()
    assert plan and world.motion_is_free(plan.path[:-1], plan.path[1:]).all()
    body = cranny.Body.cloud("points", points[:100], 0.006)
    assert body.kinds == ["union"] and pickle.loads(pickle.dumps(body)).kinds == ["union"]
    world.add_cloud([[0.9, 0.0, 0.0]], 0.1, name="ball")
    assert not world.is_free([0.0, 0.0]) and [entry["name"] for entry in world.report["clouds"]] == ["cloud", "ball"]
    world.add_cloud([[0.9, 0.0, 0.0]], 0.05, name="ball", pose=[0.0, 0.0, 1.0])
    assert world.is_free([0.0, 0.0])
    world.remove_cloud("ball")
    assert len(world.report["clouds"]) == 1
    # Images and clouds together.
    world.update([image(robot, START, [POST])], INTRINSICS, [ABOVE])
    assert {"cloud", "occupied", "unseen"} <= {body.name for body in world.scenario.world}


def test_the_points_of_the_target_are_cut_out(robot: cranny.Robot) -> None:
    can = cranny.Body.cylinder("can", 0.03, length=0.1, pose=[0.5, 0.0, 0.0])
    scenario = cranny.Scenario.of(robot, [can], start=START, target="can")
    angles = np.linspace(0.0, 6.0, 50)
    points = np.stack([0.5 + 0.03 * np.cos(angles), 0.03 * np.sin(angles), 0.0 * angles], axis=1)
    kept, counts = cranny.filter_cloud([*points, [0.5, 0.5, 0.0]], known=[can], known_margin_m=0.001)
    assert counts["known"] == 50 and kept.dtype == np.float32 and kept.tolist() == [[0.5, 0.5, 0.0]]
    # Without a margin, points inside of a body or of the robot are left out.
    assert cranny.filter_cloud([[0.5, 0.0, 0.0], [0.5, 0.5, 0.0]], known=[can])[1]["known"] == 1
    assert cranny.filter_cloud([[0.2, 0.0, 0.0], [0.5, 0.5, 0.0]], robot=robot, q=[0.0, 0.0])[1]["own"] == 1
    world = cranny.World(scenario)
    world.add_cloud([*points, [0.5, 0.5, 0.0]], 0.01, target_margin_m=0.001)
    assert world.report["clouds"][0]["known"] == 50 and world.report["seen"] is None
    with pytest.raises(ValueError, match="none of the 50 points is left .*50 known"):
        world.add_cloud(points, 0.01, target_margin_m=0.001)


TURNED = ABOVE.copy()
TURNED[0, 0] = 1.01
GOOD: dict[str, Any] = {"images": [np.ones((4, 6))], "intrinsics": (5.0, 5.0, 2.5, 1.5), "poses": [ABOVE]}


@pytest.mark.parametrize(
    ("change", "message"),
    [
        ({"intrinsics": None}, "intrinsics: there are none"),
        ({"intrinsics": (5.0, 5.0, 2.5)}, r"intrinsics has shape \(3,\), but \(fx, fy, cx, cy\)"),
        ({"intrinsics": (0.0, 5.0, 2.5, 1.5)}, "focal length in pixels of a camera must be above 0"),
        ({"intrinsics": (np.nan, 5.0, 2.5, 1.5)}, "every value must be finite"),
        ({"intrinsics": [[5.0, 0.1, 2.5], [0.0, 5.0, 1.5], [0.0, 0.0, 1.0]]}, "camera matrix is"),
        ({"intrinsics": [(5.0, 5.0, 2.5, 1.5)] * 2}, "intrinsics: 2 are given for 1 images"),
        ({"images": []}, "images: the list is empty"),
        ({"images": [None]}, "image 0: image is None"),
        ({"images": [np.ones((4, 6))] * 2}, "poses: 1 are given for 2 images"),
        ({"images": [np.ones((4, 6, 3))]}, r"image 0: image has shape \(4, 6, 3\), but \(H, W\) is expected"),
        ({"images": [np.ones((0, 6))]}, "height in pixels of a camera must be 1 to 8192, but is 0"),
        ({"images": [np.ones((4, 6), dtype=np.int32)]}, "image 0: image has dtype int32, but uint16"),
        ({"images": [np.ones((4, 6), dtype=complex)]}, "dtype complex128, but uint16"),
        ({"images": [np.ones((4, 6), dtype=bool)]}, "dtype bool, but uint16"),
        ({"images": [[["a"]]]}, "dtype <U1, but uint16"),
        ({"images": [np.ones((4, 6)), np.ones((4, 6), dtype=np.uint8)], "poses": [ABOVE] * 2}, "image 1: .*dtype uint8"),
        ({"poses": [TURNED]}, "image 0: pose: "),
        ({"poses": [2.0 * ABOVE]}, "image 0: pose: "),
        ({"poses": [np.full((4, 4), np.nan)]}, "finite"),
        ({"poses": [np.diag([1.0, 1.0, -1.0, 1.0])]}, "image 0: pose: "),
        ({"poses": [np.eye(3)]}, r"pose has shape \(3, 3\)"),
        ({"poses": [ABOVE + 1e6]}, "image 0: "),
        ({"poses": None}, "poses: there are none for 1 images, and none are known"),
        ({"scale": 0.0}, "scale is 0, but"),
        ({"scale": np.nan}, "scale is NaN, but"),
        ({"sensor": {"depth_error_m": -1.0}}, "depth_error_m of a sensor must be 0 to 1, but is -1"),
        ({"sensor": {"nearest_m": 9.0}}, "nearest_m"),
        ({"sensor": [{}, {}]}, "sensor: 2 are given for 1 images"),
        ({"names": ["a", "b"]}, "names: 2 are given for 1 images"),
        ({"unseen": "maybe"}, "unseen is 'maybe'"),
        ({"cell_m": 0.0}, "cells must be 0.001 to 0.2 m wide"),
        ({"region": [[0.0, 0.0, 0.0], [1.0, 1.0, 0.0]]}, "least coordinates must be less"),
        ({"region": [1.0] * 6}, r"box has shape \(6,\), but \(2, 3\)"),
        ({"robot_reach_m": 1.0}, "robot_reach_m"),
        ({"q": [0.0]}, r"start has shape \(1,\)"),
    ],
)
def test_images_that_are_none_are_refused(known: cranny.Scenario, change: dict[str, Any], message: str) -> None:
    given: dict[str, Any] = {**GOOD, "region": REGION, **change}
    images, intrinsics, poses = given.pop("images"), given.pop("intrinsics"), given.pop("poses")
    with pytest.raises(ValueError, match=message):
        cranny.World.from_depth(images, intrinsics, poses, scenario=known, **given)


@pytest.mark.parametrize(
    ("call", "message"),
    [
        (lambda w: w.add_cloud(np.zeros((0, 3)), 0.01), "points: the cloud has no points"),
        (lambda w: w.add_cloud(np.full((5, 3), np.nan), 0.01), "no valid point: all 5 have"),
        (lambda w: w.add_cloud(None, 0.01), "points is None"),
        (lambda w: w.add_cloud(np.zeros((5, 2)), 0.01), r"points has shape \(5, 2\), but \(N, 3\)"),
        (lambda w: w.add_cloud(np.zeros((5, 3), dtype=complex), 0.01), "dtype complex128"),
        (lambda w: w.add_cloud([["a", "b", "c"]], 0.01), "dtype <U1"),
        (lambda w: w.add_cloud([[0.0, 0.0, 2000.0]], 0.01), "point 0 has the coordinate 2000"),
        (lambda w: w.add_cloud([[0.0, 0.0, 0.5]], 0.0), "the radius of the points of a cloud"),
        (lambda w: w.add_cloud([[0.0, 0.0, 0.5]], np.nan), "the radius of the points of a cloud"),
        (lambda w: w.add_cloud([[0.0, 0.0, 0.5]], 0.01, voxel_m=-1.0), "side of a voxel"),
        (lambda w: w.add_cloud([[0.0, 0.0, 0.5]], 0.01, own_margin_m=-1.0), "margin, in metres, of a filter must be 0 to 10"),
        (lambda w: w.add_cloud([[0.0, 0.0, 0.5]], 0.01, crop=[[1, 1, 1], [2, 2, 2]]), "none of the 1 points is left"),
        (lambda w: w.add_cloud([[0.0, 0.0, 0.5]], 0.01, crop=[[2, 1, 1], [1, 2, 2]]), "least coordinates"),
        (lambda w: w.add_cloud([[0.0, 0.0, 0.5]], 0.01, pose=TURNED), "pose: "),
        (lambda w: w.add_cloud([[0.0, 0.0, 0.5]], 0.01, target_margin_m=0.01), "has no target"),
        (lambda w: w.add_cloud([[0.0, 0.0, 0.5]], 0.01, name="floor"), "floor"),
        (lambda w: w.remove_cloud("nowhere"), r"there is no cloud 'nowhere' \(there are: none\)"),
        (lambda w: w.update([np.ones((4, 6))]), "intrinsics: there are none for 1 images, and none are known"),
        (lambda w: cranny.filter_cloud([[0, 0, 0]], own_margin_m=0.1), "own_margin_m needs `robot`"),
        (lambda w: cranny.filter_cloud([[0, 0, 0]], robot=arm()), "robot needs its configuration `q`"),
        (lambda w: cranny.filter_cloud([[0, 0, 0]], q=START), "q needs the `robot`"),
        (lambda w: cranny.filter_cloud([[0, 0, 0]], robot=arm(), q=[0.0]), r"q has shape \(1,\)"),
        (lambda w: cranny.Body.cloud("a", [], 0.1), r"points has shape \(0,\), but \(N, 3\)"),
        (lambda w: w.plan(start=[0.0]), r"start has shape \(1,\)"),
    ],
)
def test_clouds_that_are_none_are_refused(
    known: cranny.Scenario, call: Callable[[cranny.World], Any], message: str
) -> None:
    world = cranny.World(known)
    with pytest.raises(ValueError, match=message):
        call(world)
    assert world.scenario is not None and world.report == {"views": [], "clouds": [], "seen": None}
