"""Files as other codes write them, and how they are aligned: the same particles give the same numbers."""

import json
from types import SimpleNamespace

import assessment_case
import h5py
import numpy as np
import pytest
from assessment_case import TIME, exact, loaded
from typer.testing import CliRunner

from tisph import cli
from tisph.assessment import judge, readers
from tisph.assessment.columns import Frame, in_config
from tisph.errors import ConfigError


@pytest.fixture
def config(tmp_path):
    return loaded(tmp_path)


@pytest.fixture(scope="module")
def particles():
    """x, y, u, v and rho of disordered particles whose velocity errs by 2e-3 at the most."""
    random = np.random.default_rng(1)
    x, y = (axis.ravel() for axis in np.meshgrid((np.arange(20) + 0.5) / 20, (np.arange(20) + 0.5) / 20))
    x, y = x + random.uniform(-0.01, 0.01, x.size), y + random.uniform(-0.01, 0.01, x.size)
    u = exact(y) + 2e-3 * np.sin(3 * np.pi * y)
    return {"x": x, "y": y, "u": u, "v": np.zeros_like(u), "rho": np.ones_like(u)}


def l2(particles):
    """The measure of ``tisph bench``."""
    return assessment_case.l2(particles["y"], particles["u"])


def wall_particles(particles):
    """Particles beyond the walls, which no judge may take for the liquid."""
    return {name: np.full(40, -5.0) for name in particles}


def csv(path, particles):
    rows = "\n".join(",".join(map(repr, map(float, row))) for row in zip(*particles.values(), strict=True))
    path.write_text(f"# a comment\n{','.join(particles)}\n{rows}\n")


def tsv(path, particles):
    np.savetxt(path, np.stack(list(particles.values()), axis=1), delimiter="\t", fmt="%.17g")


def npz(path, particles):
    np.savez(path, positions=np.stack([particles["x"], particles["y"]], axis=1), vx=particles["u"], time=TIME)


def pysph_npz(path, particles):
    groups = {"fluid": particles, "walls": wall_particles(particles)}
    described = {name: {"arrays": arrays, "constants": {}, "properties": {}} for name, arrays in groups.items()}
    np.savez(path, version=2, particles=described, solver_data={"t": TIME, "dt": 1e-3, "count": 2700})


def pysph_hdf5(path, particles):
    with h5py.File(path, "w") as file:
        file.create_group("solver_data").attrs["t"] = TIME
        for name, arrays in {"fluid": particles, "walls": wall_particles(particles)}.items():
            for key, values in {**arrays, "V": 400 * arrays["rho"], "au": np.zeros(0)}.items():
                file[f"particles/{name}/arrays/{key}"] = values


def jax_sph(path, particles):
    with h5py.File(path, "w") as file:
        file["r"] = np.stack([particles["x"], particles["y"]], axis=1)
        file["u"] = np.stack([particles["u"], particles["v"]], axis=1)
        file["tag"] = np.zeros(len(particles["x"]), dtype=int)


def lammps(path, particles):
    rows = "".join(
        f"{index} 1 {x!r} {y!r} 0 {u!r} {v!r} H\n"
        for index, (x, y, u, v) in enumerate(zip(*(particles[key].tolist() for key in "xyuv"), strict=True), 1)
    )
    header = "ITEM: TIMESTEP\n{}\nITEM: NUMBER OF ATOMS\n{}\nITEM: BOX BOUNDS pp ff pp\n0 1\n-1 2\n-1 1\n"
    atoms = "ITEM: ATOMS id type x y z vx vy element\n"
    count = len(particles["x"])
    path.write_text(header.format(2700, count) + atoms + rows)


WRITERS = {
    "a.csv": (csv, {}),
    "a.tsv": (tsv, {"columns": ["x=1,y=2,u=3"]}),
    "a.npz": (npz, {}),
    "b.npz": (pysph_npz, {}),
    "a.hdf5": (pysph_hdf5, {}),
    "a.h5": (jax_sph, {}),
    "dump.txt": (lammps, {}),
}
"""Other files of one frame are read in test_readers.py."""


