from __future__ import annotations

import importlib.util
import shutil
import sys
from pathlib import Path
from types import ModuleType

import cv2
import numpy as np
import pytest
import torch

from glassware.dataset.commands.render_scene import main as render_scene
from glassware.dataset.format.split_file import SplitsFile, write_splits
from glassware.learn import NetworkSettings


@pytest.fixture(scope="session", autouse=True)
def one_thread() -> None:
    """Tests share the machine, and threads that wait for one which does not run take many times longer than one."""
    torch.set_num_threads(1)


@pytest.fixture(autouse=True)
def seeded() -> None:
    """The same weights in every test; tests must hold for any others as well."""
    torch.manual_seed(20230213)


@pytest.fixture(scope="session")
def tiny() -> NetworkSettings:
    """A network that is computed in some hundredths of a second."""
    return NetworkSettings(
        depth_range=(0.4, 1.6),
        planes=8,
        feature_channels=8,
        feature_width=4,
        feature_blocks=(1, 1, 1, 1),
        volume_channels=4,
        context="resnet18",
        context_width=4,
        decoder_width=4,
        backbone_width=8,
        pyramid_channels=8,
        head_channels=8,
    )


@pytest.fixture(scope="session")
def box_scene() -> ModuleType:
    """The module `tests/learn/box_scene.py`: exact pictures of boxes."""
    name = "glassware_tests_learn_box_scene"
    spec = importlib.util.spec_from_file_location(name, Path(__file__).with_name("box_scene.py"))
    assert spec is not None
    assert spec.loader is not None
    module = importlib.util.module_from_spec(spec)
    sys.modules[name] = module
    spec.loader.exec_module(module)
    return module


@pytest.fixture(scope="session")
def rendered(backend, made_once) -> Path:
    """A data set of two small scenes of five views, by the command; do not change it."""
    return made_once("rendered", _render) / "data"


def _render(folder: Path) -> None:
    (folder / "hdri").mkdir()
    sky = np.random.default_rng(7).uniform(0.5, 1.0, (8, 16, 3)).astype(np.float32)
    assert cv2.imwrite(str(folder / "hdri" / "sky.hdr"), sky)
    config = folder / "small.yaml"
    config.write_text(
        "vessel_count: [1, 2]\n"
        "prop_count: [1, 2]\n"
        "props: {kinds: [shape]}\n"
        "physics: {piled_probability: 0}\n"
        # A label has the middle of its vessel: fields have one peak for both.
        "vessels: {categories: [tumbler, beaker, bowl], label_probability: 0, contents: {standing: 0},\n"
        " chord_error: 1.0e-4}\n"
        f"environment: {{hdri_dir: {folder / 'hdri'}, hdri_share: 1.0}}\n"
        "cameras: {width: 128, height: 96, views: 5}\n"
        "picture: {spp: 4, layers: 0, refraction: no, light: path}\n"
    )
    for scene in (0, 1):
        arguments = ["--seed", "3", "--scene", str(scene), "--out", str(folder / "data"), "--config", str(config)]
        assert render_scene([*arguments]) == 0
    _split(folder / "data", train=(0,), val=(1,))


def _split(root: Path, train: tuple[int, ...], val: tuple[int, ...] = ()) -> None:
    write_splits(root, SplitsFile(train=train, val=val, test=(), unseen_families=(), unseen_assets={}))


@pytest.fixture
def split():
    """Share out the scenes of a data set."""
    return _split


@pytest.fixture
def copied(rendered, tmp_path) -> Path:
    """A copy of it, to be damaged."""
    return Path(shutil.copytree(rendered, tmp_path / "data"))
