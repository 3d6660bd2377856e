"""Shapes from CSV, SVG and DXF files: their geometry, what is refused, and configs that need no file afterwards."""

import math
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

import tisph
from tisph.bodies._files import METRES
from tisph.config import load
from tisph.errors import ConfigError
from tisph.geometry.circle import Circle
from tisph.geometry.drawing import MOST_PATHS, read
from tisph.geometry.spline import Spline
from tisph.geometry.tracing import smooth_points
from tisph.studies import sweep

ezdxf = pytest.importorskip("ezdxf")
pytest.importorskip("svgpathtools")

EXAMPLES = Path(__file__).parents[2] / "docs" / "examples"
RADIUS = 0.25
CASE = """\
scene: lattice
fluid: {density: 1.0, kinematic_viscosity: 0.1}
geometry: {length: 1.0, height: 1.0}
bodies: [{type: curve, file: shape.csv}]
drive: {acceleration: 1.0}
discretisation: {particles_across: 40}
time: {end: 1.0}
output: {video: null}
"""
CHANNEL = """\
scene: channel
fluid: {density: 1.0, kinematic_viscosity: 0.1}
geometry: {gap: 1.0, length: 6.0}
walls: {top: {smooth: true, file: wall.csv}}
drive: {acceleration: 1.0}
discretisation: {particles_across: 24}
time: {end: 1.0}
output: {video: null}
"""


@pytest.fixture
def body(tmp_path):
    """Return a function from a body of a lattice to its model, loaded from a config beside the files."""
    (tmp_path / "case.yaml").write_text(CASE)

    def load_body(text, *changes):
        config = load(tmp_path / "case.yaml", [f"bodies.0={text}", *changes])
        (tmp_path / "again.yaml").write_text(config.resolved_yaml())
        assert load(tmp_path / "again.yaml") == config
        return config.bodies[0]

    return load_body


@pytest.fixture
def wall(tmp_path):
    """Return a function from a wall of a channel to the config, loaded from beside the files."""
    (tmp_path / "channel.yaml").write_text(CHANNEL)
    return lambda text, *changes: load(tmp_path / "channel.yaml", [f"walls.top={text}", *changes])


def svg(path, body, head='viewBox="0 0 1 1"'):
    path.write_text(f'<svg xmlns="http://www.w3.org/2000/svg" {head}>{body}</svg>', encoding="utf-8")


def dxf(path, draw):
    document = ezdxf.new()
    draw(document.modelspace())
    document.saveas(path)


def csv(path, points, heading="x,y"):
    np.savetxt(path, points, fmt="%.9f", delimiter=",", header=heading, comments="")


def around(count, radius=RADIUS, middle=(0.5, 0.5)):
    angle = 2 * np.pi * np.arange(count) / count
    return np.array(middle) + radius * np.stack([np.cos(angle), np.sin(angle)], axis=1)


def bezier_circle():
    """The usual four cubic curves, whose radius is right to 2.8e-4."""
    far, near = RADIUS, 0.5522847498 * RADIUS
    corners = [(far, 0), (far, near), (near, far), (0, far)]
    parts = []
    for quarter in range(4):
        turned = [(x * (1j**quarter).real - y * (1j**quarter).imag, x * (1j**quarter).imag + y * (1j**quarter).real)
                  for x, y in corners]  # fmt: skip
        places = [f"{0.5 + x:.12f} {0.5 + y:.12f}" for x, y in turned]
        parts.append(("" if quarter else f"M{places[0]}") + f"C{places[1]} {places[2]} {places[3]}")
    return "".join(parts) + "Z"


def arcs(space):
    for start in (180, 0, 270, 90):
        space.add_arc((0.5, 0.5), RADIUS, start, start + 90)


CIRCLES = {
    "cubic curves": (lambda path: svg(path / "a.svg", f'<path d="{bezier_circle()}"/>'), "a.svg", 3e-4),
    "arcs of a path": (
        lambda path: svg(path / "a.svg", '<path d="M.25 .5A.25 .25 0 0 1 .75 .5A.25 .25 0 0 1 .25 .5Z"/>'),
        "a.svg", 1e-6,
    ),
    "circle": (
        lambda path: svg(path / "a.svg", '<g transform="translate(.5 .5) scale(.5)"><circle r=".5"/></g>'),
        "a.svg", 1e-6,
    ),
    "arcs in any order": (lambda path: dxf(path / "a.dxf", arcs), "a.dxf", 1e-6),
    "bulges": (
        lambda path: dxf(path / "a.dxf", lambda space: space.add_lwpolyline(
            [(0.25, 0.5, 0, 0, 1), (0.75, 0.5, 0, 0, 1)], close=True)),
        "a.dxf", 1e-6,
    ),
    "60 rows": (lambda path: csv(path / "a.csv", around(60)), "a.csv", 1e-6),
}  # fmt: skip
"""Ways to draw a circle: writer of the file, its name, and relative errors of the radius: of the drawing itself, or of
the spline, whose points are tried until it is within 1e-6."""


