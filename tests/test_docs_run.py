"""What the documents show is run: every Python block, and every command at a small size.

Each page's Python blocks share one namespace. Commands run in this process, with the options of `SMALL` behind their
own; a block of commands runs in a folder of its own, which has the small data sets that pages speak of. In Python,
`glassware.draw` takes `SMALL_PICTURES` on top of a page's settings. What needs root, a network, a cluster or hours is
listed in `NOT_RUN` and `PARSED_ONLY` with the reason.
"""

from __future__ import annotations

import ast
import contextlib
import importlib.util
import io
import os
import re
import shlex
import shutil
import subprocess
import sys
from collections.abc import Iterable, Iterator
from dataclasses import dataclass
from pathlib import Path
from types import ModuleType
from typing import Any

import cv2
import numpy as np
import pytest
import trimesh
import yaml

import glassware as gw
from glassware.dataset.commands import build_dataset, glassware, render_scene
from glassware.dataset.settings.config import merged, parse_request
from glassware.dataset.settings.draw import draw
from glassware.learn.training.weights import shipped_weights
from glassware.procedural.description.scene import Scene
from glassware.render.backend.variant import activate

REPOSITORY = Path(__file__).resolve().parents[1]
PAGES = {path.name: path for path in [REPOSITORY / "README.md", *sorted((REPOSITORY / "docs").glob("*.md"))]}

#: The commands that take the settings of a scene, by the names that pages call them.
SCENE_COMMANDS = {"render-scene": render_scene, "build-dataset": build_dataset}
#: What makes a scene small enough to be made in about a second: put behind a command's own options, so it wins.
SMALL = shlex.split(
    "--width 32 --height 24 --views 1 --spp 2 --vessel-count 1 1 --prop-count 1 1 --vessels.chord-error 1e-4"
    " --hdri-dir hdri"
)
#: What takes the place of the size where a camera has a lens of its own, which belongs to a size.
SMALL_SIZE, SMALL_SCALE = SMALL[:4], ["--cameras.scale", "0.05"]
LENSES = ("preset", "K", "fx")
#: What makes a scene from Python fast to render; its objects stay the same.
SMALL_PICTURES = {
    "vessels": {"chord_error": 1e-4},
    "cameras": {"width": 32, "height": 24},
    "picture": {"spp": 2},
}
#: How such a scene prints the size of its pictures, and how a page shows it: the size of the preset `fast`.
SIZE_HERE, SIZE_SHOWN = "32x24", "320x240"
#: A training run of two steps, and one sample a step.
SHORT_RUN = shlex.split("--steps 2 --batch 1")
#: Scenes that a build on a page is cut to; three have one of each split of the networks' page.
SCENES = 3

#: Commands that are not run, by their first words, and why. Whether what they name is there is tested in test_docs.
NOT_RUN = {
    "apt-get ": "needs root, and changes the machine",
    "make ": "sets up an environment; the commands behind its targets are run here and by .ci/run",
    "pip ": "downloads packages",
    "chromium ": "needs a browser; tests/dataset/report/test_page.py runs it where there is one",
    "glassware completion ": "changes the files of a shell; its output is tested in test_help_page",
    "glassware tables ": "trains many networks; tests/learn/tables runs it",
    "glassware train data --network ": "needs the data of another page; tests/learn/test_baselines.py runs it",
    "glassware train data --encoder ": "needs the extra `encoder`; tests/learn/networks/test_efficientnet.py loads it",
    "glassware evaluate keypose/": "needs trained networks; tests/learn/test_baselines.py runs it",
    "glassware train keypose-ours ": "takes minutes; tests/learn/data/test_partial_truth.py trains on such data",
    "glassware evaluate out-keypose/": "needs the weights of the run above",
    "glassware train large": "takes an hour; tests/learn/training runs such settings",
    "glassware train base-data": "takes an hour; tests/learn/training runs such settings",
    "glassware evaluate base unseen ": "renders for minutes; tests/learn/prediction/test_shipped.py loads `base`",
    "glassware predict base left.png": "needs a pair of one's own; tests/learn/prediction reads such pairs",
    "glassware predict out-tuned/": "needs the weights of a run; tests/learn/commands/test_commands.py runs it",
    "glassware train mine --init ": "needs weights and data; tests/learn/training/test_weights.py begins such a run",
    "glassware export-weights ": "needs the weights of a run; tests/learn/training/test_weights.py exports some",
    "glassware export-onnx ": "takes long; tests/learn/prediction/test_export_onnx.py runs it",
    "glassware view out --rerun": "opens a window",
    "glassware view out --save out.rrd": "needs the extra `view`; tests/dataset/viewer/test_recording.py writes one",
    "ray ": "starts a cluster of several machines",
    "python bench/": "takes minutes to hours; its options are compared with its --help",
    "taskset -c 0 python bench/": "takes minutes to hours; its options are compared with its --help",
    "python examples/": "tests/test_examples.py runs them; their options are compared with their --help",
}
if "base" not in shipped_weights():
    NOT_RUN["glassware predict base --sample"] = "needs weights that this checkout does not have"
