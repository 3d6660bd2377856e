"""Samples in the files of other programs: read back by their readers, or by the format's own words."""

import re
from dataclasses import replace
from pathlib import Path

import h5py
import numpy as np
import pytest
from report_scene import make_snapshot
from typer.testing import CliRunner

import tisph
from tisph import cli, scenes
from tisph.config import load
from tisph.errors import ConfigError
from tisph.observers.samples import Description, Samples, write_snapshot
from tisph.observers.vtk import Vtk
from tisph.results.export import FORMATS, export
from tisph.scenes.channel import Channel
from tisph.simulation.state import start_snapshot, start_values
from tisph.snapshot import Bodies, Snapshot

POLYMER = "fluid.rheology={type: oldroyd_b, relaxation_time: 0.5, solvent_fraction: 0.4}"
TIMES = [0.5, 2.0]
CAVITY = Path(__file__).parents[2] / "configs" / "cavity.yaml"


@pytest.fixture
def run(tmp_path, case):
    """Results of two samples of a liquid with polymer, in centimetres; 12 x 24 particles."""
    config = case("discretisation.particles_across=12", "units={length: cm, mass: g, time: s}", POLYMER)
    channel = Channel.from_config(config)
    (tmp_path / "config.resolved.yaml").write_text(config.resolved_yaml())
    samples = Samples(tmp_path / "samples.h5", channel, TIMES, about=Description(config, channel))
    for t in TIMES:
        samples.observe(make_snapshot(channel, t, slip=1e-3))
    samples.close()
    return tisph.open(tmp_path)


@pytest.mark.parametrize("command", [["report"], ["export", "--to", "csv"]])
@pytest.mark.parametrize("damage", ['{"status": "done"', "[]", "{}", '{"status": "done", "samples": [{"l2": 0.1}]}'])
def test_a_damaged_summary_is_one_error(run, command, damage):
    (run.folder / "summary.json").write_text(damage)
    done = CliRunner().invoke(cli.app, [command[0], str(run.folder), *command[1:]])
    assert (done.exit_code, done.stdout) == (2, "")
    assert done.stderr.startswith(f"error: {run.folder / 'summary.json'}: cannot be read (")
    assert done.stderr.count("\n") == 1


def test_vtk_reads_every_step_with_its_time_and_values(run):
    vtk = pytest.importorskip("vtk", reason="there is no vtk, which the test extra brings")
    from vtk.util.numpy_support import vtk_to_numpy

    reader = vtk.vtkHDFReader()
    reader.SetFileName(str(export(run, "vtkhdf")))
    reader.UpdateInformation()
    times = reader.GetOutputInformation(0).Get(vtk.vtkStreamingDemandDrivenPipeline.TIME_STEPS())
    assert list(times) == TIMES
    for t, sample in zip(times, run.samples, strict=True):
        reader.UpdateTimeStep(t)
        grid = reader.GetOutput()
        assert grid.GetClassName() == "vtkUnstructuredGrid"
        count = len(sample["x"])
        assert [grid.GetCellType(index) for index in range(grid.GetNumberOfCells())] == [vtk.VTK_VERTEX] * count
        cells = vtk_to_numpy(grid.GetCells().GetConnectivityArray())
        assert np.array_equal(cells, np.arange(count))
        points = vtk_to_numpy(grid.GetPoints().GetData())
        assert np.array_equal(points, np.stack([sample["x"], sample["y"], np.zeros(count)], 1))
        data = grid.GetPointData()
        found = {data.GetArrayName(k): vtk_to_numpy(data.GetArray(k)) for k in range(data.GetNumberOfArrays())}
        assert np.array_equal(found["particle"], np.arange(count))
        for name in ("pressure", "density"):
            assert np.array_equal(found[name], sample[name])
        for end in ("", "_exact"):
            assert np.array_equal(found[f"velocity{end}"][:, 0], sample[f"u{end}"])
            xx, _, zz, xy, yz, xz = found[f"stress{end}"].T
            assert np.array_equal([xx, xy], [sample[f"stress_xx{end}"], sample[f"stress_xy{end}"]])
            assert not np.any([zz, yz, xz])
        assert np.array_equal(found["velocity"][:, 1], sample["v"])
        assert np.array_equal(found["stress"][:, 1], sample["stress_yy"])
        texts = [grid.GetFieldData().GetAbstractArray(name).GetValue(0) for name in ("units", "config")]
        assert "velocity [cm/s]" in texts[0]
        assert texts[1] == run.config.resolved_yaml()


def content(path):
    """Every dataset and attribute of an HDF5 file by name."""
    found = {}

    def take(name, item):
        found.update({f"{name}@{key}": np.asarray(value).tolist() for key, value in item.attrs.items()})
        if isinstance(item, h5py.Dataset):
            found[name] = item[...].tolist()

    with h5py.File(path) as file:
        file.visititems(take)
    return found