@pytest.mark.parametrize("way", CIRCLES)
def test_a_drawn_circle_is_the_circle(body, tmp_path, way):
    write, name, tolerance = CIRCLES[way]
    write(tmp_path)
    found = body(f"{{type: curve, file: {name}}}")
    shape, circle = found.shape(), Circle(RADIUS)
    assert found.centre == pytest.approx((0.5, 0.5), abs=tolerance)
    assert math.sqrt(shape.area / math.pi) == pytest.approx(RADIUS, rel=tolerance)
    places = around(50, 0.3, (0.0, 0.0))
    drawn, exact = shape.nearest(places), circle.nearest(places)
    assert np.abs(drawn.distance - exact.distance).max() < 1.01 * tolerance * RADIUS
    assert np.abs(drawn.normal - exact.normal).max() < 40 * tolerance  # slopes of errors that vary over a quarter
    assert found.traced.deviation < 3e-6 * RADIUS


def test_a_polygon_has_the_corners_of_the_drawing(body, tmp_path):
    """Upright, although y points downwards in SVG files; lines of a DXF file stand in any order and direction."""
    svg(tmp_path / "a.svg", '<polygon points=".3,.7 .7,.7 .5,.3"/>')
    found = body("{type: polygon, corner_radius: 0.06, file: a.svg}")
    assert found.centre == pytest.approx((0.5, 1.3 / 3), abs=0.01)  # of the rounded one
    corners = sorted(np.add(found.corners, found.centre).round(9).tolist())
    assert corners == [[0.3, 0.3], [0.5, 0.7], [0.7, 0.3]]
    ends = [((0.7, 0.3), (0.3, 0.3)), ((0.5, 0.7), (0.7, 0.3)), ((0.3, 0.3), (0.5, 0.7 - 1e-5))]
    dxf(tmp_path / "a.dxf", lambda space: [space.add_line(*each) for each in ends])
    lines = body("{type: polygon, corner_radius: 0.06, file: a.dxf}")
    assert lines.shape().area == pytest.approx(found.shape().area, rel=1e-4)
    assert lines.traced.gap == pytest.approx(1e-5)


def test_a_body_stays_where_it_is_drawn_or_goes_to_its_centre(body, tmp_path):
    csv(tmp_path / "a.csv", around(40, 20.0, (30.0, 60.0)), "x [mm],y [mm]")
    file = "{path: a.csv, unit: mm, scale: 10}"
    assert body(f"{{type: curve, file: {file}}}").centre == pytest.approx((0.3, 0.6))
    moved = body(f"{{type: curve, centre: [0.5, 0.5], file: {file}, motion: free}}")
    assert moved.centre == (0.5, 0.5)
    assert moved.shape().area == pytest.approx(math.pi * 0.2**2, rel=1e-5)
    assert "the file names mm" not in moved.traced.described("m")
    assert "the file names mm, its numbers count as m" in body(
        "{type: curve, file: {path: a.csv, scale: 0.01}}"
    ).traced.described("m")
    assert METRES["mm"] == 1e-3


def test_a_thin_shape_has_as_many_points_as_it_needs(tmp_path):
    """Half a ring, 0.04 thick, with round ends: arcs in both directions. A curve that crosses itself is tried again."""
    corners = [(0.4, 0.0, 0, 0, 1), (-0.4, 0.0, 0, 0, 1), (-0.36, 0.0, 0, 0, -1), (0.36, 0.0, 0, 0, 1)]
    dxf(tmp_path / "a.dxf", lambda space: space.add_lwpolyline(corners, close=True))
    path = read(tmp_path / "a.dxf").path(None, closed=True)
    area = 0.5 * math.pi * (0.4**2 - 0.36**2) + math.pi * 0.02**2
    assert Spline(smooth_points(path, "closed", None, Spline)).area == pytest.approx(area, rel=1e-4)
    tried = []

    def shape_of(points):
        tried.append(len(points))
        if len(points) < 100:
            raise ValueError("the curve meets itself")
        return Spline(points)

    assert len(smooth_points(path, "closed", None, shape_of)) == 256
    assert tried == [32, 64, 128, 256]


