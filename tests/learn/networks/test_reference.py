from __future__ import annotations

import json
import math
import zlib
from pathlib import Path

import numpy as np
import pytest
import torch

from glassware.core.errors import InputError
from glassware.learn import ReferenceMVTrans, load_reference

GOLDEN = Path(__file__).resolve().parents[4] / "shared" / "reference" / "golden"

PARAMETERS = 49_749_487


@pytest.fixture(scope="module")
def shapes() -> dict[str, list[int]]:
    path = GOLDEN / "mvtrans_state_dict.json"
    if not path.is_file():
        pytest.skip("the golden case is not beside this checkout (shared/reference/golden)")
    return json.loads(path.read_text())


def drawn(name: str, shapes: dict[str, list[int]]) -> torch.Tensor:
    """The weights of the golden case, by the rule of its README."""
    rng = np.random.default_rng(zlib.crc32(("public" + name).encode()))
    module, leaf = name.rsplit(".", 1)
    shape = tuple(shapes[name])
    if leaf == "num_batches_tracked":
        return torch.tensor(0)
    if f"{module}.running_mean" in shapes:
        values = rng.uniform(0.5, 1.5, shape) if leaf in ("weight", "running_var") else 0.1 * rng.standard_normal(shape)
    elif leaf == "weight":
        values = rng.standard_normal(shape) * math.sqrt(2.0 / math.prod(shape[1:]))
    else:
        values = 0.01 * rng.standard_normal(shape)
    return torch.from_numpy(np.asarray(values, np.float32))


@pytest.fixture(scope="module")
def outputs(shapes) -> tuple[dict[str, torch.Tensor], dict[str, np.ndarray]]:
    """What our network gives for the golden case, and what the released one gave."""
    net = load_reference({f"model.{name}": drawn(name, shapes) for name in shapes})
    with np.load(GOLDEN / "mvtrans_public.npz") as stored:
        case = dict(stored)
    images, poses, K = (torch.from_numpy(case[name]) for name in ("imgs", "cam_poses", "K"))
    with torch.inference_mode():
        return net(images, poses, K[:, None].expand(-1, images.shape[1], -1, -1)), case


def rounding(shapes: dict[str, list[int]]) -> float:
    """Norm of the difference over the norm of the output that the order of float32 sums may make.

    An output of a layer is a sum of n products. Their roundings of 2^-24 are independent, so that another order changes
    it by some sqrt(n) 2^-24; what the layers change adds up at most.
    """
    return 2.0**-24 * sum(math.sqrt(math.prod(shape[1:])) for shape in shapes.values() if len(shape) > 1)


@pytest.mark.parametrize("name", ["seg", "depth", "small_depth", "heatmap", "vertex", "z_centroid", "covariance"])
def test_the_reference_agrees_with_the_released_network(outputs, shapes, name):
    ours, released = outputs[0][name].numpy(), outputs[1][name]
    assert ours.shape == released.shape
    assert rounding(shapes) < 1e-3  # so a weight in the wrong place is found
    assert np.linalg.norm(ours - released) < rounding(shapes) * np.linalg.norm(released)


def test_the_reference_has_the_released_names_and_shapes(shapes):
    net = ReferenceMVTrans()
    assert {name: list(value.shape) for name, value in net.state_dict().items()} == shapes
    assert sum(parameter.numel() for parameter in net.parameters()) == PARAMETERS


def test_another_networks_weights_are_one_clear_line():
    state = ReferenceMVTrans().state_dict()
    removed = state.pop("pre0.0.weight")
    with pytest.raises(InputError, match=r"pre0\.0\.weight: expected \(32, 64, 1, 1, 1\), found none"):
        load_reference(state)
    with pytest.raises(InputError, match=r"pre0\.0\.weight: .*, found \(64, 32, 1, 1, 1\)"):
        load_reference(state | {"pre0.0.weight": removed.transpose(0, 1)})
    with pytest.raises(InputError, match=r"other\.weight: expected no such tensor"):
        load_reference(state | {"pre0.0.weight": removed, "other.weight": removed})
