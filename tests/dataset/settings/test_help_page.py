"""Help in a short form of options that exist, and of all of them; completion and version without work."""

from __future__ import annotations

import shutil
import subprocess
import sys
from pathlib import Path

import pytest

from glassware.dataset.commands.build_request import BuildDataset
from glassware.dataset.commands.completion import script
from glassware.dataset.commands.glassware import main
from glassware.dataset.commands.scene_request import RenderScene
from glassware.dataset.format.file_kinds import KINDS
from glassware.dataset.settings.common_options import COMMON
from glassware.dataset.settings.config import parse_request
from glassware.dataset.settings.help_page import common_sections
from glassware.dataset.settings.options import SHORT, default_text, form_of, option_names, sections
from glassware.learn.training.settings import TrainSettings

BIN = Path(sys.executable).parent
REQUESTS = {"render-scene": RenderScene, "build-dataset": BuildDataset}
#: A short form that one reads at a glance has about this many options.
FEW = 26


@pytest.mark.parametrize("prog", REQUESTS)
def test_every_option_of_the_short_form_exists_and_they_are_few(prog):
    found = common_sections(sections(REQUESTS[prog]), prog)
    names = [option.name for section in found for option in section.options]
    assert names == [name for _, group in COMMON[prog] for name in group]
    assert len(set(names)) == len(names) <= FEW


def test_the_short_form_of_train_names_its_settings():
    names = [name for _, group in COMMON["glassware train"] for name in group]
    own = {"DATA", "--config", "--out", "--resume"}  # of the command itself
    assert own <= set(names)
    assert {SHORT.get(name, name) for name in names} - own <= {*option_names(TrainSettings)}


def test_parsing_a_request_loads_no_library_that_takes_long():
    code = "import sys; import glassware.dataset.commands.render_scene; print(sorted("
    code += "{'torch', 'mitsuba', 'scipy', 'trimesh', 'pyarrow', 'OpenEXR'} & set(sys.modules)))"
    ended = subprocess.run([sys.executable, "-P", "-c", code], capture_output=True, text=True, timeout=60, check=True)
    assert ended.stdout == "[]\n"


def test_every_short_name_stands_for_an_option():
    assert set(SHORT.values()) <= {*option_names(RenderScene), *option_names(TrainSettings)}


def test_no_option_lacks_a_description_or_a_known_form():
    for request in REQUESTS.values():
        for section in sections(request):
            for option in section.options:
                assert option.description, option.name
                assert option.switch or (option.form and "VALUE" not in option.form), option.name


def test_help_of_all_options_has_each_of_them(capsys, monkeypatch):
    monkeypatch.setenv("COLUMNS", "100")
    with pytest.raises(SystemExit) as stop:
        main(["render", "--help-all"])
    assert stop.value.code == 0
    printed = capsys.readouterr().out
    assert [name for name in option_names(RenderScene) if name not in printed] == []
    assert max(map(len, printed.splitlines())) <= 100


def test_help_shows_the_defaults_of_the_preset_that_is_named(capsys):
    with pytest.raises(SystemExit):
        main(["render", "--preset", "standard", "--help"])
    printed = " ".join(capsys.readouterr().out.split())
    assert "--width INT Picture width, 1 to 16384 [px] (default: 640)" in printed


@pytest.mark.parametrize(
    ("value", "dimension", "text"),
    [
        (None, None, ""),
        ((), None, ""),
        (True, None, "yes"),
        ((1, 7), None, "1 7"),
        (0.1, "angle", "5.73deg"),
        ((0.04, 0.3), "length", "0.04 0.3 m"),
        (("stem glass", "vase"), None, "'stem glass' vase"),
    ],
)
def test_defaults_are_words_and_angles_have_their_unit(value, dimension, text):
    assert default_text(value, dimension) == text


@pytest.mark.parametrize(
    ("kind", "form"),
    [(int | None, "INT"), (tuple[float, float], "FLOAT FLOAT"), (tuple[str, ...], "TEXT ..."), (dict, "VALUE")],
)
def test_forms_say_what_a_value_looks_like(kind, form):
    assert form_of(kind) == form


@pytest.mark.parametrize(
    ("words", "kinds"),
    [
        (["--write", "radiance,noisy"], ("radiance", "noisy")),
        (["--write", "layers", "radiance"], ("radiance", "layers")),
        (["--write=refraction,layers"], ("layers", "refraction")),
        (["--write", "all"], KINDS),
        (["--write", "none"], ()),
        ([], ()),
    ],
)
def test_files_to_write_are_named_with_commas_or_blanks(words, kinds):
    assert parse_request(RenderScene, words, "render-scene", "").write == kinds


def test_the_script_of_bash_completes_commands_options_and_values(tmp_path):
    (tmp_path / "completion.bash").write_text(script("bash"))
    program = """
source completion.bash
ask() { COMP_WORDS=("$@"); COMP_CWORD=$(($# - 1)); COMPREPLY=(); _glassware; echo "${COMPREPLY[*]}"; }
ask glassware ren
ask glassware render --vie
ask /somewhere/render-scene --picture.no-den
ask build-dataset --executor r
ask glassware completion z
"""
    ended = subprocess.run(["bash", "-c", program], cwd=tmp_path, capture_output=True, text=True, check=True)
    assert ended.stdout.splitlines() == ["render", "--views", "--picture.no-denoise", "ray", "zsh"]


def test_the_scripts_of_other_shells_name_every_command():
    for name in ("render", "build", "show", "report", "verify", "merge", "completion", "train", "evaluate", "predict"):
        assert name in script("zsh")
        assert name in script("fish")


def test_a_closed_pipe_is_no_traceback():
    assert shutil.which("head") is not None
    command = f"{BIN / 'render-scene'} --help-all | head -1"
    ended = subprocess.run(["bash", "-c", command], capture_output=True, text=True, timeout=60, check=True)
    assert ended.stdout.startswith("Render one labelled scene")
    assert ended.stderr == ""


@pytest.mark.parametrize("words", [["render-scene", "--version"], ["glassware", "train", "--version"]])
def test_every_command_has_its_version(words):
    ended = subprocess.run([BIN / words[0], *words[1:]], capture_output=True, text=True, timeout=60, check=True)
    assert ended.stdout.startswith("glassware 0.")


def test_the_list_of_commands_loads_no_renderer_and_no_torch():
    code = "import sys; from glassware.dataset.commands.glassware import main; main(['--help']); print(sorted("
    code += "{'torch', 'mitsuba', 'scipy', 'trimesh', 'pyarrow'} & set(sys.modules)))"
    ended = subprocess.run([sys.executable, "-P", "-c", code], capture_output=True, text=True, timeout=60, check=True)
    assert ended.stdout.splitlines()[-1] == "[]"