def test_extxyz_says_what_its_columns_are(run):
    lines = export(run, "extxyz").read_text().splitlines()
    for sample in run.samples:
        count = int(lines[0])
        said, rows = lines[1], [line.split() for line in lines[2 : 2 + count]]
        lines = lines[2 + count :]
        assert f"Time={sample.t}" in said
        assert 'pbc="T F F"' in said
        lattice = [float(value) for value in re.search('Lattice="(.*?)"', said)[1].split()]
        assert lattice == pytest.approx([2.0, 0, 0, 0, 1.0, 0, 0, 0, 1 / 12], rel=1e-15)
        parts = re.search(r"Properties=(\S+)", said)[1].split(":")
        first, columns = 0, {}
        for name, width in zip(parts[::3], map(int, parts[2::3]), strict=True):
            columns[name] = [row[first : first + width] for row in rows]
            first += width
        assert all(len(row) == first for row in rows)
        assert np.array_equal(np.array(columns["pos"], float)[:, 1], sample["y"])
        assert np.array_equal(np.array(columns["velocity"], float)[:, 0], sample["u"])
        assert np.array_equal(np.array(columns["stress"], float)[:, 3], sample["stress_xy"])
    assert lines == []


def test_the_command_writes_beside_the_run_or_where_it_is_told(run, tmp_path):
    folder = str(run.folder)
    for form in FORMATS:
        done = CliRunner().invoke(cli.app, ["export", folder, "--to", form])
        assert (done.exit_code, done.stdout.strip()) == (0, str(tmp_path / f"samples.{form}"))
    done = CliRunner().invoke(cli.app, ["export", folder, "--to", "csv", "--out", str(tmp_path / "mine.csv")])
    assert (tmp_path / "mine.csv").read_text() == (tmp_path / "samples.csv").read_text()
    wrong = CliRunner().invoke(cli.app, ["export", folder, "--to", "gif"])
    assert wrong.exit_code == 2
    assert wrong.stderr == "error: --to gif: must be one of csv, extxyz, npz, vtkhdf\n"


def test_a_file_that_cannot_be_written_or_has_nothing_in_it(run, tmp_path):
    with pytest.raises(tisph.errors.TisphError, match="cannot be written"):
        export(run, "csv", tmp_path / "no_folder" / "a.csv")
    (tmp_path / "samples.h5").unlink()
    with pytest.raises(ConfigError, match="no sample to export"):
        export(tisph.open(tmp_path), "npz")


ROTATING = """
scene: lattice
fluid: {density: 1.0, kinematic_viscosity: 1.0}
geometry: {length: 2.0, height: 1.0}
bodies:
  - {type: polygon, centre: [1.9, 0.5], corners: [[-0.2, -0.1], [0.2, -0.1], [0.2, 0.1], [-0.2, 0.1]],
     corner_radius: 0.09, motion: {velocity: [0.5, 0.0], angular_velocity: 2.0}}
discretisation: {particles_across: 30}
time: {end: 1.0}
"""


@pytest.fixture
def rotating(tmp_path):
    """Results and snapshots of a fluid in rigid rotation around a body that leaves the cell and comes back.

    Its particles have areas of their own, and at the second sample there are three fewer.
    """
    (tmp_path / "case.yaml").write_text(ROTATING)
    config = load(tmp_path / "case.yaml")
    (tmp_path / "config.resolved.yaml").write_text(config.resolved_yaml())
    scene, about = scenes.of(config), Description(config, scenes.of(config))
    x, y = scene.jittered(0, 0.2)
    samples, snapshots = Samples(tmp_path / "samples.h5", scene, TIMES, about=about), []
    live = Vtk(tmp_path / "live.vtkhdf", samples, None, about)
    for step, t in enumerate(TIMES):
        loads, x, y = np.full((2, len(scene.bodies), 4), 3.0), x[3 * step :], y[3 * step :]
        one = {"density": 1.0 + 0 * x, "pressure": 0 * x, "bodies": Bodies.at(t, scene.bodies, loads)}
        one |= {"area": (0.5 + x) / len(x), "passages": np.full(len(x), step)}
        snapshots.append(Snapshot(t=t, step=step, x=x, y=y, u=-3.0 * (y - 0.5), v=3.0 * (x - 1.0), **one))
        samples.observe(snapshots[-1])
        live.observe(snapshots[-1])
    live.close()
    samples.close()
    return tisph.open(tmp_path), snapshots


