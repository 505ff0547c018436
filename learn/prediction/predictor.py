"""A trained network to be used from Python: pictures in, arrays out."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np
import torch
from torch import Tensor

from ...annotate.boxes import CORNER_SIGNS
from ...annotate.heatmap import HEAT_THRESHOLD
from ...core.errors import InputError
from ...core.user_text import counted
from ...dataset.cameras.model import Distortion
from ..data.samples import image_tensor
from ..data.scaling import fitted, restored, restored_points, scaled_view
from ..data.views import CameraView, check_camera, check_picture, check_sizes
from ..data.windows import Window, cut, window_of_source
from ..decoding.decode import decode
from ..evaluation.score import check_finite, eval_mode
from ..networks.build import Network, build_network
from ..networks.weights_file import is_safetensors
from ..targets.encoding import encoding_of
from ..targets.view import TRANSPARENT
from ..training.checkpoint import load_network, load_trained, load_weights
from ..training.settings import TrainSettings
from ..training.weights import weights_path
from .camera_checks import check_cameras, check_rectified
from .own_pictures import OwnPicture, read_picture
from .picture_checks import check_large_enough, check_light, check_pair
from .rectification import Pinhole, at_source, pinholes, seen_at
from .rigs import RigOptions, with_rig
from .windows import Found, merged, windows

#: Fewer pixels than these, at the network's size, are no object: as in evaluation, where such ones need not be found.
LEAST_PIXELS = 16


@dataclass(frozen=True, eq=False)
class Prediction(Found):
    """Depth and objects of the first picture, in its own pixels, lens and all."""

    K: np.ndarray  #: (3, 3) float64, intrinsic matrix of that picture [px]
    distortion: Distortion  #: of its lens
    left_out: int  #: peaks without an object's pixels, which are not among the objects

    @property
    def corners(self) -> np.ndarray:
        """Corners of the boxes in the camera's frame, (n, 8, 3) float64 [m], numbered as `annotate.boxes` does."""
        local = CORNER_SIGNS * self.size[:, None] / 2.0
        return local @ self.camera_T_object[:, :3, :3].transpose(0, 2, 1) + self.camera_T_object[:, None, :3, 3]


