from __future__ import annotations

import pytest
import torch
from safetensors.torch import save_file

from glassware.core.errors import InputError
from glassware.learn.networks.resnet import ResNet, load_pretrained

#: Parameters of torchvision's networks with their classifiers, as its documentation gives them.
PUBLISHED = {"resnet18": 11_689_512, "resnet50": 25_557_032}


@pytest.mark.parametrize("depth", ["resnet18", "resnet50"])
def test_the_networks_have_the_published_size(depth):
    assert sum(p.numel() for p in ResNet(depth, classes=1000).parameters()) == PUBLISHED[depth]


def test_features_have_the_published_shapes():
    features = ResNet("resnet50")(torch.zeros(1, 3, 64, 96))
    assert [tuple(f.shape[1:]) for f in features] == [(256, 16, 24), (512, 8, 12), (1024, 4, 6), (2048, 2, 3)]


def torchvision_names() -> list[str]:
    """The names of torchvision's ResNet-18, by its rule."""
    convolutions = ["conv1"] + [f"layer{i}.{j}.conv{k}" for i in (1, 2, 3, 4) for j in (0, 1) for k in (1, 2)]
    shortcuts = [f"layer{i}.0.downsample" for i in (2, 3, 4)]
    norms = [name.replace("conv", "bn") for name in convolutions] + [f"{name}.1" for name in shortcuts]
    statistics = ("weight", "bias", "running_mean", "running_var", "num_batches_tracked")
    names = [f"{name}.weight" for name in convolutions] + [f"{name}.0.weight" for name in shortcuts]
    return [*names, *(f"{norm}.{leaf}" for norm in norms for leaf in statistics), "fc.weight", "fc.bias"]


def test_state_dicts_have_torchvisions_names():
    assert sorted(ResNet("resnet18", classes=1000).state_dict()) == sorted(torchvision_names())


@pytest.mark.parametrize("stem", [True, False])
@pytest.mark.parametrize("write", [torch.save, save_file])
def test_pretrained_weights_load_from_a_file(tmp_path, stem, write):
    path = tmp_path / "resnet18.weights"
    trained = ResNet("resnet18", classes=1000)
    write(trained.state_dict(), path)
    net = ResNet("resnet18", stem=stem)
    load_pretrained(net, path)
    assert all(torch.equal(value, trained.state_dict()[name]) for name, value in net.state_dict().items())


class Attack:
    """Runs a command when it is unpickled."""

    def __reduce__(self):
        import os

        return os.system, ("touch attacked",)


def test_a_file_that_is_no_such_state_dict_is_one_clear_line(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    path, net = tmp_path / "weights.pth", ResNet("resnet18")
    with pytest.raises(InputError, match="a readable file, found none"):
        load_pretrained(net, path)
    torch.save(ResNet("resnet50").state_dict(), path)
    with pytest.raises(InputError, match=r"layer1\.0\.conv1\.weight of shape \(64, 64, 3, 3\)"):
        load_pretrained(net, path)
    path.write_bytes(path.read_bytes()[:1000])
    with pytest.raises(InputError, match="an undamaged safetensors or torch file"):
        load_pretrained(net, path)
    torch.save({"weights": Attack()}, path)
    with pytest.raises(InputError, match="an undamaged safetensors or torch file"):
        load_pretrained(net, path)
    assert not (tmp_path / "attacked").exists()
    torch.save([1, 2], path)
    with pytest.raises(InputError, match="a state dict"):
        load_pretrained(net, path)
