"""Files, times, texts, units and planes as people and other codes write them: read rightly, or refused."""

import json
from pathlib import Path
from types import SimpleNamespace

import h5py
import numpy as np
import pytest
from assessment_case import TIME, exact, l2, loaded

from tisph.assessment import judge, readers
from tisph.errors import ConfigError

Y = (np.arange(20) + 0.5) / 20
TIMES = (0.9, 1.8, 2.7)
DIGITS = 1e-11
"""Largest L2 error that twelve digits of the velocity leave."""


@pytest.fixture
def errors(tmp_path, monkeypatch):
    """Function of file and settings: L2 errors by time, and the notes; nothing is diagnosed, which takes longer."""
    config = loaded(tmp_path)
    monkeypatch.setattr(judge.diagnosis, "diagnose", lambda _: SimpleNamespace(explaining=("none",)))

    def judged(name, content=None, times=(), **settings):
        if content is not None:
            (tmp_path / name).write_bytes(content if isinstance(content, bytes) else content.encode())
        found = judge.judge(config, [tmp_path / name], judge.Question(times=times, **settings)).samples
        return {each.numbers["t"]: each.numbers["l2"] for each in found}, [each.aligned.notes for each in found]

    return judged


def table(header, separator, columns, point=".", row="{}"):
    """Text of a table of ``columns``, with twelve digits and this decimal ``point``."""
    cells = [[row.format(f"{value:.12e}".replace(".", point)) for value in line] for line in np.stack(columns, axis=1)]
    return "\n".join([header, *(separator.join(line) for line in cells)]) + "\n"


PROFILE = [Y, exact(Y)]
FLAT = np.zeros(20)
DUALSPHYSICS = "Pos.x [m];Pos.y [m];Pos.z [m];Vel.x [m/s];Vel.y [m/s]"
TEXTS = {
    "tabs": (table("y\tu", "\t", PROFILE, ","), {}),
    "blanks": (table("# y u", "  ", PROFILE, ","), {}),
    "quotes": (table('"y","u"', ",", PROFILE, ",", '"{}"'), {}),
    "semicolons": (b"\xef\xbb\xbf" + table("y;u", ";", PROFILE, ",").replace("\n", "\r\n").encode(), {}),
    "utf16": (table("y;u", ";", PROFILE, ",").encode("utf-16"), {}),
    "cp1252": ("# Meßreihe, 20 °C\n" + table("y;u", ";", PROFILE, ",")).encode("cp1252"),
    "double_spaced": (table("y,u", ",", PROFILE).replace("\n", "\r\r\n"), {}),
    "fortran": (table("", "  ", PROFILE).replace("e", "D"), {"columns": ["y=1,u=2"]}),
    "savetxt": (table("# y, u", " ", PROFILE), {}),
    "blanks_in_names": (table("Pos y;Vel x", ";", PROFILE), {}),
    "units": (table("y [mm],u [cm/s]", ",", [1e3 * Y, 100 * exact(Y)]), {}),
    "units_in_parentheses": (table('"y (mm)"  "u (m s^-1)"', " ", [1e3 * Y, exact(Y)]), {}),
    "units_beside_blanks": (table("# y [mm] u [m·s⁻¹]", " ", [1e3 * Y, exact(Y)]), {}),
    "units_below": (table("y;u\nmm;mm/s", ";", [1e3 * Y, 1e3 * exact(Y)]), {}),
    "units_of_the_option": (table("y [km],u [m/s]", ",", [1e3 * Y, exact(Y)]), {"units": ["length=mm", "velocity=1"]}),
    "no_unit": (table("y [-],u [-]", ",", PROFILE), {}),
    "dualsphysics": (table(DUALSPHYSICS, ";", [Y, FLAT, Y, exact(Y), FLAT]), {}),
    "paraview": (table('"U_0","U_1","Points_0","Points_1","Points_2"', ",", [exact(Y), FLAT, Y, Y, FLAT]), {}),
    "paraview_before": (table('"U:0","U:1","Points:0","Points:1","Points:2"', ",", [exact(Y), FLAT, Y, Y, FLAT]), {}),
    "fluent": (table("nodenumber,x-coordinate,y-coordinate,x-velocity", ",", [20 * Y, Y, Y, exact(Y)]), {}),
    "star": (table('"X (m)","Y (m)","Velocity[i] (m/s)"', ",", [Y, Y, exact(Y)]), {}),
    "temperature": (table("T,y,u", ",", [300 + Y, *PROFILE]), {}),
}
TEXTS["cp1252"] = (TEXTS["cp1252"], {})