def test_a_part_of_a_drawing_is_chosen_by_its_name(body, tmp_path):
    rings = "".join(f'<circle id="c{k}" cx=".5" cy=".5" r="{0.1 * k}"/>' for k in (2, 3))
    svg(tmp_path / "a.svg", f'<g id="rings">{rings}</g><circle id="other" cx=".5" cy=".5" r=".25"/>')
    area = math.pi * 0.3**2
    assert body("{type: curve, file: {path: a.svg, part: c3}}").shape().area == pytest.approx(area, rel=1e-5)
    with pytest.raises(ConfigError, match=r"has 2 closed paths.*file\.part: c2, c3"):
        body("{type: curve, file: {path: a.svg, part: rings}}")
    with pytest.raises(ConfigError, match="has no part c4: it has c2, c3, other"):
        body("{type: curve, file: {path: a.svg, part: c4}}")


ENTITY = '<!DOCTYPE svg [<!ENTITY a SYSTEM "file:///etc/passwd">]><svg><text>&a;</text></svg>'
BOMB = '<!DOCTYPE svg [<!ENTITY a "aa"><!ENTITY b "&a;&a;">]><svg><path d="&b;"/></svg>'
CURVE, POLYGON = "type: curve, file", "type: polygon, file"
WRONG = {
    "eight": (CURVE, "a.svg", '<path d="M.2 .2L.8 .8C1 1 1 0 .8 .2L.2 .8C0 1 0 0 .2 .2Z"/>', "meets itself|corner"),
    "bow": (POLYGON, "a.svg", '<polygon points=".2,.2 .8,.8 .8,.2 .3,.8"/>', "meets itself"),
    "open": (CURVE, "a.svg", '<path d="M.2 .2C.4 .9 .9 .9 .8 .2"/>', "is open: 0.6 from end to end"),
    "hole": (POLYGON, "a.svg", '<path d="M.1 .1H.9V.9H.1Z M.4 .4H.6V.6H.4Z"/>', "without holes"),
    "corner": (CURVE, "a.svg", '<rect x=".2" y=".2" width=".5" height=".5"/>', "corner of 90 degrees"),
    "curved": (POLYGON, "a.svg", '<circle cx=".5" cy=".5" r=".2"/>', "has curved parts: give type: curve"),
    "flat": (POLYGON, "a.svg", '<path d="M.2 .2L.5 .5L.8 .8Z"/>', "folds back"),
    "nothing": (CURVE, "a.svg", "<text>a</text>", "has no curves"),
    "infinite": (CURVE, "a.svg", '<path d="M1e999 0L1 1L0 1Z"/>', "no finite number"),
    "bad path": (CURVE, "a.svg", '<path d="M 0 0 C 1"/>', "the path cannot be read"),
    "no XML": (CURVE, "b.svg", "hello", "is no SVG file"),
    "entity": (CURVE, "b.svg", ENTITY, "declares entities"),
    "bomb": (CURVE, "b.svg", BOMB, "declares entities"),
    "huge": (CURVE, "b.svg", " " * (2**20 + 1), "larger than 1 MB"),
    "no DXF": (CURVE, "a.dxf", "hello", "is no DXF file"),
    "two rows": (CURVE, "a.csv", "0,0\n1,1\n", "has 2 points"),
    "NaN": (CURVE, "a.csv", "x,y\n0,0\n1,nan\n1,1\n", "line 3 has a value that is no finite number"),
    "decimal comma": (CURVE, "a.csv", "0,5;0,1\n0,2;0,3\n1;1\n", "line 1 has 4 values"),
    "words": (CURVE, "a.csv", "x,y\n0,0\n1,b\n1,1\n", "line 3 has a value that is no number"),
    "other columns": (CURVE, "a.csv", "a,b\n0,0\n1,1\n1,0\n", "names the columns x and y"),
    "half": (CURVE, "a.csv", "\n".join(f"{x},{y}" for x, y in around(90)[:60]), "the path is open"),
    "other ending": (CURVE, "a.txt", "0,0", r"must end in \.csv, \.svg, \.dxf"),
}
"""What is wrong -> body, file, its content, and words of the message."""


@pytest.mark.parametrize("name", WRONG)
def test_a_shape_that_cannot_be_is_refused_in_one_line(body, tmp_path, name):
    keys, file, content, words = WRONG[name]
    (tmp_path / file).write_text(content) if file != "a.svg" else svg(tmp_path / file, content)
    with pytest.raises(ConfigError, match=words) as refused:
        body(f"{{{keys}: {file}}}")
    (line,) = str(refused.value).splitlines()
    assert "bodies.0.file" in line