#: Options of commands that are only parsed, and why.
PARSED_ONLY = {
    "--rerun": "opens a window; tests/dataset/viewer reads the recordings",
    "--executor": "needs a Ray cluster",
    "--devices": "needs CUDA devices",
}
#: Commands that a page shows to be refused, and what the page says of them.
REFUSED = {"render-scene --views 0": "render-scene: cameras.views: expected greater than or equal to 1, found 0"}
#: Python blocks that cannot run here, by a line of theirs, and why.
PYTHON_NOT_RUN = {
    'load("base")': "needs a pair of one's own; tests/learn/prediction/test_predictor.py runs such lines",
    "onnxruntime.InferenceSession(": "needs the extra `onnx`; tests/learn/prediction/test_export_onnx.py runs it",
    "load_reference(": "needs the weights that the authors of MVTrans released",
    "from cryptomatte_api": "needs the extra `formats`; tests/dataset/format/test_cryptomatte.py reads such files",
}
#: Python blocks that compile large kernels or render large pictures, by a line of theirs: run among the longer proofs
#: alone.
PYTHON_SLOW = (
    "piled_probability",
    "room_depth",
    "sensor_depth(",
    "sensor_valid(",
    "trace_stokes(",
    "picture_and_gradients(",
    "refract(",
)

FENCED = re.compile(r"^```(\w*)\n(.*?)^```", re.MULTILINE | re.DOTALL)
INDENTED = re.compile(r"(?:(?<=\n\n)|\A)((?:    [^\n]*\n?)+)")


@dataclass(frozen=True)
class Block:
    """A block of code on a page."""

    line: int  #: of the page, of the block's first line of code
    kind: str  #: "python", "yaml", "bash", ...; "" for an indented block
    text: str


def blocks(text: str) -> list[Block]:
    """Return the code blocks of a page, in order."""
    found = [Block(text.count("\n", 0, m.start(2)) + 1, m[1], m[2]) for m in FENCED.finditer(text)]
    blank = FENCED.sub(lambda m: "\n" * m[0].count("\n"), text)
    found += [Block(blank.count("\n", 0, m.start(1)) + 1, "", m[1]) for m in INDENTED.finditer(blank)]
    return sorted(found, key=lambda block: block.line)


def commands(block: Block) -> list[list[str]]:
    """Return the words of each command of a block; a line that ends in a backslash goes on in the next."""
    first = block.text.split(maxsplit=1)[0]
    if block.kind not in ("", "bash", "sh") or first.endswith("/"):  # a listing begins with its folder
        return []
    lines = block.text.replace("\\\n", " ").splitlines()
    return [words for line in lines if (words := shlex.split(line.strip().removeprefix("$ "), comments=True))]