@pytest.mark.parametrize("name", TEXTS)
def test_texts_as_people_write_them(errors, name):
    content, settings = TEXTS[name]
    found, notes = errors(f"{name}.csv", content, (TIME,), **settings)
    assert found[TIME] < DIGITS
    if name.startswith("units"):
        assert "y is in" in notes[0][0]


def test_a_velocity_without_a_unit_beside_heights_that_have_one_is_said(errors):
    found, notes = errors("half.csv", table("y [mm],u", ",", [1e3 * Y, exact(Y)]), (TIME,))
    assert found[TIME] < DIGITS
    assert "u, without a unit in the file, is taken to be in that of the config" in notes[0]


def test_cross_sections_keep_the_velocity_along_the_flow(errors):
    content = table("x,y,z,vx,vy,vz", ",", [FLAT, Y, Y[::-1] ** 2, exact(Y), FLAT, FLAT])
    found, notes = errors("slice.csv", content, (TIME,))
    assert found[TIME] < DIGITS
    assert "z varies, too" in notes[0][0]


@pytest.mark.parametrize(
    ("content", "settings", "says"),
    [
        (table("y [furlong],u [m/s]", ",", PROFILE), {}, "furlong is not known"),
        (table("y [s],u [m/s]", ",", PROFILE), {}, "is no unit of length"),
        (table("y;u", ";", PROFILE, ",") + "1.5;0,5\n", {}, "some numbers have a decimal point, others a comma"),
        (table("y;u\n1.234,5;0", ";", PROFILE, ","), {}, "line 2 is no row of numbers"),
        (table("y,u", ",", PROFILE) + "0.5,n/a\n", {}, "line 22 is no row of numbers"),
        (table("y,u,y,u", ",", PROFILE + PROFILE), {}, "no column is recognised as y or u"),
        (table("y,u", ",", PROFILE), {"times": (1.8, TIME)}, "does not say of which time it is; give --time once"),
        (table("t,y,u", ",", [FLAT + 1.8, *PROFILE]), {}, "has no data of t = 2.7; it has 1.8"),
        (table("# t = 1.8\nt,y,u", ",", [FLAT + TIME, *PROFILE]), {}, "says t = 1.8, but its column of times has 2.7"),
        (table("t,y,u", ",", [np.where(Y < 0.5, np.nan, TIME), *PROFILE]), {}, "has points without a time"),
    ],
)
def test_texts_that_could_be_misread_are_refused(errors, content, settings, says):
    with pytest.raises(ConfigError, match=says):
        errors("bad.csv", content, **{"times": (TIME, 2 * TIME) if "no data" in says else (TIME,), **settings})


def profiles():
    """Heights and velocities of all times, (times, points)."""
    return np.stack([Y] * 3), np.stack([exact(Y, t) for t in TIMES])


def blocks(before, header="y,u"):
    """Text with a block a time, after the line ``before``, with the time in place of ``{}``."""
    return "\n".join(table(before.format(t) + header, ",", [Y, exact(Y, t)]) for t in TIMES)


def groups(path, **arrays):
    with h5py.File(path, "w") as file:
        for name, array in arrays.items():
            file[name] = array


def chunks(rows):
    """Profiles of LAMMPS' ``fix ave/chunk``, the last chunk without atoms."""
    text = "# Chunk-averaged data for fix vprof and group fluid\n# Timestep Number-of-chunks Total-count\n"
    text += "# Chunk Coord1 Ncount vx\n"
    for t in TIMES:
        text += f"{1e4 * t:.0f} 21 800\n" + "".join(f"  {i} {y} 40 {u!r}\n" for i, (y, u) in enumerate(rows(t), 1))
        text += "  21 1.025 0 0\n"
    return text