@pytest.mark.parametrize("path", ["../a.csv", "/etc/passwd", "b/../../a.csv", "C:/a.csv"])
def test_files_outside_the_folder_are_refused(body, tmp_path, path):
    csv(tmp_path.parent / "a.csv", around(60))
    with pytest.raises(ConfigError, match=r"bodies\.0\.file\.path = .*must be in the folder of the config"):
        body(f"{{type: curve, file: {path}}}")


@pytest.mark.parametrize(
    ("text", "words"),
    [
        ("{type: curve, points: [[0, 0], [1, 0], [1, 1]], file: a.csv}", "give file or points, not both"),
        ("{type: curve, file: b.csv}", "cannot be read: No such file"),
        ("{type: curve, file: {part: a}}", r"bodies\.0\.file\.path: is missing"),
        ("{type: curve, file: {path: a.csv, unit: mm}}", r"units\.length must be one of .*, not L"),
        ("{type: polygon, file: {path: a.csv, smoothing: 0.1}}", "is for smooth curves: give type: curve"),
        ("{type: curve, file: {path: a.csv, start: [0, 0]}}", r"bodies\.0\.file\.start.*unknown key"),
        ("{type: curve, file: 3}", "must be a map of keys, or the path of a file"),
    ],
)
def test_keys_that_do_not_fit_are_refused(body, tmp_path, text, words):
    csv(tmp_path / "a.csv", around(60))
    with pytest.raises(ConfigError, match=words):
        body(text, "units.length=L")


def test_a_drawing_of_very_many_paths_is_refused(tmp_path):
    lines = " ".join(f"M{k} 0V1" for k in range(MOST_PATHS + 1))
    svg(tmp_path / "a.svg", f'<path d="{lines}"/>')
    with pytest.raises(ValueError, match="at most 5000 are read"):
        read(tmp_path / "a.svg").path(None, True)


def traced_stenosis(rng, count=200, pixels=100.0):
    """Places of a wall that narrows from 1 to 0.6, as whole pixels of a picture."""
    x = np.linspace(0.0, 6.0, count)
    y = 1.0 - 0.2 * (1.0 + np.cos(np.pi * np.clip(x - 3.0, -1.0, 1.0)))
    y[3:-3] += rng.uniform(-0.3, 0.3, count - 6) / pixels
    return x, y, np.round(pixels * np.stack([x, y], axis=1))


@pytest.mark.parametrize("ends", [False, True])
def test_a_traced_outline_is_smoothed_within_a_distance(wall, tmp_path, ends):
    """Half a pixel is enough for the throat and for bends ten times wider than those of the trace."""
    x, y, pixels = traced_stenosis(np.random.default_rng(3))
    csv(tmp_path / "wall.csv", pixels)
    opened = ["ends={left: {type: inlet, velocity: 1.0}, right: {type: outlet}}", "drive.acceleration=0.0"]
    changes = opened if ends else []
    file = "{path: wall.csv, scale: 0.01, smoothing: 0.005}"
    config = wall(f"{{smooth: true, file: {file}}}", *changes)
    traced = config.walls.top.traced
    shape = config.walls.top.shape("top", not ends)
    assert traced.deviation <= 0.005
    assert traced.smallest_radius == pytest.approx(shape.smallest_radius, rel=1e-9)
    assert traced.smallest_radius > 0.15
    assert shape.nearest(np.stack([x, y], axis=1)).distance == pytest.approx(0.0, abs=0.01)
    assert shape.height(np.array([3.0]))[0] == pytest.approx(0.6, abs=0.005)
    with pytest.raises(ConfigError, match="a bend of radius"):
        wall("{smooth: true, file: {path: wall.csv, scale: 0.01}}", *changes)


def test_an_outline_may_begin_anywhere_and_lead_to_the_left(wall, tmp_path):
    """Sides of a polyline in an SVG file, whose left end is put to its place."""
    svg(tmp_path / "wall.svg", '<polyline points="700,30 400,30 300,50 100,50"/>', 'viewBox="0 0 800 100"')
    ends = ["ends={left: {type: inlet, velocity: 1.0}, right: {type: outlet}}", "drive.acceleration=0.0"]
    config = wall("{corner_radius: 0.5, file: {path: wall.svg, unit: cm, start: [0.0, 0.8]}}", *ends)
    assert np.array(config.walls.top.outline) == pytest.approx(np.array([[0, 0.8], [2, 0.8], [3, 1], [6, 1]]))


