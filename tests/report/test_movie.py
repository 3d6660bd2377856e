import imageio_ffmpeg
import numpy as np
import pytest
from PIL import Image
from report_scene import END, VIDEO, make_channel, make_snapshot

from tisph.errors import TisphError
from tisph.report.encoder import Encoder
from tisph.report.movie import Movie

TIMES = (0.0, 1.0, 2.0, 5.0, 10.0, 20.0)


@pytest.fixture(scope="module")
def film(tmp_path_factory):
    """A finished movie and its frames as drawn."""
    channel, path = make_channel(), tmp_path_factory.mktemp("movie") / "movie.mp4"
    with Movie(path, channel, VIDEO, "test", END) as movie:
        for t in TIMES:
            movie.add(make_snapshot(channel, t))
        frames = [movie.frame(make_snapshot(channel, t)) for t in TIMES]
    return path, frames


def read(path):
    """Metadata and frames, uint8 of shape (frames, height, width, 3)."""
    reader = imageio_ffmpeg.read_frames(str(path))
    metadata = next(reader)
    width, height = metadata["size"]
    return metadata, np.array([np.frombuffer(frame, np.uint8).reshape(height, width, 3) for frame in reader])


def test_movie_is_h264_yuv420p_of_the_size_and_rate_asked_for(film):
    metadata, frames = read(film[0])
    assert metadata["codec"] == "h264"
    assert metadata["pix_fmt"].startswith("yuv420p")
    assert metadata["size"] == (VIDEO.width, VIDEO.height)
    assert metadata["fps"] == VIDEO.fps
    assert len(frames) == len(TIMES)


def test_movie_shows_the_frames_in_the_order_they_were_drawn(film):
    path, drawn = film
    _, shown = read(path)
    drawn = np.array(drawn, dtype=float)
    difference = np.abs(shown[:, None] - drawn[None]).mean(axis=(2, 3, 4))
    assert difference.argmin(axis=1).tolist() == list(range(len(TIMES)))  # every frame looks most like itself


def test_movie_keeps_the_colours_that_were_drawn(tmp_path):
    colours = np.array([[68, 1, 84], [33, 145, 140], [253, 231, 37], [209, 54, 47], [255, 255, 255]], np.uint8)
    with_idle_bytes = np.column_stack([colours, [0, 50, 100, 200, 255]]).astype(np.uint8)
    frame = np.repeat(np.repeat(with_idle_bytes[None], 64, axis=0), 64, axis=1)
    encoder = Encoder(tmp_path / "movie.mp4", frame.shape[1], frame.shape[0], 30)
    for _ in range(3):
        encoder.write(frame)
    encoder.close()
    shown = read(tmp_path / "movie.mp4")[1][0].astype(float)
    middles = shown.reshape(64, 5, 64, 3)[24:40, :, 24:40].mean(axis=(0, 2))
    # Bytes of YUV and back, slightly lossy: 4 levels. The matrix of standard-definition video would be off by 12
    # where the file says the other, which is what a player would show.
    assert np.abs(middles - colours).max() <= 4.0


def test_file_can_be_played_before_it_is_complete(film):
    data = film[0].read_bytes()
    assert data.index(b"moov") < data.index(b"mdat")  # faststart: the table of contents comes first


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


def test_single_frames_need_no_movie(tmp_path):
    channel = make_channel()
    with Movie(tmp_path / "movie.mp4", channel, VIDEO, "test", END) as movie:
        frame = movie.frame(make_snapshot(channel, 1.0))
        movie.save_frame(tmp_path / "preview.png", make_snapshot(channel, 1.0))
    assert frame.shape == (VIDEO.height, VIDEO.width, 3)
    assert np.array_equal(np.asarray(Image.open(tmp_path / "preview.png")), frame)
    assert not (tmp_path / "movie.mp4").exists()


def test_frames_stay_as_they_were_when_the_next_one_is_drawn():
    channel = make_channel()
    movie = Movie("unused.mp4", channel, VIDEO, "test", END)
    first = movie.frame(make_snapshot(channel, 1.0))
    kept = first.copy()
    movie.frame(make_snapshot(channel, 10.0))
    assert np.array_equal(first, kept)


def test_closing_twice_is_harmless(tmp_path):
    channel = make_channel()
    movie = Movie(tmp_path / "movie.mp4", channel, VIDEO, "test", END)
    movie.add(make_snapshot(channel, 1.0))
    movie.close()
    movie.close()


def test_missing_ffmpeg_is_one_clear_message(tmp_path, monkeypatch):
    def missing():
        raise RuntimeError("No ffmpeg exe could be found")

    monkeypatch.setattr("tisph.report.encoder.get_ffmpeg_exe", missing)
    with pytest.raises(TisphError, match=r"movie\.mp4: ffmpeg could not be started.*No ffmpeg exe"):
        Encoder(tmp_path / "movie.mp4", 320, 240, 30)


def test_movie_that_cannot_be_written_says_why(tmp_path):
    encoder = Encoder(tmp_path / "no_such_folder" / "movie.mp4", 320, 240, 30)
    frame = np.zeros((240, 320, 4), dtype=np.uint8)

    def write_all():
        for _ in range(50):
            encoder.write(frame)
        encoder.close()

    with pytest.raises(TisphError, match="No such file or directory"):
        write_all()
    encoder.close()


def test_error_of_the_run_is_not_hidden_by_a_broken_movie(tmp_path):
    channel = make_channel()

    def run():
        with Movie(tmp_path / "no_such_folder" / "movie.mp4", channel, VIDEO, "test", END) as movie:
            movie.add(make_snapshot(channel, 1.0))
            raise ZeroDivisionError

    with pytest.raises(ZeroDivisionError):
        run()


def test_frames_of_the_wrong_shape_are_refused(tmp_path):
    encoder = Encoder(tmp_path / "movie.mp4", 320, 240, 30)
    with pytest.raises(ValueError, match=r"expected uint8 \(240, 320, 4\)"):
        encoder.write(np.zeros((320, 240, 4), dtype=np.uint8))
    encoder.close()