def dump(rows):
    text = "ITEM: TIMESTEP\n{:.0f}\nITEM: NUMBER OF ATOMS\n20\nITEM: BOX BOUNDS pp ff pp\n0 1\n0 1\n0 1\n"
    text += "ITEM: ATOMS id type y vx\n"
    parts = [text.format(1e4 * t) + "".join(f"{i} 1 {y} {u!r}\n" for i, (y, u) in enumerate(rows(t))) for t in TIMES]
    return "".join(parts)


def rows(t):
    return [(float(y), float(u)) for y, u in zip(Y, exact(Y, t), strict=True)]


def xyz(about):
    parts = [
        f"20\n{about.format(t)}Properties=species:S:1:pos:R:3:velo:R:3\n"
        + "".join(f"X 0.0 {y} 0.0 {u!r} 0.0 0.0\n" for y, u in rows(t))
        for t in TIMES
    ]
    return "".join(parts)


LONG = [np.repeat(TIMES, 20), np.tile(Y, 3), np.concatenate([exact(Y, t) for t in TIMES])]
RECORDS = [{"t": float(t), "y": float(y), "u": float(u)} for t, y, u in zip(*LONG, strict=True)]

WITH_TIMES = {
    "column.csv": table("t,y,u", ",", LONG),
    "column_of_units.csv": table("Time [ms],y,u", ",", [1e3 * LONG[0], *LONG[1:]]),
    "numbered.txt": table("", " ", LONG),
    "blocks.csv": blocks("# t = {}\n"),
    "blocks_of_units.csv": blocks("# time: {}e3 ms\n"),
    "records.json": json.dumps(RECORDS),
    "sets.json": json.dumps([{"time": t, "y": Y.tolist(), "u": exact(Y, t).tolist()} for t in TIMES]),
    "a.npz": lambda path: np.savez(path, time=TIMES, y=Y, u=profiles()[1]),
    "b.npz": lambda path: np.savez(path, t=TIMES, step=[1, 2, 3], r=np.stack([profiles()[0]] * 2, 2), u=profiles()[1]),
    "long.npz": lambda path: np.savez(path, t=LONG[0], y=LONG[1], u=LONG[2]),
    "a.h5": lambda path: groups(path, t=TIMES, y=Y, u=profiles()[1]),
    "a.xyz": xyz('Lattice="1 0 0 0 1 0 0 0 1" Time={} '),
}

WITHOUT_TIMES = {
    "blank_lines.csv": blocks(""),
    "headers.csv": blocks("").replace("\n\n", "\n"),
    "steps.csv": table("step,y,u", ",", [1e4 * LONG[0], *LONG[1:]]),
    "a.dump": dump(rows),
    "chunks.dat": chunks(rows),
    "a.npz": lambda path: np.savez(path, y=Y, u=profiles()[1]),
    "a.json": json.dumps({"y": Y.tolist(), "u": profiles()[1].tolist()}),
    "a.xyz": xyz(""),
}


def written(folder, name, content):
    """The content of a file, None where a function has written it."""
    return content(folder / name) if callable(content) else content


@pytest.mark.parametrize("name", WITH_TIMES)
def test_every_time_of_a_file_is_a_profile_of_its_own(errors, tmp_path, name):
    settings = {"columns": ["time=1,y=2,u=3"]} if name == "numbered.txt" else {}
    found, _ = errors(name, written(tmp_path, name, WITH_TIMES[name]), **settings)
    assert list(found) == pytest.approx(TIMES)
    assert max(found.values()) < DIGITS
    assert errors(name, None, (1.8,), **settings)[0][1.8] < DIGITS
    with pytest.raises(ConfigError, match=r"has no data of t = 2; it has 0.9, 1.8, 2.7"):
        errors(name, None, (2.0,), **settings)


