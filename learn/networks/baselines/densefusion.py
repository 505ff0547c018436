"""DenseFusion: the pose of a known kind of object from its pixels, in colour and in depth.

(Wang et al., "DenseFusion: 6D Object Pose Estimation by Iterative Dense Fusion", CVPR 2019.) Colours give an embedding
for each pixel, depths a point; both are joined point by point, and each point votes for a pose with a confidence. The
refiner looks at the points in the frame of the pose that was found, and corrects it.

What the released network does and the corrected one does not: it takes colours of 0 to 255 for those of 0 to 1; it
keeps a classifier that nothing uses.
"""

from __future__ import annotations

import torch
from torch import Tensor, nn

from ....core.errors import InputError
from .colour_embedding import EMBEDDING, ColourEmbedding
from .settings import DenseFusionSettings

#: Mean and standard deviation of ImageNet's images in [0, 1].
_MEAN, _STD = (0.485, 0.456, 0.406), (0.229, 0.224, 0.225)


class DenseFusion(nn.Module):
    """DenseFusion with its refiner: 21,428,416 and 1,923,271 parameters for one category, as released.

    Parameters
    ----------
    settings : DenseFusionSettings
        With `categories`.
    released : bool
        Whether it is the released network, faults included.
    """

    mean: Tensor
    deviation: Tensor
    refiner_steps: Tensor  #: () int64, how often the refiner was trained; it is used from the first time on

    def __init__(self, settings: DenseFusionSettings, *, released: bool = False) -> None:
        super().__init__()
        if not settings.categories:
            raise InputError("network.densefusion.categories", "at least one category", "none")
        self.refinements, self.released = settings.refinements, released
        self.colour = ColourEmbedding(released=released)
        self.fusion = _Fusion()
        self.heads = nn.ModuleList(_head(1408, (640, 256, 128), size * len(settings.categories)) for size in (4, 3, 1))
        self.refiner = _Refiner(len(settings.categories))
        self.register_buffer("mean", torch.tensor(_MEAN)[:, None, None], persistent=False)
        self.register_buffer("deviation", torch.tensor(_STD)[:, None, None], persistent=False)
        self.register_buffer("refiner_steps", torch.zeros((), dtype=torch.int64))

    def forward(
        self,
        images: Tensor,
        points: Tensor,
        pixels: Tensor,
        category: Tensor,
        sizes: Tensor | None = None,
        refine: bool | None = None,
    ) -> dict[str, Tensor]:
        """Return the poses of objects.

        Parameters
        ----------
        images : (B, 3, h, w) Tensor
            Windows around objects, in [0, 1].
        points : (B, N, 3) Tensor
            Points in the camera's frame [m].
        pixels : (B, N) int64 Tensor
            Their pixels in the windows, row times w plus column.
        category : (B,) int64 Tensor
            Number of each object's category.
        sizes : (B, 2) int64 Tensor, optional
            Height and width of each window in its image, multiples of 8; all of it by default.
        refine : bool, optional
            Whether the refiner runs, by default where it has been trained. What comes before gets no gradient then.

        Returns
        -------
        dict of Tensor
            ``poses`` (B, N, 4, 4) and ``confidence`` (B, N), the vote of each point; ``pose`` (B, 4, 4) [m]; with the
            refiner also ``refined`` (B, S, 4, 4), the pose after each of its passes.
        """
        embedding = self._embedding(images, pixels, sizes)  # (B, 32, N)
        cloud = points.mT.contiguous()
        fused = self.fusion(cloud, embedding)  # (B, 1408, N)
        quaternion, shift, confidence = (self._of_category(head(fused), category) for head in self.heads)
        poses = pose_matrices(quaternion.mT, points + shift.mT)  # (B, N, 4, 4)
        confidence = confidence[:, 0].sigmoid()
        best = poses[torch.arange(len(poses), device=poses.device), confidence.argmax(1)]
        outputs = {"poses": poses, "confidence": confidence, "pose": best}
        if refine is None:
            refine = bool(self.refiner_steps > 0)
        if refine and self.refinements:
            refined = self._refined(best.detach(), points, embedding.detach(), category)
            outputs |= {"refined": refined, "pose": refined[:, -1]}
        return outputs

    def _embedding(self, images: Tensor, pixels: Tensor, sizes: Tensor | None) -> Tensor:
        colours = 255.0 * images if self.released else images
        normalised = ((colours - self.mean) / self.deviation).contiguous()
        width = images.shape[-1]
        rows = []
        if sizes is None:
            maps = self.colour(normalised)  # (B, 32, h, w)
        else:  # windows of several sizes: each alone, because pooling would see what is beside it
            maps = normalised.new_zeros(len(images), EMBEDDING, *images.shape[-2:])
            for number, (h, w) in enumerate(sizes.tolist()):
                rows.append(self.colour(normalised[number : number + 1, :, :h, :w]))
                maps[number, :, :h, :w] = rows[-1][0]
        assert maps.shape[-1] == width
        return maps.flatten(2).gather(2, pixels[:, None].expand(-1, EMBEDDING, -1))

    def _of_category(self, values: Tensor, category: Tensor) -> Tensor:
        """Return the outputs of each object's category, (B, n, N), of those of all, (B, n C, N)."""
        count = len(values[0]) // self.refiner.categories
        by_category = values.unflatten(1, (self.refiner.categories, count))
        return by_category[torch.arange(len(values), device=values.device), category]

    def _refined(self, pose: Tensor, points: Tensor, embedding: Tensor, category: Tensor) -> Tensor:
        found = []
        for _ in range(self.refinements):
            pose = pose.detach()
            inside = (points - pose[:, None, :3, 3]) @ pose[:, :3, :3]  # in the frame of the object as found
            pose = pose @ self.refiner(inside.mT.contiguous(), embedding, category)
            found.append(pose)
        return torch.stack(found, dim=1)


