"""Depth images and point clouds as messages of ROS."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import cranny
import numpy as np
import pytest
from conftest import package
from numpy.typing import NDArray
from test_moveit import plain, typed

POINTS = np.array([[0.1, 0.2, 0.3], [np.nan, 0.0, 0.0], [-1.5, 2.0, 0.25]])


def cloud(kind: str = "f4", *, big: bool = False, padding: int = 0) -> dict[str, Any]:
    """The points in the second of three rows of bytes of each point, with a field before and one after them."""
    order = ">" if big else "<"
    row = np.dtype(
        {"names": ["ring", "z", "y", "x", "rgb"], "formats": [f"{order}u2"] + 3 * [order + kind] + [f"{order}u4"],
         "offsets": [0, 4, 12, 20, 28], "itemsize": 32}
    )
    rows = np.zeros((1, 3), dtype=row)
    for axis, name in enumerate("xyz"):
        rows[name] = POINTS[:, axis]
    data = rows.tobytes() + bytes(padding)
    fields = [("ring", 0, 4), ("z", 4, 7 if kind == "f4" else 8), ("y", 12, 7 if kind == "f4" else 8)]
    fields += [("x", 20, 7 if kind == "f4" else 8), ("rgb", 28, 6)]
    return {
        "header": {"stamp": {"sec": 0, "nanosec": 0}, "frame_id": "camera"},
        "height": 1,
        "width": 3,
        "fields": [{"name": n, "offset": o, "datatype": t, "count": 1} for n, o, t in fields],
        "is_bigendian": big,
        "point_step": 32,
        "row_step": 96 + padding,
        "data": data,
        "is_dense": False,
    }


@pytest.mark.parametrize("big", [False, True])
@pytest.mark.parametrize("kind", ["f4", "f8"])
def test_a_cloud_has_fields_of_any_place_and_order(kind: str, big: bool) -> None:
    points, dropped = cranny.ros.points_of(cloud(kind, big=big, padding=8))
    assert dropped == 1 and points.dtype == np.float32
    np.testing.assert_array_equal(points, POINTS[[0, 2]].astype(np.float32))
    # As JSON and YAML have it.
    listed = cloud(kind, big=big)
    again, _ = cranny.ros.points_of({**listed, "data": list(listed["data"])})
    np.testing.assert_array_equal(points, again)
    assert cranny.Body.cloud("cloud", points, 0.01).kinds == ["union"]


@pytest.mark.parametrize(
    ("change", "message"),
    [
        ({"data": b""}, "1 rows of 96 bytes are announced, but the data has 0 bytes"),
        ({"width": 4}, "4 points of 32 bytes do not fit"),
        ({"width": 0, "row_step": 0, "data": b""}, "the cloud has no points"),
        ({"width": -1}, "out of range"),
        ({"fields": []}, "there is no field 'x'"),
        ({"fields": [{"name": "x", "offset": 30, "datatype": 7, "count": 1}] * 2}, "two fields 'x'"),
        ({"data": "abc"}, "no list of bytes"),
        ({"data": [300] * 96}, "no list of bytes"),
        ({"data": 96}, "no list of bytes"),
        ({"point_step": None}, "point_step"),
    ],
)
def test_clouds_that_contradict_themselves_are_refused(change: dict[str, Any], message: str) -> None:
    message_of = {key: value for key, value in {**cloud(), **change}.items() if value is not None}
    with pytest.raises(ValueError, match=f"PointCloud2: .*{message}"):
        cranny.ros.points_of(message_of)


DEPTHS = np.array([[0.5, 1.0, 2.0], [0.0, 1.25, 3.0]])


def depth_image(encoding: str = "32FC1", *, big: bool = False, padding: int = 0) -> dict[str, Any]:
    kind = (">" if big else "<") + cranny.ros.DEPTH_ENCODINGS[encoding]
    values = DEPTHS if encoding == "32FC1" else 1000.0 * DEPTHS
    data = b"".join(row.astype(kind).tobytes() + bytes([7] * padding) for row in values)
    return {
        "header": {"stamp": {"sec": 0, "nanosec": 0}, "frame_id": "camera"},
        "height": 2,
        "width": 3,
        "encoding": encoding,
        "is_bigendian": int(big),
        "step": 3 * np.dtype(kind).itemsize + padding,
        "data": data,
    }


INFO: dict[str, Any] = {
    "header": {"stamp": {"sec": 0, "nanosec": 0}, "frame_id": "camera"},
    "height": 2,
    "width": 3,
    "distortion_model": "plumb_bob",
    "d": [0.0] * 5,
    "k": [4.0, 0.0, 1.0, 0.0, 5.0, 0.5, 0.0, 0.0, 1.0],
    "r": np.eye(3).ravel().tolist(),
    "p": [3.0, 0.0, 1.5, 0.0, 0.0, 3.5, 0.25, 0.0, 0.0, 0.0, 1.0, 0.0],
    "binning_x": 0,
    "binning_y": 0,
    "roi": {"x_offset": 0, "y_offset": 0, "height": 0, "width": 0, "do_rectify": False},
}


@pytest.mark.parametrize("padding", [0, 2, 5])
@pytest.mark.parametrize("big", [False, True])
@pytest.mark.parametrize("encoding", ["32FC1", "16UC1", "mono16"])
def test_an_image_has_rows_of_any_step_and_order(encoding: str, big: bool, padding: int) -> None:
    depths = cranny.ros.depth_of(depth_image(encoding, big=big, padding=padding))
    assert depths.dtype == (np.float32 if encoding == "32FC1" else np.uint16) and depths.dtype.isnative
    np.testing.assert_allclose(depths * (1.0 if encoding == "32FC1" else 0.001), DEPTHS, atol=1e-12)
    view = cranny.ros.depth_view(depth_image(encoding, big=big, padding=padding), INFO, np.eye(4), farthest_m=2.5)
    assert view.valid == 4 and view.dropped["zero"] == 1 and view.dropped["out_of_range"] == 1
    assert view.intrinsics == (4.0, 5.0, 1.0, 0.5)


@pytest.mark.parametrize(
    ("change", "message"),
    [
        ({"encoding": "rgb8"}, "the encoding is 'rgb8', but depths have one of 32FC1, 16UC1, mono16"),
        ({"data": b"1"}, "2 rows of 12 bytes are announced for 3 pixels of 4 bytes, but the data has 1 bytes"),
        ({"step": 8}, "2 rows of 8 bytes"),
        ({"height": 0, "data": b""}, "0 rows"),
        ({"data": None}, "there is no 'data' in the message"),
    ],
)
def test_images_that_are_no_depths_are_refused(change: dict[str, Any], message: str) -> None:
    given = {key: value for key, value in {**depth_image(), **change}.items() if value is not None}
    with pytest.raises(ValueError, match=f"Image: .*{message}"):
        cranny.ros.depth_of(given)


def test_intrinsics_are_those_of_the_image() -> None:
    plain_k = np.array([[4.0, 0.0, 1.0], [0.0, 5.0, 0.5], [0.0, 0.0, 1.0]])
    assert np.array_equal(cranny.ros.intrinsics_of(INFO), plain_k)
    # ROS 1 has capitals.
    capitals = {key.upper() if key in "dkrp" else key: value for key, value in INFO.items()}
    assert np.array_equal(cranny.ros.intrinsics_of(capitals), plain_k)
    bent = {**INFO, "d": [0.1, 0.0, 0.0, 0.0, 0.0]}
    with pytest.raises(ValueError, match=r"distortion .*rectify the images \(image_proc\) and give rectified=True"):
        cranny.ros.intrinsics_of(bent)
    rectified = cranny.ros.intrinsics_of(bent, rectified=True)
    assert np.array_equal(rectified, [[3.0, 0.0, 1.5], [0.0, 3.5, 0.25], [0.0, 0.0, 1.0]])
    region = {"x_offset": 1, "y_offset": 1, "height": 1, "width": 2, "do_rectify": False}
    assert cranny.ros.intrinsics_of({**INFO, "roi": region})[:2, 2].tolist() == [0.0, -0.5]
    for change, message in (
        ({"k": [0.0] * 9}, "not calibrated"),
        ({"k": [1.0] * 8}, "8 numbers, but 9 are expected"),
        ({"binning_x": 2}, "binned"),
        ({"roi": {**region, "x_offset": 2}}, "region of interest is not within the image"),
    ):
        with pytest.raises(ValueError, match=message):
            cranny.ros.intrinsics_of({**INFO, **change})
    with pytest.raises(ValueError, match="CameraInfo: there is no 'k'"):
        cranny.ros.intrinsics_of({key: value for key, value in INFO.items() if key != "k"})
    with pytest.raises(ValueError, match="3 × 2 pixels, but its CameraInfo is for 6 × 2"):
        cranny.ros.depth_view(depth_image(), {**INFO, "width": 6}, np.eye(4))
    with pytest.raises(ValueError, match="frame 'camera', but its CameraInfo in 'other'"):
        cranny.ros.depth_view(depth_image(), {**INFO, "header": {"frame_id": "other"}}, np.eye(4))


def test_messages_of_a_bag_are_read(tmp_path: Path) -> None:
    package("rosbags")
    from rosbags.rosbag2 import Reader, Writer
    from rosbags.typesys import Stores, get_typestore

    store = get_typestore(Stores.ROS2_HUMBLE)
    kinds = {"points": "PointCloud2", "image": "Image", "info": "CameraInfo"}
    messages: dict[str, Any] = {"points": cloud(), "image": depth_image("16UC1", padding=4), "info": INFO}
    with Writer(tmp_path / "bag", version=9) as writer:
        for topic, message in messages.items():
            kind = f"sensor_msgs/msg/{kinds[topic]}"
            listed = {key: list(value) if isinstance(value, bytes) else value for key, value in message.items()}
            connection = writer.add_connection(f"/{topic}", kind, typestore=store)
            writer.write(connection, 0, store.serialize_cdr(typed(store, kind, listed), kind))
    read: dict[str, Any] = {}
    with Reader(tmp_path / "bag") as reader:
        for connection, _, raw in reader.messages():
            read[connection.topic[1:]] = plain(store, store.deserialize_cdr(raw, connection.msgtype))
    points, dropped = cranny.ros.points_of(read["points"])
    assert dropped == 1 and np.array_equal(points, POINTS[[0, 2]].astype(np.float32))
    view = cranny.ros.depth_view(read["image"], read["info"], np.eye(4))
    expected: NDArray[np.float64] = np.where(DEPTHS > 0.0, DEPTHS, np.nan)
    np.testing.assert_allclose(view.depths, expected, atol=1e-6)
