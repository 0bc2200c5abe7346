"""A scene from a drawing: layers of a DXF file become bodies, points that two layers share become revolute joints.

usage: python examples/from_dxf.py drawing.dxf scene.toml        needs ezdxf (pip install ezdxf==1.4.5)

The drawing is in millimetres. A layer with lines or polylines is a body, its corners are its points; points on the layer GROUND are
fixed. Every body gets 1 kg for each metre of its length: draw, then write the masses that you know, loads and drivers.

    cotree show models/four_bar/scene.toml --drawing pose.dxf
    python examples/from_dxf.py pose.dxf again.toml && cotree check again.toml
"""

import itertools
import math
import re
import sys

import ezdxf

NEAR = 1e-6  # m


def places(entity):
    """The corners of an entity in metres."""
    kind = entity.dxftype()
    if kind == "LINE":
        corners = [entity.dxf.start, entity.dxf.end]
    elif kind == "POLYLINE":
        corners = [vertex.dxf.location for vertex in entity.vertices]
    elif kind == "LWPOLYLINE":
        corners = list(entity.vertices())
    elif kind == "POINT":
        corners = [entity.dxf.location]
    else:
        return []
    return [(corner[0] / 1000, corner[1] / 1000) for corner in corners]


def read(path):
    """The points of the ground, and of every layer that has a line."""
    ground, bodies = [], {}
    for entity in ezdxf.readfile(path).modelspace():
        layer = entity.dxf.layer
        points = ground if layer.upper() == "GROUND" else bodies.setdefault(layer, [])
        for place in places(entity):
            if all(math.dist(place, known) > NEAR for known in points):
                points.append(place)
    drawn = {name: points for name, points in bodies.items() if len(points) > 1 and name.upper() not in ("JOINTS", "SPRINGS")}
    return ground, drawn


def unused(name, used):
    """A name that begins with a letter and that no other body has; `ground` and `j1`, `j2`, ... are taken too."""
    if not name[:1].isalpha() or name == "ground" or re.fullmatch(r"j\d+", name):
        name = f"layer_{name}"
    numbered = (f"{name}_{number}" for number in itertools.count(2))
    return name if name not in used else next(other for other in numbered if other not in used)


def scene(ground, bodies):
    """The text of the scene. Frames lie as the drawing does, so all angles are zero at its pose."""
    name = {}
    for layer in bodies:
        name[layer] = unused(re.sub(r"[^a-z0-9_]", "_", layer.lower()), name.values())
    middle = {layer: [sum(xs) / len(points) for xs in zip(*points)] for layer, points in bodies.items()}
    lines = ["format = 1", 'name   = "from_dxf"', "gravity = [0, -9.81]", "", "[ground.points]"]
    lines += [f"g{index} = [{x!r}, {y!r}]" for index, (x, y) in enumerate(ground)]
    for layer, points in bodies.items():
        (x, y), length = middle[layer], max(math.dist(a, b) for a in points for b in points)
        own = ", ".join(f"p{index} = [{u - x!r}, {v - y!r}]" for index, (u, v) in enumerate(points))
        lines += ["", f"[bodies.{name[layer]}]", f"mass    = {length!r}  # assumed", f"inertia = {length**3 / 12!r}  # assumed"]
        lines += [f"points  = {{ {own} }}"]
    ends = [(place, f"ground.g{index}") for index, place in enumerate(ground)]
    joints = 0
    for layer, points in bodies.items():
        for index, place in enumerate(points):
            end = f"{name[layer]}.p{index}"
            first = next((other for at, other in ends if math.dist(at, place) <= NEAR), None)
            if first:
                joints += 1
                lines += ["", f"[joints.j{joints}]", 'type    = "revolute"', f'between = ["{first}", "{end}"]']
            else:
                ends.append((place, end))
    lines += ["", "# The pose of the drawing.", "[initial]"]
    lines += [f'"{name[layer]}.angle" = {{ guess = 0 }}' for layer in bodies]
    lines += ["", "[outputs]", "variables = [" + ", ".join(f'"{name[layer]}.angle"' for layer in bodies) + "]", "", "[experiment]", "stop = 2.0"]
    return "\n".join(lines) + "\n"


if __name__ == "__main__":
    if len(sys.argv) != 3:
        sys.exit("usage: from_dxf.py drawing.dxf scene.toml")
    source, target = sys.argv[1:]
    try:
        ground, bodies = read(source)
        if not bodies:
            sys.exit(f"{source}: no layer but GROUND has a line")
        with open(target, "w") as file:
            file.write(scene(ground, bodies))
    except (OSError, ezdxf.DXFError) as fault:
        sys.exit(f"{source}: {fault}")