def reason_not_run(words: list[str]) -> str | None:
    """Return why a command is not run, or None."""
    line = " ".join([Path(words[0]).name, *words[1:]])
    reasons = [reason for first, reason in NOT_RUN.items() if line.startswith(first)]
    return next(iter(reasons + [PARSED_ONLY[word] for word in words if word in PARSED_ONLY]), None)


def named_files(page: Path) -> Iterator[tuple[str, str]]:
    """Yield name and content of each YAML or text file of a page; its first line names it, or the text before it."""
    text = page.read_text("utf-8")
    for match in FENCED.finditer(text):
        first = match[2].splitlines()[0]
        if match[1] == "yaml":
            names = re.findall(r"[\w-]+\.yaml", first)
            yield (names or re.findall(r"[\w-]+\.yaml", text[: match.start()]))[-1], match[2]
        elif match[1] == "text" and (names := re.findall(r"^# ([\w-]+\.txt)", first)):
            yield names[0], match[2]


def scenes_of(words: list[str]) -> list[str]:
    """Return the option that cuts a build to few scenes, one for each shard."""
    shard = words[words.index("--shard") + 1] if "--shard" in words else None
    return ["--scenes", f"0:{int(shard.split('/')[1]) if shard else SCENES}"]


def smaller(words: list[str]) -> list[str]:
    """Return a command with its program's bare name and options behind its own that make it small."""
    program = Path(words[0]).name
    words = [program, *words[1:]]
    small = SMALL_SCALE + SMALL[4:] if has_lens(words) else SMALL
    if program == "build-dataset":
        if "--count" in words:  # takes the place of `--scenes`, which this adds
            at = words.index("--count")
            words = words[:at] + words[at + 2 :]
        return [*words, *small, *scenes_of(words), "--workers", "1"]
    if program == "render-scene":
        return [*words, *small]
    return [*words, *SHORT_RUN] if words[:2] == ["glassware", "train"] else words


def has_lens(words: list[str]) -> bool:
    """Tell whether a command, or the YAML file that it names, gives the cameras a lens of their own."""
    files = {name: text for path in PAGES.values() for name, text in named_files(path)}
    text = files.get(words[words.index("--config") + 1], "") if "--config" in words else ""
    cameras = (yaml.safe_load(text) or {}).get("cameras", {}) if text else {}
    return any(name in cameras or f"--cameras.{name}" in words for name in LENSES)


def run(words: list[str]) -> tuple[int, str]:
    """Run a command of ours in this process; return its exit code and what it wrote to stderr."""
    program, *arguments = words
    main = glassware.main if program == "glassware" else SCENE_COMMANDS[program].main
    errors = io.StringIO()
    with contextlib.redirect_stderr(errors), contextlib.redirect_stdout(io.StringIO()):
        code = main(arguments)
    return code, errors.getvalue()


def runnable(page: str) -> list[Block]:
    """Return the blocks of a page that have commands of ours to run."""
    return [
        block
        for block in blocks(PAGES[page].read_text("utf-8"))
        if any(Path(words[0]).name in (*SCENE_COMMANDS, "glassware") for words in commands(block))
    ]


