"""URDFs of random arms whose links can pass each other only through narrow windows of their joints."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

Floats = NDArray[np.float64]


def shape(kind: str, sizes: list[float], xyz: list[float], rpy: list[float] | None = None) -> str:
    """Collision shape of a URDF."""
    names = {"box": ["size"], "sphere": ["radius"], "cylinder": ["radius", "length"]}[kind]
    values = [" ".join(map(str, sizes))] if kind == "box" else [str(size) for size in sizes]
    figures = " ".join(f'{name}="{value}"' for name, value in zip(names, values, strict=True))
    origin = f'<origin xyz="{" ".join(map(str, xyz))}" rpy="{" ".join(map(str, rpy or [0.0, 0.0, 0.0]))}"/>'
    return f"<collision>{origin}<geometry><{kind} {figures}/></geometry></collision>"


def joint(name: str, kind: str, links: tuple[str, str], xyz: list[float], rpy: list[float], limits: tuple[float, float]) -> str:
    """Joint of a URDF about or along z."""
    return (
        f'<joint name="{name}" type="{kind}"><parent link="{links[0]}"/><child link="{links[1]}"/>'
        f'<origin xyz="{" ".join(map(str, xyz))}" rpy="{" ".join(map(str, rpy))}"/><axis xyz="0 0 1"/>'
        f'<limit lower="{limits[0]}" upper="{limits[1]}" velocity="1" effort="1"/></joint>'
    )


class WindowRobot:
    """Arm of 3 to 6 joints. One or two rotate a fin in a ring that is open in one or two windows, 0.5 to 5 % of their range.

    `limits` has the limits of each joint, and `windows` the middle and width of each window of a joint with a ring.
    """

    def __init__(self, rng: np.random.Generator) -> None:
        self.rng = rng
        self.limits: dict[str, tuple[float, float]] = {}
        self.windows: dict[str, list[tuple[float, float]]] = {}
        joints = int(rng.integers(3, 6))
        with_ring = set(rng.choice(joints, int(rng.integers(1, 3)), replace=False).tolist())
        links: dict[str, str] = {"l0": shape("box", [0.1, 0.1, 0.05], [0.0, 0.0, -0.05])}
        text = ""
        for k in range(joints):
            parent, name, height = f"l{k}", f"j{k}", float(rng.uniform(0.25, 0.4))
            reach = float(rng.uniform(0.6, 3.1))
            self.limits[name] = (-reach, reach)
            xyz, rpy = [0.0, 0.0, height], [*rng.uniform(-0.6, 0.6, 2).tolist(), 0.0]
            links[f"l{k + 1}"] = self.body(height)
            if k not in with_ring and rng.random() < 0.4:
                # Shapes at a joint that always touch, or blocks beside the axis that touch for some of the rotation.
                off = float(rng.choice([0.0, 0.03]))
                links[parent] += shape("sphere", [0.012], [off, 0.0, height])
                links[f"l{k + 1}"] += shape("cylinder", [0.012, 0.02], [off, 0.0, 0.0])
            if k in with_ring:
                # The ring is fixed to the parent in the joint's frame.
                links[f"ring{k}"], links[f"l{k + 1}"] = self.ring(name, links[f"l{k + 1}"])
                at = joint(f"f{k}", "fixed", (parent, f"ring{k}"), xyz, rpy, (0.0, 0.0))
                text += at
                parent, xyz, rpy = f"ring{k}", [0.0, 0.0, 0.0], [0.0, 0.0, 0.0]
                # A joint of negligible range inserts a link, so that the two are not adjacent.
                if rng.random() < 0.5:
                    links[f"between{k}"] = shape("sphere", [0.006], [0.0, 0.0, 0.0])
                    kind = str(rng.choice(["prismatic", "revolute"]))
                    self.limits[f"b{k}"] = (-0.002, 0.002)
                    text += joint(f"b{k}", kind, (parent, f"between{k}"), xyz, rpy, self.limits[f"b{k}"])
                    parent = f"between{k}"
            text += joint(name, "revolute", (parent, f"l{k + 1}"), xyz, rpy, self.limits[name])
        bodies = "".join(f'<link name="{name}">{shapes}</link>' for name, shapes in links.items())
        self.urdf = f'<robot name="windows">{bodies}{text}</robot>'

    def body(self, height: float) -> str:
        """Body of a link that extends from its joint towards the next."""
        kind, long = str(self.rng.choice(["box", "sphere", "cylinder"])), 0.5 * height
        thick = float(self.rng.uniform(0.01, 0.025))
        sizes = {"box": [thick, 2.0 * thick, long], "sphere": [2.0 * thick], "cylinder": [thick, long]}[kind]
        return shape(kind, sizes, [0.0, 0.0, 0.2 * height + 0.25 * height])

    def ring(self, name: str, body: str) -> tuple[str, str]:
        """Blocks around the axis of a joint, and the child's body with a fin or lever that they block outside the
        windows."""
        rng, (_, reach) = self.rng, self.limits[name]
        radius, count = float(rng.uniform(0.08, 0.16)), int(rng.integers(1, 3))
        thick = float(rng.uniform(0.001, 0.003))
        fin, sizes = [("box", [0.05, 2.0 * thick, 0.01]), ("cylinder", [thick, 0.05]), ("sphere", [thick])][rng.integers(3)]
        turned = [0.0, 0.5 * np.pi, 0.0] if fin == "cylinder" else None
        half_fin = float(np.arctan2(thick, radius - 0.025))
        middles = rng.uniform(-0.4, 0.4) * reach + np.arange(count) * reach * 0.5
        widths = rng.uniform(0.005, 0.05, count) / count * 2.0 * reach
        self.windows[name] = [(float(middle), float(width)) for middle, width in zip(middles, widths, strict=True)]
        # Open within the windows, closed between them by overlapping upright blocks.
        far = min(reach + 0.3, np.pi)
        edges = [-far]
        for middle, width in self.windows[name]:
            edges += [middle - 0.5 * width - half_fin, middle + 0.5 * width + half_fin]
        edges.append(far)
        round_blocks, ring = bool(rng.random() < 0.5), ""
        for low, high in zip(edges[::2], edges[1::2], strict=True):
            half = float(np.arctan(0.01 / radius))
            for angle in np.linspace(low + half, high - half, max(2, int((high - low) / (1.3 * half)))):
                at = [float(radius * np.cos(angle)), float(radius * np.sin(angle)), 0.0]
                if round_blocks:
                    ring += shape("cylinder", [0.01, 0.04], at)
                else:
                    ring += shape("box", [0.02, 0.02, 0.04], at, [0.0, 0.0, float(angle)])
        return ring, body + shape(fin, sizes, [radius, 0.0, 0.0], turned)
