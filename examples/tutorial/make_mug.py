"""Writes mug.obj: a cup of 80 mm by 95 mm with walls of 4 mm and a handle, in metres, its bottom at z = 0.

Needs manifold3d to join cup and handle into one surface, as `cranny object add` requires.
"""

from math import cos, pi, sin

from manifold3d import CrossSection, Manifold

AROUND = 48

# Half of the cup's profile, rotated about its axis.
CUP = [(0.0, 0.0), (0.038, 0.0), (0.040, 0.002), (0.040, 0.095), (0.036, 0.095), (0.036, 0.005), (0.0, 0.005)]
cup = Manifold.revolve(CrossSection([CUP]), AROUND)

# The handle: balls of 5 mm along half an ellipse, each joined with the next by their convex hull.
steps = 16
angles = [-pi / 2 + pi * step / steps for step in range(steps + 1)]
balls = [Manifold.sphere(0.005, 16).translate((0.039 + 0.028 * cos(a), 0, 0.0475 + 0.030 * sin(a))) for a in angles]
links = [Manifold.batch_hull([first, second]) for first, second in zip(balls, balls[1:])]
inside = Manifold.cylinder(0.095, 0.0362, 0.0362, AROUND).translate((0, 0, 0.0049))
mesh = (cup + (sum(links[1:], links[0]) - inside)).simplify(0.0002).to_mesh()

with open("mug.obj", "w", encoding="ascii") as file:
    for x, y, z in mesh.vert_properties[:, :3]:
        file.write(f"v {x:.6f} {y:.6f} {z:.6f}\n")
    for a, b, c in mesh.tri_verts + 1:
        file.write(f"f {a} {b} {c}\n")