def write_inputs(folder: Path) -> None:
    """Write the files of a user's own that pages speak of: environment maps, meshes and textures."""
    rng = np.random.default_rng(20230213)
    pictures = ("textures/wood.png", "tops/oak.png", "rooms/walls/brick.png", "rooms/floors/tile.png")
    for name in ("hdri/a.hdr", "hdri/b.hdr", *pictures):
        (folder / name).parent.mkdir(parents=True, exist_ok=True)
        pixels = rng.uniform(0.5, 1.0, (8, 16, 3)).astype(np.float32)
        assert cv2.imwrite(str(folder / name), pixels if name.endswith(".hdr") else (255 * pixels).astype(np.uint8))
    ball = trimesh.creation.icosphere(subdivisions=1, radius=0.03)
    for name in (
        "meshes/ball.ply",
        "shapenet/03797390/10f6e09036350e92b3f21f1137c3c347/models/model_normalized.obj",
        "gso/Toy_Block/meshes/model.obj",
        "gso/Toy_Block/metadata.pbtxt",
        "ycb/025_mug/google_16k/textured.obj",
        "ycb/025_mug/poisson/nontextured.ply",
        "bop/models/obj_000001.ply",
        "objaverse/glbs/000-000/0123456789abcdef0123456789abcdef.glb",
    ):
        path = folder / name
        path.parent.mkdir(parents=True, exist_ok=True)
        if path.suffix == ".pbtxt":
            path.write_text("")
        else:
            (ball.copy().apply_scale(1000.0) if name.startswith("bop") else ball).export(path)
    _source_makers().keypose(folder / "keypose")
    # A beaker in millimetres: 70 wide, 90 high, walls of 2.
    profile = np.array([(0, 0), (35, 0), (35, 90), (33, 90), (33, 2), (0, 2)], float)
    beaker = trimesh.creation.revolve(profile, sections=64)
    beaker.export(folder / "beaker.obj")
    (folder / "keypose-objects").mkdir()
    beaker.copy().apply_scale(1e-3).export(folder / "keypose-objects" / "mug_0.obj")


def _source_makers() -> ModuleType:
    """Return the module `source_makers.py`: small folders in other projects' layouts."""
    path = Path(__file__).with_name("source_makers.py")
    spec = importlib.util.spec_from_file_location("source_makers", path)
    assert spec is not None
    assert spec.loader is not None
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module