@dataclass(frozen=True, eq=False)
class Predictor:
    """A network with its weights, in evaluation mode."""

    network: Network
    settings: TrainSettings
    focal: float | None  #: of the training pictures at the network's size [px]; None where it is not known
    device: str

    def stereo(
        self,
        left: np.ndarray | Path | str,
        right: np.ndarray | Path | str,
        camera: str | None = None,
        baseline: float | None = None,
        focal: float | None = None,
        fov: float | None = None,
    ) -> Prediction:
        """Return what is found in a stereo pair.

        Parameters
        ----------
        left, right : (H, W, 3) uint8 or path
            The pictures, sRGB, or their files.
        camera : str, optional
            Name of a device, such as ``d435``, or a calibration file (JSON).
        baseline, focal, fov : float, optional
            Distance of the cameras [m]; focal length [px], or horizontal field of view [rad].

        Raises
        ------
        InputError
            Where the pictures or their camera cannot be used.
        """
        pictures = [_picture(one, name) for one, name in ((left, "left"), (right, "right"))]
        own = with_rig([picture for picture, _ in pictures], RigOptions(camera, baseline, focal, fov))
        return self.predict(own, [name for _, name in pictures])

    def views(
        self,
        pictures: Sequence[np.ndarray | Path | str],
        K: np.ndarray,
        world_T_camera: Sequence[np.ndarray],
    ) -> Prediction:
        """Return what is found in two or more pictures of one scene; the first is labelled.

        Parameters
        ----------
        pictures : sequence of (H, W, 3) uint8 or path
            The pictures of pinhole cameras, sRGB, or their files.
        K : (3, 3) or (V, 3, 3) float
            Intrinsic matrix of all, or of each [px].
        world_T_camera : V (4, 4) float
            Their poses in any common frame, OpenCV's axes [m].
        """
        if len(world_T_camera) != len(pictures):
            expected = f"a pose for each of {counted(len(pictures), 'picture')}"
            raise InputError("world_T_camera", expected, len(world_T_camera))
        matrices = np.broadcast_to(np.asarray(K, np.float64), (len(pictures), 3, 3))
        own, names = [], []
        for number, (one, intrinsic, pose) in enumerate(zip(pictures, matrices, world_T_camera, strict=True)):
            picture, name = _picture(one, f"pictures[{number}]")
            given = np.asarray(pose, np.float64)
            if given.shape != (4, 4):
                raise InputError(f"{name}: world_T_camera", "a pose, (4, 4)", given.shape)
            check_camera(intrinsic, given, name)
            own.append(OwnPicture(picture, given, intrinsic.copy(), Distortion()))
            names.append(name)
        return self.predict(own, names)

    def predict(
        self,
        pictures: Sequence[OwnPicture],
        names: Sequence[Path | str],
        trust_cameras: bool = False,
        least_score: float = HEAT_THRESHOLD,
    ) -> Prediction:
        """Return what is found in pictures with their cameras.

        Parameters
        ----------
        pictures : sequence of OwnPicture
            Two or more; the first is labelled.
        names : sequence of Path or str
            What errors call them.
        trust_cameras : bool
            Whether to take suspicious cameras, and pictures that do not fit them (`camera_checks`, `picture_checks`).
        least_score : float
            Objects with a lower score are left out.
        """
        if len(pictures) < 2:
            raise InputError("pictures", "two or more views of one scene", len(pictures))
        for one, name in zip(pictures, names, strict=True):
            check_light(one.picture, name)
        paths = [Path(name) for name in names]
        if not trust_cameras:
            check_cameras([one.view for one in pictures], paths)
        seen = pinholes(pictures)
        views = [one.view for one in seen]
        check_sizes(views, names[0])
        check_large_enough(views[0].picture, self.settings.views.size, names[0])
        if not trust_cameras and len(views) == 2:
            check_pair(views, names)
        if self.settings.network.name == "simnet":
            check_rectified(views, paths)
        height, width = views[0].picture.shape[:2]
        parts = windows((height, width), views[0].K, self.settings.views.size, self.focal, self.settings.views.fit)
        found = [self._found(self._cut(views, window), names[0]) for window in parts]
        whole = merged((height, width), [(window, part) for window, (part, _) in zip(parts, found, strict=True)])
        whole = whole.chosen(np.flatnonzero(whole.score >= least_score))
        return _in_source(whole, seen[0], sum(left_out for _, left_out in found))

    def _cut(self, views: Sequence[CameraView], window: Window) -> list[CameraView]:
        """Return a window of the first view, and of the others those that show the same at one depth.

        It is that of the training's pairs, or the middle of the planes where these were whole pictures. Networks that
        read disparities have windows at one place.
        """
        reference, *sources = views
        planes = self.settings.network.depth_range
        if planes is None or self.settings.network.name != "mvtrans":
            return [cut(view, window) for view in views]
        middle = self.settings.views.convergence or 2.0 / (1.0 / planes[0] + 1.0 / planes[1])  # of the disparities
        others = [(source, window_of_source(reference, window, source, middle)) for source in sources]
        return [cut(reference, window), *(cut(source, part) for source, part in others)]

    def _found(self, views: Sequence[CameraView], name: Path | str) -> tuple[Found, int]:
        """Return what the network finds in one window, in the window's pixels, and how many peaks are no object."""
        settings, encoding = self.settings.views, encoding_of(self.settings.network)
        scaled = [scaled_view(view, settings.size, settings.fit) for view in views]
        for view in scaled:
            check_picture(view.picture, name)
        pictures = image_tensor(np.stack([view.picture for view in scaled]), encoding)[None]
        poses = torch.from_numpy(np.stack([view.world_T_camera for view in scaled])).float()[None]
        K = torch.from_numpy(np.stack([view.K for view in scaled])).float()[None]
        with torch.inference_mode():
            outputs = self.network(pictures.to(self.device), poses.to(self.device), K.to(self.device))
        fields = {key: value.float().cpu() for key, value in outputs.items()}
        check_finite(fields, str(name))
        fit = fitted((views[0].picture.shape[0], views[0].picture.shape[1]), settings.size, settings.fit)
        (objects,) = decode(fields, K[:, 0].double(), encoding)
        mask = objects.mask.numpy()
        found = Found(
            depth=restored(fields["depth"][0].numpy(), fit),
            score=objects.score.double().numpy(),
            transparent=_transparent(mask, fields),
            camera_T_object=objects.camera_T_object.numpy(),
            size=objects.size.numpy(),
            mask=restored(mask, fit),
            peak=restored_points(objects.peak.double().numpy(), fit),
        )
        pixels = mask.sum(axis=(1, 2))
        return found.chosen(np.flatnonzero(pixels >= LEAST_PIXELS)), int((pixels < LEAST_PIXELS).sum())


