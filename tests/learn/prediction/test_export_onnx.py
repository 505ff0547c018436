"""A network as ONNX: onnxruntime gives what torch gives."""

from __future__ import annotations

import json
import tempfile
from collections.abc import Iterator
from importlib.util import find_spec
from pathlib import Path

import numpy as np
import pytest
import torch

from glassware.core.errors import InputError
from glassware.core.exit_codes import WorkFailed
from glassware.dataset.commands.glassware import main
from glassware.learn import NetworkSettings, build_network
from glassware.learn.data.settings import ViewSettings
from glassware.learn.prediction.predictor import Predictor
from glassware.learn.training.settings import TrainSettings
from glassware.learn.training.weights import WeightsHeader, write_weights

pytestmark = [
    pytest.mark.slow,
    pytest.mark.skipif(find_spec("onnxscript") is None, reason="the extra `onnx` is not installed"),
]


@pytest.fixture(scope="module", autouse=True)
def without_session_file() -> Iterator[None]:
    """Remove the file that onnxruntime leaves in the folder for temporary files when it is imported."""
    yield
    (Path(tempfile.gettempdir()) / ".ses").unlink(missing_ok=True)


@pytest.mark.parametrize(
    "changes",
    [
        {},
        {"matching": "group", "spacing": "inverse", "readout": "windowed", "fusion": "visibility"},
        {"spacing": "inverse", "refinement": "semi_global"},
    ],
)
def test_onnxruntime_gives_what_torch_gives_for_other_pictures_and_cameras(tiny, tmp_path, changes, capsys):
    settings = NetworkSettings(**(tiny.model_dump() | changes))
    network = build_network(settings)
    for name, parameter in network.named_parameters():  # new heads are 0: nothing to compare
        if name.endswith("predictor.weight"):
            torch.nn.init.normal_(parameter, std=0.3)
    header = WeightsHeader(
        name="tiny", glassware="0", network=settings, views=ViewSettings(size=(96, 128)), step=0, data=None
    )
    write_weights(tmp_path / "tiny.safetensors", header, network.state_dict())
    out = tmp_path / "tiny.onnx"
    assert main(["export-onnx", str(tmp_path / "tiny.safetensors"), "--out", str(out), "--threads", "1"]) == 0
    assert "2 views of 128 x 96 px, within" in capsys.readouterr().out

    import onnxruntime

    from glassware.learn import load
    from glassware.learn.prediction.export_onnx import example_inputs

    session = onnxruntime.InferenceSession(str(out), providers=["CPUExecutionProvider"])
    record = json.loads(session.get_modelmeta().custom_metadata_map["glassware"])
    assert record["size"] == [96, 128]
    images, _, _ = example_inputs((96, 128), 2, seed=5)
    poses = torch.eye(4).repeat(1, 2, 1, 1)
    poses[0, 1, :3, 3] = torch.tensor([0.07, 0.01, -0.02])
    K = torch.tensor([[90.0, 0.0, 60.0], [0.0, 95.0, 50.0], [0.0, 0.0, 1.0]]).repeat(1, 2, 1, 1)
    with torch.inference_mode():
        expected = load(tmp_path / "tiny.safetensors").network(images, poses, K)
    found = session.run(None, {"images": images.numpy(), "world_T_camera": poses.numpy(), "K": K.numpy()})
    names = [one.name for one in session.get_outputs()]
    assert names == ["seg", "depth", "heatmap", "offset", "vertex", "z_centroid", "covariance"]
    for name, value in zip(names, found, strict=True):
        scale = max(1.0, float(expected[name].abs().max()))
        assert np.abs(value - expected[name].numpy()).max() / scale < 1e-4, name
    assert float(expected["heatmap"].abs().max()) > 0.01


def test_what_is_compared_shows_one_plane_from_all_views():
    """The second view is the first one, moved by the disparity; none of it is the same at another place."""
    from glassware.learn.prediction.export_onnx import example_inputs

    images, poses, K = example_inputs((96, 128), 2, seed=0)
    assert images.shape == (1, 2, 3, 96, 128)
    assert images.std() > 0.1
    disparity = float(K[0, 0, 0, 0] * poses[0, 1, 0, 3]) / 0.8
    assert disparity == pytest.approx(16.0)
    torch.testing.assert_close(images[0, 1, ..., :-16], images[0, 0, ..., 16:], atol=1e-4, rtol=0.0)
    assert (images[0, 1, ..., :-17] - images[0, 0, ..., 17:]).abs().mean() > 0.03


def test_a_network_that_gives_no_numbers_is_not_written(tiny, tmp_path):
    from glassware.learn.prediction.export_onnx import export_onnx

    network = build_network(tiny)
    torch.nn.init.constant_(dict(network.named_parameters())["z_centroid_head.predictor.bias"], float("nan"))
    with pytest.raises(WorkFailed, match=r"expected outputs within 0\.0001 of torch's, found inf$"):
        export_onnx(Predictor(network, TrainSettings(), None, "cpu"), tmp_path / "a.onnx", (96, 128))
    assert not (tmp_path / "a.onnx").exists()


def test_other_networks_and_sizes_are_one_clear_line(tiny, tmp_path):
    from glassware.learn.prediction.export_onnx import export_onnx

    network = Predictor(build_network(tiny), TrainSettings(), None, "cpu")
    with pytest.raises(InputError, match="--size: expected a height and a width, as the weights name none, found none"):
        export_onnx(network, tmp_path / "a.onnx")
    with pytest.raises(InputError, match="--size: expected multiples of 32 px, found 100 x 128"):
        export_onnx(network, tmp_path / "a.onnx", (100, 128))
    released = Predictor(build_network(NetworkSettings(variant="reference")), TrainSettings(), None, "cpu")
    with pytest.raises(InputError, match="expected the corrected MVTrans, found ReferenceMVTrans"):
        export_onnx(released, tmp_path / "a.onnx", (96, 128))