@pytest.mark.parametrize("name", WRITERS)
def test_the_same_particles_are_judged_the_same_whatever_wrote_them(tmp_path, config, particles, name):
    write, settings = WRITERS[name]
    write(tmp_path / name, particles)
    found = judge.judge(config, [tmp_path / name], judge.Question(times=(TIME,), **settings))
    numbers = found.samples[0].numbers
    assert numbers["l2"] == pytest.approx(l2(particles), rel=1e-12)  # rounding of a sum
    assert found.samples[0].scene.rows == 20
    assert numbers["wall_shear_top"] == pytest.approx(numbers["wall_shear_top_exact"], rel=0.1)
    assert numbers["centreline"] == pytest.approx(exact(0.5) - 2e-3, abs=2e-4)  # the fit of a sine of 13 spacings


@pytest.mark.parametrize("kind", ["vtu", "vtp", "vtk", "vtkhdf"])
def test_vtk_files(tmp_path, config, particles, kind):
    pytest.importorskip("vtk", reason="VTK is an extra")
    path = tmp_path / f"a.{kind}"
    write_vtk(path, particles, kind)
    question = judge.Question(times=(TIME,))
    assert judge.judge(config, [path], question).samples[0].numbers["l2"] == pytest.approx(l2(particles), rel=1e-12)


def write_vtk(path, particles, kind):
    from vtkmodules.util.numpy_support import numpy_to_vtk
    from vtkmodules.vtkCommonCore import vtkPoints
    from vtkmodules.vtkCommonDataModel import vtkPolyData, vtkUnstructuredGrid
    from vtkmodules.vtkIOHDF import vtkHDFWriter
    from vtkmodules.vtkIOLegacy import vtkPolyDataWriter
    from vtkmodules.vtkIOXML import vtkXMLPolyDataWriter, vtkXMLUnstructuredGridWriter

    place = vtkPoints()
    place.SetDataTypeToDouble()
    for x, y in zip(particles["x"], particles["y"], strict=True):
        place.InsertNextPoint(x, y, 0.0)
    data = vtkUnstructuredGrid() if kind in ("vtu", "vtkhdf") else vtkPolyData()
    data.SetPoints(place)
    velocity = numpy_to_vtk(np.stack([particles["u"], particles["v"], particles["v"]], axis=1), deep=True)
    velocity.SetName("Velocity")
    data.GetPointData().AddArray(velocity)
    writers = {"vtu": vtkXMLUnstructuredGridWriter, "vtp": vtkXMLPolyDataWriter, "vtk": vtkPolyDataWriter}
    writer = {**writers, "vtkhdf": vtkHDFWriter}[kind]()
    if kind == "vtk":
        writer.SetFileTypeToBinary()  # its text has eleven digits
    writer.SetInputData(data)
    writer.SetFileName(str(path))
    writer.Write()


def test_a_peer_that_gives_heights_and_velocities_only(tmp_path, config, particles):
    np.savetxt(tmp_path / "profile.txt", np.stack([particles["y"], particles["u"]], axis=1), fmt="%.17g")
    question = judge.Question(times=(TIME,), columns=["y=1,u=2"])
    found = judge.judge(config, [tmp_path / "profile.txt"], question).samples[0]
    assert found.numbers["l2"] == pytest.approx(l2(particles), rel=1e-12)
    assert found.scene.rows == 20


def test_a_line_across_the_channel_stands_for_all_of_it(tmp_path, config):
    y = np.linspace(0.0, 1.0, 33)
    csv(tmp_path / "line.csv", {"y": y, "u": 1.01 * exact(y)})
    found = judge.judge(config, [tmp_path / "line.csv"], judge.Question(times=(TIME,))).samples[0]
    assert found.numbers["l2"] == pytest.approx(0.01, rel=1e-9)
    assert found.scene.spacing == pytest.approx(1 / 32)
    assert found.numbers["slope"] == pytest.approx(1.01 * found.numbers["slope_exact"], rel=1e-2)


