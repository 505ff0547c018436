"""glassware: physically accurate pictures of transparent objects, with labels that can be trusted.

    import glassware as gw

    scene = gw.draw(seed=7, cameras={"views": 2})
    renderer = gw.Renderer(scene)
    frame = renderer.frame(0)
    labels = gw.label(scene, frame, renderer)
    gw.write("out-7", scene, renderer)
    gw.Dataset.open("out-7").views()[0].points()

Each name loads its module when it is first used, so importing glassware is cheap and loads no renderer.
"""

from __future__ import annotations

from importlib import import_module
from pathlib import Path
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from .annotate.arrays import masks as masks
    from .annotate.arrays import points as points
    from .annotate.labels import label as label
    from .core.errors import InputError as InputError
    from .core.pose import look_at as look_at
    from .dataset.format.pictures import save_png as save_png
    from .dataset.pipeline import write as write
    from .dataset.reader import Dataset as Dataset
    from .dataset.settings.contents import catalogue as catalogue
    from .dataset.settings.draw import draw as draw
    from .procedural.scene.scene_file import load_scene as load_scene
    from .procedural.scene.scene_file import save_scene as save_scene
    from .render.renderer import Renderer as Renderer

    __version__: str

# A Python that is started in a checkout finds this folder before the installed package, and the others by their links.
_LINKS = Path(__file__).parents[1] / ".ci" / "packages" / "glassware"
if _LINKS.is_dir():
    __path__.append(str(_LINKS))

#: The module of each public name.
_MODULES = {
    "Dataset": "dataset.reader",
    "InputError": "core.errors",
    "Renderer": "render.renderer",
    "catalogue": "dataset.settings.contents",
    "draw": "dataset.settings.draw",
    "label": "annotate.labels",
    "load_scene": "procedural.scene.scene_file",
    "look_at": "core.pose",
    "masks": "annotate.arrays",
    "points": "annotate.arrays",
    "save_png": "dataset.format.pictures",
    "save_scene": "procedural.scene.scene_file",
    "write": "dataset.pipeline",
}

__all__ = [
    "Dataset",
    "InputError",
    "Renderer",
    "__version__",
    "catalogue",
    "draw",
    "label",
    "load_scene",
    "look_at",
    "masks",
    "points",
    "save_png",
    "save_scene",
    "write",
]


def __getattr__(name: str) -> Any:
    """Load a public name when it is first used (PEP 562)."""
    if name == "__version__":
        from importlib.metadata import version

        return version("glassware")
    if name not in _MODULES:
        raise AttributeError(f"module 'glassware' has no attribute {name!r}; it has {', '.join(__all__)}")
    value = getattr(import_module(f".{_MODULES[name]}", __name__), name)
    globals()[name] = value
    return value


def __dir__() -> list[str]:
    """List the public names, whether they are loaded or not."""
    return list(__all__)
