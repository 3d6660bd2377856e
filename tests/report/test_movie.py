"""Movies: frames, encoder, the frame of the flow, and both halves of a cut through the axis."""

from dataclasses import replace
from pathlib import Path
from types import SimpleNamespace

import imageio_ffmpeg
import matplotlib
import numpy as np
import pytest
from report_scene import END, VIDEO, Drawn, make_channel, make_snapshot, make_video, particles

from tisph import config, scenes
from tisph.errors import TisphError
from tisph.report import style
from tisph.report.encoder import Encoder
from tisph.report.layout import arrange
from tisph.report.movie import FullCut, Movie
from tisph.report.overlays import Streamlines
from tisph.simulation.state import start_snapshot, start_values

TIMES = (0.0, 1.0, 2.0, 5.0, 10.0, 20.0)


@pytest.fixture(scope="module")
def film(tmp_path_factory):
    """A finished movie."""
    channel, path = make_channel(), tmp_path_factory.mktemp("movie") / "movie.mp4"
    with Movie(path, channel, VIDEO, "test", END) as movie:
        for t in TIMES:
            movie.add(make_snapshot(channel, t))
    return path


def read(path):
    """Metadata and frames, uint8 of shape (frames, height, width, 3)."""
    reader = imageio_ffmpeg.read_frames(str(path))
    metadata = next(reader)
    width, height = metadata["size"]
    return metadata, np.array([np.frombuffer(frame, np.uint8).reshape(height, width, 3) for frame in reader])


def test_movie_is_h264_yuv420p_of_the_size_and_rate_asked_for(film):
    metadata, frames = read(film)
    assert (metadata["codec"], metadata["pix_fmt"][:7]) == ("h264", "yuv420p")
    assert (metadata["size"], metadata["fps"]) == ((VIDEO.width, VIDEO.height), VIDEO.fps)
    assert len(frames) == len(TIMES)


def test_interrupted_movie_keeps_the_frames_it_had(tmp_path):
    path, channel = tmp_path / "movie.mp4", make_channel()
    movie = Movie(path, channel, VIDEO, "test", END)

    def run():
        with movie:
            for t in TIMES:
                movie.add(make_snapshot(channel, t))
                if t == 2.0:
                    # Half a frame is in the pipe when Ctrl-C arrives.
                    movie._encoder._process.stdin.write(bytes(VIDEO.width * VIDEO.height))
                    raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        run()
    assert len(read(path)[1]) == 3


def test_missing_ffmpeg_is_one_clear_message(tmp_path, monkeypatch):
    def missing():
        raise RuntimeError("No ffmpeg exe could be found")

    monkeypatch.setattr("tisph.report.encoder.get_ffmpeg_exe", missing)
    with pytest.raises(TisphError, match=r"movie\.mp4: ffmpeg could not be started.*No ffmpeg exe"):
        Encoder(tmp_path / "movie.mp4", 320, 240, 30)


@pytest.mark.skipif(not Path("/dev/full").exists(), reason="needs a device that is full")
def test_a_full_disk_is_one_line_and_leaves_the_old_movie(tmp_path):
    path = tmp_path / "movie.mp4"
    path.write_bytes(b"old")
    (tmp_path / "movie.mp4.partial").symlink_to("/dev/full")
    encoder = Encoder(path, 320, 240, 30)
    encoder.write(np.zeros((240, 320, 4), dtype=np.uint8))
    with pytest.raises(TisphError, match=r"^[^\n]*movie.mp4: ffmpeg stopped [^\n]*No space left on device$"):
        encoder.close()
    assert [each.name for each in tmp_path.iterdir()] == ["movie.mp4"]
    assert path.read_bytes() == b"old"


def test_error_of_the_run_is_not_hidden_by_a_broken_movie(tmp_path):
    movie = Movie(tmp_path / "no_such_folder" / "movie.mp4", make_channel(), VIDEO, "test", END)
    movie.add(make_snapshot(make_channel(), 1.0))
    with pytest.raises(ZeroDivisionError), movie:
        raise ZeroDivisionError


WIDTH, HEIGHT = 960, 480
WIDE = make_video(WIDTH, HEIGHT)
LINEAR = {"initial_state": "developed"}


@pytest.fixture(scope="module")
def renderer():
    return Drawn(make_channel(**LINEAR), WIDE, "test", END)