def load(weights: Path | str, device: str = "cpu") -> Predictor:
    """Return a network with trained weights.

    Parameters
    ----------
    weights : Path or str
        The name of weights that come with glassware, such as ``base``, or a file: weights, a checkpoint of
        `glassware train`, or of the released code.
    device : str
        Torch's name of the device.

    Raises
    ------
    InputError
        Where there are no such weights, the file is damaged or of another version, or its network finds no objects.
    """
    path = weights_path(Path(weights))
    focal = None
    if is_safetensors(path):
        trained = load_trained(path)
        settings, focal = trained.settings, None if trained.header is None else trained.header.focal
        network = build_network(settings.network)
        load_weights(network, trained.weights, path)
    else:
        network, settings = load_network(path)
    if settings.network.name not in ("mvtrans", "simnet"):
        raise InputError(weights, "a network that finds objects (mvtrans, simnet)", settings.network.name)
    eval_mode(network.to(device))
    return Predictor(network, settings, focal, device)


def _picture(given: np.ndarray | Path | str, name: str) -> tuple[np.ndarray, Path | str]:
    if isinstance(given, Path | str):
        return read_picture(Path(given)), Path(given)
    if not isinstance(given, np.ndarray) or given.dtype != np.uint8 or given.ndim != 3 or given.shape[2] != 3:
        found = f"{given.dtype} of shape {given.shape}" if isinstance(given, np.ndarray) else type(given).__name__
        raise InputError(name, "a picture, (H, W, 3) uint8, or its file", found)
    return given, name


def _transparent(mask: np.ndarray, fields: Mapping[str, Tensor]) -> np.ndarray:
    """Return whether most pixels of each mask have the class of transparent objects, (n,) bool."""
    classes = fields["seg"][0].argmax(0).numpy()
    return np.array([2 * int((classes[one] == TRANSPARENT).sum()) >= int(one.sum()) for one in mask], bool)


def _in_source(found: Found, pinhole: Pinhole, left_out: int) -> Prediction:
    """Return what was found in the picture of a pinhole in the pixels and the frame of the user's camera."""
    if not pinhole.same:
        rows, columns, scale = seen_at(pinhole)
        inside = np.isfinite(scale)
        peaks = _nearest(rows, columns, found.peak, inside)
        found = replace(
            found,
            depth=(found.depth[rows, columns] * scale).astype(np.float32),
            mask=found.mask[:, rows, columns] & inside,
            camera_T_object=at_source(found.camera_T_object, pinhole),
            peak=peaks,
        )
    source = pinhole.source
    # Heat is a regression: at a sharp peak it may be above the 1 of its target.
    found = replace(found, score=np.minimum(found.score, 1.0))
    return Prediction(**vars(found), K=source.K, distortion=source.distortion, left_out=left_out)


def _nearest(rows: np.ndarray, columns: np.ndarray, peaks: np.ndarray, inside: np.ndarray) -> np.ndarray:
    """Return the pixel of the user's picture that is seen nearest to each peak of the pinhole's."""
    found = []
    for x, y in peaks:
        away = np.where(inside, (columns - x) ** 2 + (rows - y) ** 2, np.inf)
        row, column = np.unravel_index(int(away.argmin()), away.shape)
        found.append((float(column), float(row)))
    return np.array(found, np.float64).reshape(-1, 2)
