"""Progress: estimates from what was measured, times and sizes in words, and the room on the disk."""

from __future__ import annotations

import io
from pathlib import Path

import pytest
from rich.console import Console

from glassware.core.errors import InputError
from glassware.core.user_text import sized
from glassware.dataset.builds.output_folder import finalize_output
from glassware.dataset.builds.space import FILLED, Need, dataset_size, estimated, free_space, space_error
from glassware.dataset.commands import build_work
from glassware.dataset.commands.build_request import BuildDataset
from glassware.dataset.commands.progress import BuildProgress, SceneProgress, clock, failed_lines, remaining
from glassware.dataset.commands.show import main as show
from glassware.dataset.format.dataset_file import new_head, write_head
from glassware.dataset.format.file_kinds import KINDS, costs, pair_bytes
from glassware.dataset.format.split_file import SplitsFile
from glassware.procedural.scene.settings import SceneSettings
from glassware.render.frame import LightCheck, RegionCheck


@pytest.mark.parametrize(
    ("ends", "total", "text"),
    [
        ([2.0], 5, ""),  # nothing was measured yet
        ([2.0, 12.0], 5, "at most 40 s left"),  # the first view compiles
        ([2.0, 12.0, 16.0], 5, "about 12 s left"),
        ([2.0, 12.0, 16.0, 24.0], 5, "about 12 s left"),
        ([2.0, 12.0], 1, ""),
    ],
)
def test_the_time_left_is_the_mean_of_the_views_so_far(ends, total, text):
    assert remaining(ends, total) == text


def test_times_and_sizes_have_units():
    assert [clock(seconds) for seconds in (0.4, 99, 100, 5999, 9000)] == [
        "0 s",
        "99 s",
        "1:40 min",
        "99:59 min",
        "2:30 h",
    ]
    assert [sized(count) for count in (1.5e6, 2.34e9, 1e13)] == ["1.5 MB", "2.34 GB", "10 TB"]


def test_steps_and_views_are_lines_where_there_is_no_terminal():
    text = io.StringIO()
    progress = SceneProgress(Console(file=text, width=100))
    with progress.display():
        progress.step("drawing")
        progress.on_stage("loading")
        progress.begin_views(2)
        progress.advance(0)
        progress.advance(1)
    lines = text.getvalue().splitlines()
    assert [line.partition(" s  ")[2] for line in lines[:3]] == [
        "drawing",
        "compiling and loading the scene",
        "rendering 2 views",
    ]
    assert lines[3].startswith("view 1/2 after ")
    assert lines[3].endswith(" left")
    assert lines[4].startswith("view 2/2 after ")


def test_a_terminal_has_one_line_that_changes_and_leaves_nothing():
    text = io.StringIO()
    progress = SceneProgress(Console(file=text, width=100, force_terminal=True))
    with progress.display():
        progress.step("drawing")
        progress.begin_views(1)
        progress.advance(0)
    assert "drawing" in text.getvalue()
    assert text.getvalue().endswith("\x1b[2K")  # the line is erased


def test_the_first_scene_of_a_build_is_reported_once():
    from glassware.dataset.builds.messages import Attempt

    seen = []
    progress = BuildProgress(Console(file=io.StringIO()), 3, 2, lambda attempt: seen.append(attempt.scene))
    progress.attempt_done(Attempt(scene=4, state="failed"), final=False)
    progress.attempt_done(Attempt(scene=5, state="made"), final=True)
    progress.attempt_done(Attempt(scene=4, state="made"), final=True)
    assert seen == [5]


def test_what_files_take_grows_with_pixels_and_kinds(tmp_path: Path):
    small, whole = pair_bytes(640, 480, ()), pair_bytes(640, 480, KINDS)
    assert pair_bytes(1280, 960, KINDS) == 4 * whole
    assert 1e6 < small < 2e6 < whole < 25e6
    assert all(kind in costs() for kind in KINDS)
    settings = SceneSettings()
    need = estimated(tmp_path / "absent" / "data", settings, ("radiance",), 20)
    assert need.pairs == 20 * settings.cameras.views
    assert need.fits
    assert free_space(tmp_path / "absent") > 0