def test_units(tmp_path, config, particles):
    csv(tmp_path / "cm.csv", {"x": 100 * particles["x"], "y": 100 * particles["y"], "u": 100 * particles["u"]})
    question = judge.Question(times=(TIME,), units=["length=cm"])
    assert judge.judge(config, [tmp_path / "cm.csv"], question).samples[0].numbers["l2"] == pytest.approx(l2(particles))
    csv(tmp_path / "mixed.csv", {"x": 1e3 * particles["x"], "y": 1e3 * particles["y"], "u": particles["u"] / 2})
    question = judge.Question(times=(TIME,), units=["length=mm", "velocity=2"])
    found = judge.judge(config, [tmp_path / "mixed.csv"], question).samples[0]
    assert found.numbers["l2"] == pytest.approx(l2(particles))


def test_a_temperature_keeps_its_unit(tmp_path):
    frame = Frame({"x": np.ones(2), "temperature": np.array([300.0, 310.0])}, units={"temperature": "degC", "x": "cm"})
    found = in_config(frame, None, SimpleNamespace(length="m", mass="kg", time="s"), tmp_path)
    assert found.columns["temperature"].tolist() == [300.0, 310.0]
    assert found.columns["x"].tolist() == [0.01, 0.01]


@pytest.mark.parametrize(
    ("x", "y", "u", "v"),
    [("x", "y-0.5", "u", "v"), ("y", "x", "v", "u"), ("-y", "x", "-v", "u"), ("x+3", "7-y", "u", "v")],
)
def test_axes_and_origin_are_found(tmp_path, config, particles, x, y, u, v):
    turned = [eval(each, {}, particles) for each in (x, y, u, v)]
    csv(tmp_path / "turned.csv", dict(zip(("x", "y", "vx", "vy"), turned, strict=True)))
    found = judge.judge(config, [tmp_path / "turned.csv"], judge.Question(times=(TIME,))).samples[0]
    # particles up to 0.2 spacings off the lattice put the middle between the outermost up to 0.01 off that of the walls
    assert found.numbers["l2"] < 0.1
    assert found.aligned.notes

    turned = {"x": 4 - particles["y"], "y": particles["x"], "u": particles["v"], "v": particles["u"]}
    csv(tmp_path / "turned.csv", turned)
    question = judge.Question(times=(TIME,), orientation="y,-x", origin=(4.0, 0.0))
    found = judge.judge(config, [tmp_path / "turned.csv"], question).samples[0]
    assert found.numbers["l2"] == pytest.approx(l2(particles), rel=1e-9)


def test_an_origin_that_is_slightly_off_is_not_hidden(tmp_path, config):
    y = (np.arange(20) + 0.5) / 20
    csv(tmp_path / "shifted.csv", {"y": y + 0.025, "u": exact(y)})
    found = judge.judge(config, [tmp_path / "shifted.csv"], judge.Question(times=(TIME,)))
    assert found.samples[0].aligned.notes == ()
    assert "shift" in {each.fault.name for each in found.diagnoses["20 across"].explaining}


def test_order_of_several_resolutions_and_the_way_of_the_error_in_time(tmp_path, config):
    for number in (10, 20, 40):
        y = (np.arange(number) + 0.5) / number
        csv(tmp_path / f"{number}.csv", {"y": y, "u": exact(y) * (1 + 1.0 / number**2)})
    files = [tmp_path / f"{number}.csv" for number in (10, 20, 40)]
    found = judge.judge(config, files, judge.Question(times=(TIME,)))
    assert found.orders[TIME] == pytest.approx(2.0, abs=1e-6)

    y = (np.arange(20) + 0.5) / 20
    for t, error in ((1.8, 0.02), (2.7, 0.04)):
        own = exact(y, t)
        csv(tmp_path / f"at_{t}.csv", {"y": y, "u": own * (1 + error)})
    question = judge.Question(times=(1.8, 2.7))
    found = judge.judge(config, [tmp_path / "at_1.8.csv", tmp_path / "at_2.7.csv"], question)
    assert "grows" in found.trends[0]
    assert found.samples[1].location["words"].startswith("near the top wall")