def test_vtkhdf_has_bodies_where_they_are_and_the_vorticity(rotating):
    run, snapshots = rotating
    path = export(run, "vtkhdf")
    for name in ("", "_bodies"):
        assert content(run.folder / f"samples{name}.vtkhdf") == content(run.folder / f"live{name}.vtkhdf")
    with h5py.File(path) as file, h5py.File(run.folder / "samples_bodies.vtkhdf") as other:
        particles, bodies = file["VTKHDF"], other["VTKHDF"]
        inner = np.hypot(snapshots[0].x - 1.0, snapshots[0].y - 0.5) < 0.25  # the cell is periodic, the rotation not
        assert particles["PointData/vorticity"][: len(inner)][inner] == pytest.approx(6.0)
        assert "vorticity [1/s]" in particles["FieldData/units"][0].decode()
        assert list(bodies["Types"]) == [7, 7]
        assert bodies["CellData/force"][:].tolist() == [[3.0, 3.0, 0.0]] * 2
        assert "torque [kg m/s^2]" in bodies["FieldData/units"][0].decode()
        count = int(bodies["NumberOfPoints"][0])
        for step, t in enumerate(TIMES):
            outline = bodies["Points"][step * count : (step + 1) * count]
            middle = np.array([(1.9 + 0.5 * t) % 2.0, 0.5])
            away = outline[:, :2] - middle
            turned = away @ np.array([[np.cos(2 * t), -np.sin(2 * t)], [np.sin(2 * t), np.cos(2 * t)]])
            assert np.abs(turned).max(axis=0) == pytest.approx([0.2, 0.1], abs=1e-3)


def test_particles_have_areas_and_their_number_may_change(rotating):
    run, snapshots = rotating
    numbers = [len(snapshot.x) for snapshot in snapshots]
    with h5py.File(export(run, "vtkhdf")) as file:
        assert file["VTKHDF/NumberOfPoints"][:].tolist() == numbers
        assert np.array_equal(file["VTKHDF/PointData/area"], np.concatenate([each.area for each in snapshots]))
        assert "area [m^2]" in file["VTKHDF/FieldData/units"][0].decode()
    with np.load(export(run, "npz")) as arrays:
        for step, count in enumerate(numbers):
            assert np.array_equal(arrays["area"][step, :count], snapshots[step].area)
        assert np.isnan(arrays["x"][1, -3:]).all()
        assert arrays["passages"][1, -4:].tolist() == [1, -1, -1, -1]
    rows = [line.split(",") for line in export(run, "csv").read_text().splitlines() if line[0].isdigit()]
    assert [sum(float(row[0]) == t for row in rows) for t in TIMES] == numbers


def test_vtk_reads_bodies_and_frames(rotating):
    vtk = pytest.importorskip("vtk", reason="there is no vtk, which the test extra brings")
    run, snapshots = rotating
    with h5py.File(run.folder / "frames.h5", "w") as frames:
        for number, snapshot in enumerate(snapshots):
            write_snapshot(frames.create_group(f"frame_{number:05d}"), snapshot)
    done = CliRunner().invoke(cli.app, ["export", str(run.folder), "--to", "vtkhdf", "--frames"])
    assert (done.exit_code, done.stdout.strip()) == (0, str(run.folder / "frames.vtkhdf"))
    for name, kind in (("frames", vtk.VTK_VERTEX), ("frames_bodies", vtk.VTK_POLYGON)):
        reader = vtk.vtkHDFReader()
        reader.SetFileName(str(run.folder / f"{name}.vtkhdf"))
        reader.UpdateInformation()
        for t in reader.GetOutputInformation(0).Get(vtk.vtkStreamingDemandDrivenPipeline.TIME_STEPS()):
            reader.UpdateTimeStep(t)
            assert reader.GetOutput().GetCellType(0) == kind
    wrong = CliRunner().invoke(cli.app, ["export", str(run.folder), "--to", "csv", "--frames"])
    assert (wrong.exit_code, wrong.stderr.count("vtkhdf only")) == (2, 1)


def test_every_format_has_temperature_and_dissolved_substances(tmp_path):
    heated = {"conductivity": 1.0, "heat_capacity": 1.0, "unit": "degC", "walls": {"left": 1.0}}
    changes = ["walls.lid.velocity=1.0", f"temperature={heated}", "scalars=[{name: dye, diffusivity: 1.0}]"]
    config = load(CAVITY, [*changes, "discretisation.particles_across=18"])
    scene = scenes.of(config)
    (tmp_path / "config.resolved.yaml").write_text(config.resolved_yaml())
    samples = Samples(tmp_path / "samples.h5", scene, [0.5], about=Description(config, scene))
    start = start_snapshot(scene, start_values(scene, config.initial), "f64")
    carried = {"temperature": start.x**2, "dye": 1.0 - start.y}
    samples.observe(replace(start, t=0.5, substances=carried))
    samples.close()
    run = tisph.open(tmp_path)
    with np.load(export(run, "npz")) as arrays:
        found = {name: arrays[name][0] for name in carried}
    with h5py.File(export(run, "vtkhdf")) as file:
        points = {name: file[f"VTKHDF/PointData/{name}"][:] for name in carried}
        assert "temperature [degC]" in file["VTKHDF/FieldData/units"][0].decode()
    for name, values in carried.items():
        assert np.array_equal(found[name], values), name
        assert np.array_equal(points[name], values), name
    assert export(run, "csv").read_text().splitlines()[2].startswith("t,particle,x,y,density,dye,pressure,temperature")
    assert ":dye:R:1:" in export(run, "extxyz").read_text().splitlines()[1]
    assert list(next(run.snapshots()).substances) == ["dye", "temperature"]