@pytest.fixture(scope="module")
def inputs(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A folder with a user's own files and the YAML files of all pages."""
    folder = tmp_path_factory.mktemp("docs")
    write_inputs(folder)
    for path in PAGES.values():
        for name, text in named_files(path):
            (folder / name).write_text(text, "utf-8")
    return folder


@pytest.fixture(scope="module")
def out(inputs: Path, backend: str) -> Path:
    """A small data set of one scene, as `render-scene --seed 7 --out out` makes it; `out-all` has all files."""
    with contextlib.chdir(inputs):
        assert run(smaller(["render-scene", "--seed", "7", "--out", "out"])) == (0, "")
        assert run(smaller(["render-scene", "--seed", "7", "--out", "out-all", "--write", "all"])) == (0, "")
    return inputs / "out"


@pytest.fixture(scope="module")
def out_shared(inputs: Path, backend: str) -> Path:
    """The same with an irradiance cache."""
    with contextlib.chdir(inputs):
        words = ["render-scene", "--seed", "7", "--out", "out-shared", "--picture.light", "shared", "--write", "all"]
        assert run(smaller(words)) == (0, "")
    return inputs / "out-shared"


@pytest.fixture(scope="module")
def data(inputs: Path, backend: str) -> Path:
    """A small data set of a build."""
    with contextlib.chdir(inputs):
        assert run(smaller(["build-dataset", "--seed", "1", "--out", "data"])) == (0, "")
    return inputs / "data"


def draw_small_pictures(seed: int, scene: int = 0, preset: str = "fast", **settings: Any) -> Scene:
    """Draw a scene as `glassware.draw` does, with `SMALL_PICTURES` on top of the settings."""
    small = SMALL_PICTURES
    if any(name in settings.get("cameras", {}) for name in LENSES):
        small = SMALL_PICTURES | {"cameras": {"scale": 0.05}}
    return draw(seed, scene, preset, **merged(settings, small))


@pytest.fixture
def here(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Iterator[Path]:
    """An empty folder to work in, where `glassware.draw` makes small pictures; the variant is reset afterwards."""
    monkeypatch.chdir(tmp_path)
    monkeypatch.setattr(gw, "draw", draw_small_pictures)
    monkeypatch.setenv("SLURM_ARRAY_TASK_ID", "1")
    yield tmp_path
    activate("llvm_ad_rgb")


def test_every_command_of_a_page_is_run_or_has_a_reason_not_to_be() -> None:
    known = {*SCENE_COMMANDS, "glassware"}
    unknown = [
        f"{page}:{block.line}: {' '.join(words)}"
        for page, path in PAGES.items()
        for block in blocks(path.read_text("utf-8"))
        for words in commands(block)
        if Path(words[0]).name not in known and reason_not_run(words) is None and "glassware.render" not in words[-1]
    ]
    assert not unknown


def test_every_setting_that_a_page_gives_a_command_is_accepted(inputs: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(inputs)
    seen = 0
    for page in PAGES:
        for words in (words for block in runnable(page) for words in commands(block)):
            program, arguments = Path(words[0]).name, words[1:]
            if program in SCENE_COMMANDS and " ".join([program, *arguments]) not in REFUSED:
                module = SCENE_COMMANDS[program]
                kind = {"render-scene": "RenderScene", "build-dataset": "BuildDataset"}[program]
                model = getattr(module, kind)
                parse_request(model, arguments, program, page)
                seen += 1
    assert seen > 20


def expanded(word: str) -> list[str]:
    """Return a word as a shell hands it over: variables and file names filled in."""
    return sorted(map(str, Path().glob(word))) if "*" in word else [os.path.expandvars(word)]


def check_commands(block: Block) -> None:
    """Run the commands of a block here."""
    for words in commands(block):
        shown = " ".join([Path(words[0]).name, *words[1:]])
        if shown in REFUSED:
            code, errors = run(shown.split())
            assert (code, errors.strip()) == (2, REFUSED[shown])
        elif reason_not_run(words) is None:
            code, errors = run(smaller([part for word in words for part in expanded(word)]))
            assert code == 0, f"{shown}: {errors}"


def made_by(block: Block) -> set[str]:
    """Return the data sets that a block makes from nothing: those of builds and merges."""
    lines = [words for words in commands(block) if "--out" in words and "render-scene" not in words[0]]
    return {words[words.index("--out") + 1] for words in lines}


def shown_and_printed(block: Block, page: str, names: dict[str, Any]) -> Iterator[tuple[str, str]]:
    """Run a Python block; yield each output that the page shows behind a line, and the real one.

    A page shows the output of a `print` or of a bare name at the block's top level in a comment on the same line.
    """
    lines = block.text.splitlines()
    for node in ast.parse(block.text).body:
        _, _, comment = lines[(node.end_lineno or 1) - 1].partition("  # ")
        node = ast.increment_lineno(node, block.line - 1)
        printed = io.StringIO()
        bare = node.value.id if isinstance(node, ast.Expr) and isinstance(node.value, ast.Name) else None
        with contextlib.redirect_stdout(printed):
            if bare is not None:
                printed.write(repr(names[bare]))
            else:
                exec(compile(ast.Module([node], []), page, "exec"), names)
        if comment and (bare is not None or ast.unparse(node).startswith("print(")):
            yield comment.strip(), printed.getvalue().strip()


def failing(page: str, left_out: Iterable[str]) -> Iterator[str]:
    """Run the Python blocks of a page, one after the other; yield the fault of each that fails."""
    names: dict[str, Any] = {"__name__": "__main__"}
    for block in blocks(PAGES[page].read_text("utf-8")):
        if block.kind != "python" or any(line in block.text for line in left_out):
            continue
        try:
            for shown, output in shown_and_printed(block, page, names):
                printed = output.replace(SIZE_HERE, SIZE_SHOWN)
                assert printed == shown, f"the page shows {shown!r}, and what is printed is {printed!r}"
        except Exception as error:
            yield f"{page}:{block.line}: {type(error).__name__}: {error}"


PYTHON_PAGES = [name for name, path in PAGES.items() if "```python" in path.read_text("utf-8")]
COMMAND_PAGES = [name for name in PAGES if runnable(name)]


def programs() -> dict[str, list[list[str]]]:
    """Return the commands on all pages that run a Python file of ours, by the file."""
    found: dict[str, list[list[str]]] = {}
    for path in PAGES.values():
        for words in (words for block in blocks(path.read_text("utf-8")) for words in commands(block)):
            for word in words:
                if word.endswith(".py") and "python" in words[words.index(word) - 1]:
                    found.setdefault(word, []).append(words)
    return found


PROGRAMS = programs()


#: pycocotools 2.0.10 hands NumPy an array of its own that has no `copy`.
ignore_copy = pytest.mark.filterwarnings("ignore:__array__ implementation doesn't accept a copy keyword")


def provide(page: str, *data_sets: tuple[Path, str]) -> None:
    """Copy data sets to this folder, except those that the Python of a page writes itself."""
    for path, name in data_sets:
        if f'gw.write("{name}"' not in PAGES[page].read_text("utf-8"):
            shutil.copytree(path, name)


@ignore_copy
@pytest.mark.parametrize("page", [page for page in PYTHON_PAGES if page != "building.md"])
def test_the_python_of_a_page_works_and_prints_what_it_shows(page: str, inputs: Path, out: Path, here: Path) -> None:
    shutil.copy(inputs / "beaker.obj", here)
    shutil.copytree(inputs / "keypose", here / "keypose")
    provide(page, (out, "out"), (out.with_name("out-all"), "out-all"))
    assert list(failing(page, [*PYTHON_NOT_RUN, *PYTHON_SLOW])) == []


@ignore_copy
@pytest.mark.slow
@pytest.mark.parametrize("page", PYTHON_PAGES)
def test_the_python_of_a_page_works_on_a_scene_with_an_irradiance_cache_as_well(
    page: str, inputs: Path, out_shared: Path, data: Path, here: Path
) -> None:
    shutil.copy(inputs / "beaker.obj", here)
    shutil.copytree(inputs / "keypose", here / "keypose")
    provide(page, (out_shared, "out"), (out_shared, "out-all"), (data, "data"))
    assert list(failing(page, PYTHON_NOT_RUN)) == []


@pytest.mark.slow
@pytest.mark.parametrize("page", COMMAND_PAGES)
def test_the_commands_of_a_page_work(page: str, out: Path, data: Path, here: Path) -> None:
    for number, block in enumerate(runnable(page)):
        folder = here / str(number)
        shutil.copytree(out.parent, folder, ignore=shutil.ignore_patterns(*made_by(block)))
        if "parts" not in made_by(block):
            shutil.copytree(data, folder / "parts" / "1")
        with contextlib.chdir(folder):
            check_commands(block)


@pytest.mark.slow
@pytest.mark.parametrize("program", PROGRAMS)
def test_the_options_that_pages_give_a_program_are_in_its_help(program: str) -> None:
    command = [sys.executable, str(REPOSITORY / program), "--help"]
    text = subprocess.run(command, capture_output=True, text=True, check=True, timeout=120).stdout
    given = {word for words in PROGRAMS[program] for word in words if word.startswith("--")}
    assert given <= set(re.findall(r"--[\w-]+", text))


def test_the_command_that_shows_the_backend_works() -> None:
    command = [sys.executable, "-P", "-m", "glassware.render.backend.variant"]
    assert command[-1] in PAGES["guide.md"].read_text("utf-8")
    assert "llvm" in subprocess.run(command, capture_output=True, text=True, check=True, timeout=120).stdout


def test_the_checks_see_blocks_commands_and_outputs() -> None:
    text = "A\n\n    pip install x  # why\n    a \\\n      --b 'c d'\n\n```python\nprint(1)  # 2\n```\n"
    found = blocks(text)
    assert [(block.line, block.kind) for block in found] == [(3, ""), (8, "python")]
    assert commands(found[0]) == [["pip", "install", "x"], ["a", "--b", "c d"]]
    assert list(shown_and_printed(found[1], "page", {})) == [("2", "1")]
    assert smaller([".venv/bin/build-dataset", "--shard", "1/30"])[-4:] == ["--scenes", "0:30", "--workers", "1"]