class _Fusion(nn.Module):
    def __init__(self) -> None:
        super().__init__()
        self.points = nn.ModuleList([nn.Conv1d(3, 64, 1), nn.Conv1d(64, 128, 1)])
        self.colours = nn.ModuleList([nn.Conv1d(EMBEDDING, 64, 1), nn.Conv1d(64, 128, 1)])
        self.joint = nn.ModuleList([nn.Conv1d(256, 512, 1), nn.Conv1d(512, 1024, 1)])

    def forward(self, points: Tensor, embedding: Tensor) -> Tensor:
        """Return features of each point, (B, 1408, N): two stages of its own, and the mean of all."""
        first, second = _two_stages(self, points, embedding)
        whole = second
        for layer in self.joint:
            whole = torch.relu(layer(whole))
        return torch.cat([first, second, whole.mean(2, keepdim=True).expand(-1, -1, points.shape[2])], dim=1)


class _Refiner(nn.Module):
    def __init__(self, categories: int) -> None:
        super().__init__()
        self.categories = categories
        self.points = nn.ModuleList([nn.Conv1d(3, 64, 1), nn.Conv1d(64, 128, 1)])
        self.colours = nn.ModuleList([nn.Conv1d(EMBEDDING, 64, 1), nn.Conv1d(64, 128, 1)])
        self.joint = nn.ModuleList([nn.Conv1d(384, 512, 1), nn.Conv1d(512, 1024, 1)])
        self.rotation, self.shift = (_head(1024, (512, 128), size * categories) for size in (4, 3))

    def forward(self, points: Tensor, embedding: Tensor, category: Tensor) -> Tensor:
        """Return the correction of each pose, (B, 4, 4), in the object's frame."""
        x = torch.cat(_two_stages(self, points, embedding), dim=1)
        for layer in self.joint:
            x = torch.relu(layer(x))
        mean = x.mean(2, keepdim=True)
        rows = torch.arange(len(points), device=points.device)
        quaternion, shift = (
            head(mean)[..., 0].unflatten(1, (self.categories, size))[rows, category]
            for head, size in ((self.rotation, 4), (self.shift, 3))
        )
        return pose_matrices(quaternion, shift)


def _two_stages(layers: _Fusion | _Refiner, points: Tensor, embedding: Tensor) -> tuple[Tensor, Tensor]:
    stages = []
    for of_points, of_colours in zip(layers.points, layers.colours, strict=True):
        points, embedding = torch.relu(of_points(points)), torch.relu(of_colours(embedding))
        stages.append(torch.cat([points, embedding], dim=1))
    return stages[0], stages[1]


def _head(inputs: int, widths: tuple[int, ...], outputs: int) -> nn.Sequential:
    layers: list[nn.Module] = []
    for width in widths:
        layers += [nn.Conv1d(inputs, width, 1), nn.ReLU()]
        inputs = width
    return nn.Sequential(*layers, nn.Conv1d(inputs, outputs, 1))


def pose_matrices(quaternion: Tensor, translation: Tensor) -> Tensor:
    """Return poses, (..., 4, 4), of quaternions (w, x, y, z) of any length, (..., 4), and translations, (..., 3)."""
    w, x, y, z = (quaternion / quaternion.norm(dim=-1, keepdim=True).clamp_min(1e-12)).unbind(-1)
    rows = [
        torch.stack([1 - 2 * (y * y + z * z), 2 * (x * y - w * z), 2 * (x * z + w * y), translation[..., 0]], dim=-1),
        torch.stack([2 * (x * y + w * z), 1 - 2 * (x * x + z * z), 2 * (y * z - w * x), translation[..., 1]], dim=-1),
        torch.stack([2 * (x * z - w * y), 2 * (y * z + w * x), 1 - 2 * (x * x + y * y), translation[..., 2]], dim=-1),
        translation.new_tensor([0.0, 0.0, 0.0, 1.0]).expand(*translation.shape[:-1], 4),
    ]
    return torch.stack(rows, dim=-2)