def test_an_outline_may_be_a_spline_of_a_dxf_file(wall, tmp_path):
    places = [(0.0, 1.0), (1.5, 0.95), (3.0, 0.7), (4.5, 0.95), (6.0, 1.0)]
    dxf(tmp_path / "wall.dxf", lambda space: space.add_spline([(x, y, 0) for x, y in places]))
    traced = wall("{smooth: true, file: wall.dxf}", "geometry.gap=1.2").walls.top
    heights = traced.shape("top", True).height(np.array(places)[:, 0])
    assert heights == pytest.approx(np.array(places)[:, 1], abs=2e-3)
    assert traced.traced.deviation < 2e-3


def test_a_closed_path_is_no_outline(wall, tmp_path):
    svg(tmp_path / "wall.svg", '<circle r=".2"/>')
    with pytest.raises(ConfigError, match=r"walls\.top\.file.*is closed: the outline of a wall is open"):
        wall("{smooth: true, file: wall.svg}")


def test_a_vessel_comes_from_a_file(tmp_path):
    svg(tmp_path / "a.svg", '<ellipse cx=".5" cy=".5" rx=".4" ry=".3"/>')
    text = CASE.replace("lattice", "region").replace("geometry: {length: 1.0, height: 1.0}\n", "")
    text = text.replace("bodies: [{type: curve, file: shape.csv}]", "walls: {around: {type: curve, file: a.svg}}")
    text = text.replace("acceleration: 1.0", "acceleration: 0.0")
    (tmp_path / "case.yaml").write_text(text)
    motion = "walls.around.motion={angular_velocity: 1.0}"
    config = load(tmp_path / "case.yaml", [motion])
    assert config.walls.around.shape().area == pytest.approx(math.pi * 0.12, rel=1e-5)
    assert config.walls.around.centre == pytest.approx((0.5, 0.5))


def test_check_says_what_was_read(tmp_path, monkeypatch):
    """Also of a dict, whose files are in the current folder."""
    from tisph.config.yaml_text import parse

    monkeypatch.chdir(tmp_path)
    csv("shape.csv", around(60))
    text = str(tisph.check(parse(CASE).data))
    assert "bodies.0.file          shape.csv: 60 points; smallest radius 0.25 m; at most " in text


def test_a_study_may_have_a_base_with_a_file(tmp_path):
    """Which is in the folder of the study."""
    csv(tmp_path / "shape.csv", around(60))
    base = "".join(f"  {line}\n" for line in CASE.splitlines())
    scales = "vary: {bodies.0.file.scale: [0.9, 1.0]}\n"
    text = base.replace("file: shape.csv", "centre: [0.5, 0.5], file: {path: shape.csv}")
    (tmp_path / "study.yaml").write_text(f"{scales}collect: [drag]\nbase:\n{text}")
    cases = sweep.read(tmp_path / "study.yaml").cases
    points = [np.array(case.config["bodies"][0]["points"]) for case in cases]
    assert points[0] == pytest.approx(0.9 * points[1], abs=1e-12)


def test_rows_of_numbers_need_no_further_package(tmp_path):
    """Without the extra the message about a drawing says how to install it."""
    csv(tmp_path / "shape.csv", around(60))
    svg(tmp_path / "shape.svg", '<circle r=".2"/>')
    (tmp_path / "case.yaml").write_text(CASE)
    program = f"""
import sys
from pathlib import Path
sys.modules["svgpathtools"] = sys.modules["ezdxf"] = None
from tisph.config import load
from tisph.errors import ConfigError
print(load({str(tmp_path / "case.yaml")!r}).bodies[0].traced.points)
for name in ("shape.svg", "shape.dxf"):
    open({str(tmp_path)!r} + "/shape.dxf", "w")
    try:
        load({str(tmp_path / "case.yaml")!r}, ["bodies.0.file=" + name])
    except ConfigError as error:
        print(error)
"""
    done = subprocess.run([sys.executable, "-c", program], capture_output=True, text=True, check=True)
    points, drawn, other = done.stdout.splitlines()
    assert points == "60"
    assert drawn.endswith("needs the package svgpathtools: pip install 'tisph[geometry]'")
    assert other.endswith("needs the package ezdxf: pip install 'tisph[geometry]'")


@pytest.mark.parametrize("name", ["leaf", "stenosis"])
def test_examples_of_the_page_are_valid(name):
    config = load(EXAMPLES / f"{name}.yaml")
    (traced,) = config.at_walls("traced").values()
    assert traced.smallest_radius > 2.0 * config.spacing