@pytest.mark.parametrize("x", [[], [np.tile(Y, 3)]])
def test_times_that_are_not_recognised_are_suspected(errors, x):
    content = table("Zeit,x,y,u" if x else "Zeit,y,u", ",", [LONG[0], *x, *LONG[1:]])
    assert "data of several times need --columns time=NAME" in errors("a.csv", content, (TIME,))[1][0][0]
    found, notes = errors("a.csv", None, columns=["time=Zeit"])
    assert max(found.values()) < DIGITS
    assert notes == [()] * 3


@pytest.mark.parametrize("name", WITHOUT_TIMES)
def test_frames_without_times_are_paired_in_order_or_listed(errors, tmp_path, name):
    found, _ = errors(name, written(tmp_path, name, WITHOUT_TIMES[name]), TIMES)
    assert tuple(found) == TIMES
    assert max(found.values()) < DIGITS
    for times in ((), (TIME,), (1.8, TIME)):
        with pytest.raises(ConfigError, match=r"has 3 frames without times, \w+ .*give --time for each, in order"):
            errors(name, None, times)


@pytest.mark.parametrize("name", ["a.dump", "chunks.dat", "a.xyz"])
def test_files_that_end_in_the_middle_of_a_frame_are_refused(errors, name):
    with pytest.raises(ConfigError, match=r"is damaged|is no extended XYZ"):
        errors(name, WITHOUT_TIMES[name].rstrip().rpartition("\n")[0], TIMES)
    with pytest.raises(ConfigError):
        errors(name, "", TIMES)


@pytest.mark.parametrize(
    "arrays",
    [
        {"t": TIMES, "y": Y, "u": profiles()[1].T},
        {"t": TIME, "y": profiles()[0], "u": profiles()[1]},
        {"t": np.arange(20.0), "y": Y, "u": np.ones((20, 20))},
    ],
)
def test_arrays_of_which_no_index_is_the_time_are_refused(errors, tmp_path, arrays):
    np.savez(tmp_path / "a.npz", **arrays)
    with pytest.raises(ConfigError, match="which index is the time"):
        errors("a.npz", None, (TIME,))


def test_quantities_of_each_point_are_no_times(errors, tmp_path):
    np.savez(tmp_path / "a.npz", t=TIME, y=Y, u=exact(Y), stress=np.ones((20, 6)), gradient=np.ones((20, 3, 3)))
    assert errors("a.npz")[0][TIME] < DIGITS


CELLS = """# vtk DataFile Version 3.0
channel
ASCII
DATASET RECTILINEAR_GRID
{}DIMENSIONS 3 {} {}
X_COORDINATES 3 double
0 0.5 1
Y_COORDINATES {}
Z_COORDINATES {}
CELL_DATA 40
VECTORS U double
{}POINT_DATA 63
SCALARS U double 1
LOOKUP_TABLE default
{}"""


def cells(plane, field=""):
    """Text of a legacy file with data of cells, and misleading ones of its points, in the plane ``xy`` or ``xz``."""
    walls, single = "21 double\n" + " ".join(f"{y}" for y in np.arange(21) / 20), "1 double\n0"
    across = (21, 1, walls, single) if plane == "xy" else (1, 21, single, walls)
    velocity = "".join(f"{u!r} 0 0\n" * 2 for u in exact(Y).tolist())
    return CELLS.format(field, *across, velocity, "9\n" * 63)


@pytest.mark.parametrize("plane", ["xy", "xz"])
@pytest.mark.parametrize("name", ["TIME", "time", "TimeValue", None])
def test_cells_of_vtk(errors, plane, name):
    pytest.importorskip("vtk", reason="VTK is an extra")
    field = f"FIELD FieldData 1\n{name} 1 1 double\n{TIME}\n" if name else ""
    found, notes = errors("cells.vtk", cells(plane, field), () if name else (TIME,))
    assert found[TIME] < DIGITS
    assert "at the cell centres" in notes[0][0]
    assert not any("the file says t" in note for note in notes[0])