def test_the_size_of_many_scenes_is_counted(tmp_path: Path):
    for scene in range(4):
        folder = tmp_path / "scenes" / f"{scene:06d}" / "000"
        folder.mkdir(parents=True)
        (folder / "left.png").write_bytes(b"x" * 100)
    assert dataset_size(tmp_path, range(4)) == 400


def test_a_build_that_does_not_fit_is_refused_where_nobody_can_be_asked(tmp_path: Path):
    request, console = BuildDataset(scenes="0:9", out=tmp_path), Console(file=io.StringIO())
    need = Need(scenes=9, pairs=90, each=2e9, free=int(150e9))
    assert not need.fits
    with pytest.raises(
        InputError, match=r"expected 180 GB of space for 90 pairs of 2 GB \(fewer scenes, .* found 150 GB"
    ):
        build_work._allow(request, tmp_path, need, console)
    build_work._allow(request.model_copy(update={"yes": True}), tmp_path, need, console)
    build_work._allow(request, tmp_path, Need(9, 90, FILLED * 1e9, int(91e9)), console)
    assert "\n" not in str(space_error(tmp_path, need))


def test_a_build_points_to_a_preview_only_where_there_is_a_scene(tmp_path: Path):
    request = BuildDataset(scenes="0:2", out=tmp_path)
    assert build_work._made(request, 0, 60.0) == f"{tmp_path}: 0 scenes, 0 views, nothing, after 60 s"
    (tmp_path / "scenes" / "000001" / "000").mkdir(parents=True)
    assert f"Look at {tmp_path / 'preview.png'}" in build_work._made(request, 1, 60.0)


def test_the_preview_of_scenes_that_are_gone_is_deleted(tmp_path: Path):
    write_head(tmp_path, new_head("n", 1, {}, {}, "llvm_ad_rgb"))
    (tmp_path / "preview.png").write_bytes(b"of a scene that failed when it was made again")
    splits = SplitsFile(train=(), val=(), test=(), unseen_families=(), unseen_assets={})
    assert finalize_output(tmp_path, splits) == 0
    assert not (tmp_path / "preview.png").exists()


def test_show_prints_the_path_of_the_sheet_where_there_is_no_display(tmp_path: Path, capsys, monkeypatch):
    for name in ("DISPLAY", "WAYLAND_DISPLAY"):
        monkeypatch.delenv(name, raising=False)
    assert show([str(tmp_path)]) == 2
    assert "expected the folder of a data set" in capsys.readouterr().err
    (tmp_path / "dataset.json").write_text("{}")
    assert show([str(tmp_path)]) == 2
    assert "preview.png: expected a contact sheet" in capsys.readouterr().err
    (tmp_path / "preview.png").write_bytes(b"")
    assert show([str(tmp_path)]) == 0
    assert capsys.readouterr().out == f"{tmp_path / 'preview.png'}\n"


@pytest.mark.parametrize(
    ("mode", "remedies", "said"),
    [
        (
            "path",
            ("scene path traced", "scene path traced"),
            [
                "checked: the irradiance cache is off by more than 2% at object 5 (lit part) +25.8% +- 0.2%, the table "
                "(caustic part) -4.1% +- 0.5%; the whole scene is path traced instead"
            ],
        ),
        (
            "shared",
            ("object path traced", "other objects path traced"),
            [
                "checked: the irradiance cache is off by more than 2% at object 5 (lit part) +25.8% +- 0.2%; they are "
                "path traced instead",
                "checked: the irradiance cache is off by more than 2% at the table (caustic part) -4.1% +- 0.5%; they "
                "are within it once the objects above are path traced",
            ],
        ),
    ],
)
def test_regions_beyond_the_bound_are_one_line_for_each_remedy(mode, remedies, said):
    lit, caustic = remedies
    failed = (RegionCheck(5, "lit", 512, 0.258, 0.002, lit), RegionCheck(1, "caustic", 512, -0.041, 0.005, caustic))
    check = LightCheck(0, mode, 0.01, 0.002, 0.02, 2048, 1000, 1000, failed=failed)
    assert failed_lines(check) == said
