"""``glassware export-onnx``: a network for other runtimes."""

from __future__ import annotations

import sys
from collections.abc import Sequence
from importlib.util import find_spec
from pathlib import Path

import tyro
from pydantic import Field
from rich.console import Console

from ...core.errors import InputError
from ...core.exit_codes import run_command
from ...core.model import Model
from ...core.user_text import UserPath, sized
from ...dataset.settings.config import parse_request
from .extra import check_extra

_DESCRIPTION = """Write a network as an ONNX file, and compare what onnxruntime makes of it with torch.

  glassware export-onnx base --out base.onnx
  glassware export-onnx out-train/best.safetensors --size 256 320 --views 3 --out mine.onnx

The batch is one sample; size and number of views are fixed, poses and intrinsic matrices are inputs. It needs the extra
onnx. The file has the inputs images (1, V, 3, H, W) in 0 to 1, world_T_camera (1, V, 4, 4) and K (1, V, 3, 3)."""

#: Modules of the extra `onnx` (pyproject.toml).
_MODULES = ("onnx", "onnxruntime", "onnxscript")


class ExportOnnx(Model):
    """Arguments of the command."""

    weights: tyro.conf.Positional[UserPath | None] = Field(
        default=None, description="Weights by their name (base), or a checkpoint"
    )
    size: tuple[int, int] | None = Field(
        default=None, description="Height and width of the pictures, multiples of 32 [px]; by default that of training"
    )
    views: int = Field(default=2, ge=2, le=16, description="Number of views")
    threads: int | None = Field(default=None, ge=1, le=1024, description="CPU threads of torch; all cores by default")
    out: UserPath = Field(default=Path("network.onnx"), description="Output file")
    config: UserPath | None = Field(default=None, description="YAML file of these settings")


#: For the completion of shells.
REQUEST = ExportOnnx


def main(arguments: Sequence[str] | None = None) -> int:
    """Run the command and return its exit code."""
    given = list(sys.argv[1:] if arguments is None else arguments)
    return run_command(lambda: _export(given))


def _export(arguments: Sequence[str]) -> None:
    request = parse_request(ExportOnnx, arguments, "glassware export-onnx", _DESCRIPTION)
    if request.weights is None:
        raise InputError("glassware export-onnx", "weights, by name or file", "none")
    check_extra("glassware export-onnx")
    missing = [name for name in _MODULES if find_spec(name) is None]
    if missing:
        expected = "its extra, as in pip install 'glassware[learn,onnx]'"
        raise InputError("glassware export-onnx", expected, f"no {', '.join(missing)}")
    # Loaded here: torch is an extra, and takes longer to load than help should take.
    from ..networks.build import select_device
    from ..prediction.export_onnx import export_onnx
    from ..prediction.predictor import load
    from ..training.out_folder import make_out_folder

    device = select_device("cpu", request.threads)
    make_out_folder(request.out.parent)
    found = export_onnx(load(request.weights, device), request.out, request.size, request.views)
    height, width = found.size
    line = (
        f"{found.path}: {sized(found.path.stat().st_size)}, {request.views} views of {width} x {height} px, "
        f"within {found.difference:.1e} of torch"
    )
    Console().print(line, markup=False, highlight=False, soft_wrap=True)


if __name__ == "__main__":
    sys.exit(main())