def test_collections_of_vtk(errors, tmp_path):
    pytest.importorskip("vtk", reason="VTK is an extra")
    (tmp_path / "fluid.vtk").write_text(cells("xy"))
    entry = '<DataSet timestep="{}" part="{}" file="{}"/>'
    text = '<VTKFile type="Collection"><Collection>{}</Collection></VTKFile>'
    one = entry.format(0, 0, "fluid.vtk") + entry.format(TIME, 0, "fluid.vtk")
    found, _ = errors("a.pvd", text.format(one))
    assert found[TIME] < DIGITS
    both = one + entry.format(TIME, 1, "walls.vtk")
    with pytest.raises(ConfigError, match="which particles are the fluid"):
        errors("a.pvd", text.format(both))
    assert errors("a.pvd", None, select="0")[0][TIME] < DIGITS
    with pytest.raises(ConfigError, match="is no collection of VTK files"):
        errors("b.pvd", "<a")


LAMMPS = Path(__file__).parent / "data/lammps_couette.dump"
"""Written by LAMMPS (22 Jul 2025, Update 4), liquid and walls:
``benchmarks/peers/lammps_couette.py --across 20 --steps 1188 --end 2.7 --threads 1 --dump lammps_couette.dump``."""

PYSPH = Path(__file__).parent / "data/pysph_couette.npz"
"""Written by PySPH (1.0b2), in the same way: ``pysph_couette.py --across 20 --steps 1188 --end 2.7 --dump FILE``."""

LAMMPS_BENCH, PYSPH_BENCH = 1.465e-01, 8.440e-03
"""What ``tisph bench`` measures of these runs: ``measure.py --code CODE --threads 1 --across 20 --until 2.7``."""

PRINTED = 5e-4
"""The numbers above are printed to four digits."""


@pytest.fixture
def config(tmp_path):
    return loaded(tmp_path)


def lammps_l2(t, rows):
    """``l2`` from the lines of a time, of atoms of type 1, by columns as the file has them."""
    kind, y, u = np.loadtxt(rows, usecols=(1, 3, 4), unpack=True)
    return l2(y[kind == 1], u[kind == 1], t)


def test_a_dump_of_lammps_is_judged_as_the_bench_judges_the_run(config):
    lines = LAMMPS.read_text().splitlines()
    starts = [index + 1 for index, line in enumerate(lines) if line.startswith("ITEM: ATOMS id type x y vx vy")]
    found = judge.judge(config, [LAMMPS], judge.Question(select="1")).samples
    assert [each.numbers["t"] for each in found] == pytest.approx([0.9, 1.8, 2.7], rel=1e-12)
    for each, start in zip(found, starts, strict=True):
        assert len(each.aligned.snapshot.u) == 800
        assert each.aligned.notes == ()
        own = lammps_l2(each.numbers["t"], lines[start : start + 1040])
        assert each.numbers["l2"] == pytest.approx(own, rel=1e-9)  # sums in another order
    assert found[-1].numbers["l2"] == pytest.approx(LAMMPS_BENCH, rel=PRINTED)


def test_a_file_of_pysph_is_judged_as_the_bench_judges_the_run(config):
    (found,) = judge.judge(config, [PYSPH], judge.Question()).samples
    assert found.numbers["t"] == pytest.approx(TIME, rel=1e-12)
    assert len(found.aligned.snapshot.u) == 800
    assert found.numbers["l2"] == pytest.approx(PYSPH_BENCH, rel=PRINTED)
    (frame,) = readers.frames(PYSPH)
    # sums in another order
    assert found.numbers["l2"] == pytest.approx(l2(frame.columns["y"], frame.columns["u"]), rel=1e-9)


def test_walls_of_lammps_that_do_not_hold_the_fluid_are_found(config):
    """Its SPH package extrapolates no velocity into the walls."""
    found = judge.judge(config, [LAMMPS], judge.Question(times=(1.8, 2.7), select="1"))
    (diagnosis,) = found.diagnoses.values()
    assert "top_wall" in {each.fault.name for each in diagnosis.explaining}
    assert "outside the fluid" in diagnosis.explaining[0].words


@pytest.mark.parametrize(("select", "says"), [(None, "which types are the fluid"), ("4", "no atoms of type 4")])
def test_a_dump_with_several_types_needs_a_choice_of_the_fluid(config, select, says):
    with pytest.raises(ConfigError, match=says):
        judge.judge(config, [LAMMPS], judge.Question(select=select))