def pixel(renderer, x, y):
    """Row and column in the frame of a place in the channel."""
    rect, scale = renderer.layout.box, renderer.layout.pixels_per_length
    return rect.top + int((renderer.scene.gap - y) * scale), rect.left + int(x * scale)


def test_a_disc_is_at_its_particle_and_the_rest_is_white(renderer):
    x, y = 0.0137, 0.0031
    frame = renderer.render(particles(renderer.scene, 1.0, [x], [y], [0.0]))
    ink = 255.0 - frame[renderer.layout.box.slices][:, :, 0]
    rows, columns = np.mgrid[: ink.shape[0], : ink.shape[1]] + 0.5
    scale = renderer.layout.pixels_per_length
    # Rim sampling as in the raster tests, and bytes: a twentieth of a pixel.
    assert (ink * columns).sum() / ink.sum() == pytest.approx(x * scale, abs=0.05)
    assert (ink * rows).sum() / ink.sum() == pytest.approx((renderer.scene.gap - y) * scale, abs=0.05)
    assert np.count_nonzero(ink) < 4 * (2 * renderer.disc_radius + 2) ** 2


def test_exact_curve_and_dots_stand_at_their_velocity(renderer):
    channel, rect = renderer.scene, renderer.layout.profile
    lowest, highest = renderer.quantity.profile_range
    shift = 0.5
    frame = renderer.render(make_snapshot(channel, 1.0, slip=shift)).astype(float)
    red = 255 * np.array(matplotlib.colors.to_rgb(style.EXACT))
    blue = 255 * np.array(matplotlib.colors.to_rgb(style.PARTICLES))
    row = rect.top + int((1 - 3.5 / channel.rows) * rect.height)  # through the fourth row of particles
    u = channel.exact_velocity(channel.gap * 3.5 / channel.rows, 1.0)
    for colour, velocity in ((red, u), (blue, u + shift * channel.reference_velocity)):
        distance = np.abs(frame[row, rect.left + 1 : rect.right - 1] - colour).max(axis=1)
        columns = np.flatnonzero(distance < 40)  # the core of line or dot, not its soft rim
        expected = (velocity - lowest) / (highest - lowest) * rect.width
        assert columns.mean() + 1.5 == pytest.approx(expected, abs=1.0)  # a pixel