@pytest.mark.parametrize("factor", [1000.0, -1.0])
def test_particles_with_another_unit_or_sign_are_said_to_have_it(tmp_path, config, particles, factor):
    csv(tmp_path / "a.csv", {**particles, "u": factor * particles["u"]})
    found = judge.judge(config, [tmp_path / "a.csv"], judge.Question(times=(TIME,)))
    said = [each.words for each in found.diagnoses["20 across"].explaining] + list(found.samples[0].aligned.notes)
    assert any(("mm/s" if factor > 0 else "wrong sign") in each for each in said)
    assert len(said) == 1


def test_an_error_of_round_off_has_no_place(tmp_path, config):
    y = (np.arange(40) + 0.5) / 40
    for t in (1.8, 2.7):
        csv(tmp_path / f"{t}.csv", {"y": y, "u": exact(y, t) * (1 + 1e-9 * y)})
    found = judge.judge(config, [tmp_path / "1.8.csv", tmp_path / "2.7.csv"], judge.Question(times=(1.8, 2.7)))
    text = judge.text(found, "case")
    assert "t = 2.7, 40 across: error as small as that of the reference, or round-off" in text
    assert "wall (y" not in text
    assert "from t = 1.8" not in text


@pytest.mark.parametrize(
    ("content", "settings", "says"),
    [
        ("y,u\n", {}, "no line of numbers"),
        ("y,u\n0.5,1\n0.6\n", {}, "line 3 is no row of numbers"),
        ("a,b\n0.5,1\n", {}, "no column is recognised as y or u"),
        ("y,u\n0.5,1\n", {"columns": ["y=height"]}, "no column height"),
        ("y,u\n0.5,1\n", {"columns": ["height=1"]}, "the quantities are"),
        ("y,u\n0.5,1\n", {}, "fewer than five points"),
        ("y,u\n" + "".join(f"{y},1\n" for y in range(50)), {}, "do not fit between the walls"),
        ("y,u\n" + "".join(f"{y / 9},1\n" for y in range(9)), {"units": ["length=parsec"]}, "parsec is not known"),
        ("y,u\n" + "".join(f"{y / 9},1\n" for y in range(9)), {"orientation": "x,x"}, "must be one of"),
    ],
)
def test_bad_input_is_one_message(tmp_path, config, content, settings, says):
    (tmp_path / "bad.csv").write_text(content)
    with pytest.raises(ConfigError, match=says):
        judge.judge(config, [tmp_path / "bad.csv"], judge.Question(times=(TIME,), **settings))


def test_data_of_no_time(tmp_path, config, particles):
    csv(tmp_path / "a.csv", particles)
    with pytest.raises(ConfigError, match="give --time"):
        judge.judge(config, [tmp_path / "a.csv"], judge.Question())


def test_an_archive_runs_no_program(tmp_path):
    class Evil:
        def __reduce__(self):
            return (open, (str(tmp_path / "made"), "w"))

    np.savez(tmp_path / "evil.npz", particles=np.array(Evil(), dtype=object))
    with pytest.raises(ConfigError, match="is not read"):
        readers.frames(tmp_path / "evil.npz")
    assert not (tmp_path / "made").exists()


def test_the_command_prints_stores_and_holds_to_a_bound(tmp_path, monkeypatch, config, particles):
    monkeypatch.chdir(tmp_path)
    csv(tmp_path / "result.csv", {**particles, "u": 1.04 * exact(particles["y"])})
    call = ["compare", "result.csv", "--config", "case.yaml", "--time", "2.7", "--bound"]
    done = CliRunner().invoke(cli.app, [*call, "0.05"])
    assert done.exit_code == 0, done.stderr
    assert "4.000e-02" in done.stdout
    assert "blind" in done.stdout
    assert "the walls move 4 % faster" in done.stdout
    stored = json.loads((tmp_path / "runs/compare-result/comparison.json").read_text())
    assert stored["samples"][0]["l2"] == pytest.approx(0.04)
    assert stored["diagnoses"]["20 across"]["explained_by"] == ["factor", "slip"]
    assert (tmp_path / "runs/compare-result/comparison.png").stat().st_size > 10_000
    assert CliRunner().invoke(cli.app, [*call, "0.03"]).exit_code == 1
    assert CliRunner().invoke(cli.app, [*call[:-1], "--unit", "length=yard"]).exit_code == 2