def test_a_periodic_edge_shows_both_parts_of_a_disc(renderer):
    frame = renderer.render(particles(renderer.scene, 1.0, [0.0], [0.005], [0.0]))
    panel = frame[renderer.layout.box.slices]
    middle = panel.shape[0] // 2
    assert panel[middle, 0, 0] < 100
    assert panel[middle, -1, 0] < 100
    long = Drawn(make_channel(length=0.1), WIDE, "test", END)
    panel = long.render(particles(long.scene, 1.0, [0.0], [0.005], [0.0]))[long.layout.box.slices]
    assert panel[panel.shape[0] // 2, 0, 0] < 100
    assert panel[panel.shape[0] // 2, -1, 0] == 255


def test_user_settings_of_matplotlib_do_not_reach_the_picture(renderer):
    with matplotlib.rc_context({"font.size": 30, "axes.facecolor": "black", "figure.facecolor": "black"}):
        other = Drawn(renderer.scene, WIDE, "test", END)
    snapshot = make_snapshot(renderer.scene, 1.0)
    assert np.array_equal(other.render(snapshot), renderer.render(snapshot))


CONFIGS = Path(__file__).parents[2] / "configs"


def start(name, *changes):
    """Scene and first snapshot of a config with few particles."""
    one = config.load(CONFIGS / f"{name}.yaml", ["discretisation.particles_across=20", *changes])
    scene = scenes.of(one)
    return scene, start_snapshot(scene, start_values(scene, SimpleNamespace(jitter=0.2, seed=0)), "f64")


def picture(scene, snapshot, **video):
    """The box of a frame, int (rows, columns, 3), without the columns around the line of its profile."""
    drawn = Drawn(scene, make_video(960, 480, **video))
    box = drawn.render(snapshot)[drawn.layout.box.slices].astype(int)
    line = (drawn.quantity.profile.line.place - drawn.layout.low[0]) * drawn.layout.pixels_per_length
    columns = np.arange(box.shape[1])
    return box[:, np.minimum(abs(columns - line), box.shape[1] - abs(columns - line)) > 6]


def test_frames_say_how_many_particles_there_are_where_the_spacing_varies():
    """Of two frames with different numbers at one time the row with the time differs; with one spacing it does not."""
    for changes, differs in ((["bodies.0.spacing=0.035"], True), ([], False)):
        scene, snapshot = start("cylinder_in_channel", *changes)
        drawn, places = Drawn(scene, make_video(960, 480)), [snapshot.x, snapshot.y, 0.0 * snapshot.x]
        rows = [
            drawn.render(replace(particles(scene, 0.0, *(each[:count] for each in places)), bodies=snapshot.bodies))[
                drawn.layout.time_label.slices
            ].copy()
            for count in (len(snapshot.x), len(snapshot.x) - 1)
        ]
        assert (rows[0] != rows[1]).any() == differs


@pytest.mark.parametrize("overlay", ["none", "vectors", "streamlines"])
@pytest.mark.parametrize(
    ("name", "colour"), [("pipe", "u"), ("sphere_in_tube", "v"), ("sphere_in_tube", "stream_function")]
)
def test_lower_half_is_the_mirror_image_of_the_upper_one(name, colour, overlay):
    scene, snapshot = start(name)
    if name == "sphere_in_tube":  # past a sphere that stands still
        snapshot = replace(snapshot, u=snapshot.u + 1.0, v=0.5 * np.sin(np.pi * snapshot.x) * snapshot.y)
    box = picture(scene, snapshot, color_by=colour, overlay=overlay)
    different = np.abs(box - box[::-1]).max(axis=2) > 24
    # edges of walls and strokes may fall between pixels otherwise; a stroke on the wrong side would be several wide
    thick = different[1:-1, 1:-1] & different[:-2, 1:-1] & different[2:, 1:-1]
    assert thick.mean() < 1e-3
    assert box.std() > 10  # something is drawn


@pytest.mark.parametrize("name", ["sphere_in_stream", "carried_circle"])
def test_the_fluid_ends_at_open_ends(name):
    """Also in the cut through an axis, which has each end twice. The picture of a region goes on beyond them."""
    scene, snapshot = start(name)
    drawn = Drawn(scene, make_video(960, 480))
    box = drawn.render(snapshot)[drawn.layout.box.slices].astype(int)
    column = drawn.layout.low[0] + (np.arange(box.shape[1]) + 0.5) / drawn.layout.pixels_per_length
    row = drawn.layout.high[1] - (np.arange(box.shape[0]) + 0.5) / drawn.layout.pixels_per_length
    ground = (np.abs(box - style.rgb(drawn.layout.theme.background)).max(axis=2) < 2)[np.abs(row - 0.2) < 0.1]
    inside = np.abs(column - 0.5 * scene.extent[0]) < 0.5 * scene.extent[0]
    assert ground[:, ~inside].all()
    assert not ground[:, inside].any()


def test_streamlines_end_at_open_ends():
    """A plug leaves through them; the picture of a region goes on beyond."""
    scene, snapshot = start("sphere_in_stream")
    layout = arrange(scene, 640, 320)
    streams = Streamlines(scene, layout)
    lines = streams.lines(streams.measured(replace(snapshot, u=np.ones_like(snapshot.x))))
    x = np.concatenate(lines)[:, 0]
    assert layout.low[0] < 0.0 == pytest.approx(x.min(), abs=1e-12)
    assert layout.high[0] > scene.extent[0] == pytest.approx(x.max(), abs=1e-12)


def test_streamlines_are_lines_of_the_stream_function_of_stokes_in_both_halves():
    scene, snapshot = start("taylor_vortices")
    cut = FullCut(scene)
    streams = Streamlines(cut, arrange(cut, 640, 320))
    lines = streams.lines(streams.measured(cut.mirrored(snapshot)))
    assert len(lines) == 20  # ten lines in each half
    sides = [np.sign(line[:, 1].mean()) for line in lines]
    assert sides.count(1.0) == sides.count(-1.0) == 10
    for x, y in (line.T for line in lines):
        radius = np.abs(y)
        psi = radius * 16.0 * ((radius - 1.0) * (2.0 - radius)) ** 2 * np.sin(2 * np.pi * x / scene.length)
        assert np.ptp(psi) < 0.05 * 1.6  # of the largest; means of the nearest are of second order
