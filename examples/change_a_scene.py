"""The everyday script: load a scene, change glass, liquid and camera, render it, and have masks and depth as arrays.

.venv/bin/render-scene --seed 7 --out out
.venv/bin/python examples/change_a_scene.py [out/scenes/000000/scene.json] [--picture changed.png]

Each change is a checked copy: picture and labels show the same scene.
"""

from __future__ import annotations

import sys
from argparse import ArgumentParser
from pathlib import Path

import glassware as gw
from glassware.core.exit_codes import run_command


def main() -> None:
    """Change the first vessel of a scene, and print what its picture and labels hold."""
    parser = ArgumentParser(description="Change a scene, and render it again.")
    parser.add_argument("scene", type=Path, nargs="?", default=Path("out/scenes/000000/scene.json"))
    parser.add_argument("--picture", type=Path, default=Path("changed.png"), help="where the left picture goes")
    given = parser.parse_args()
    scene = gw.load_scene(given.scene)
    name = scene.vessels[0].name
    scene = scene.with_glass(name, "lead crystal").with_liquid(name, "water", fill=0.6)
    scene = scene.with_dye(name, "brilliant blue FCF", 0.005)  # [kg/m^3]
    scene = scene.with_camera(0, eye=(0.35, -0.45, 0.4), target=(0.0, 0.0, 0.05))
    frame = gw.Renderer(scene).frame(0)
    gw.save_png(given.picture, frame)
    depth, masks, points = frame.geometry.Z, gw.masks(frame), gw.points(frame, "world")
    print(f"{given.picture}: {frame.left.shape[1]}x{frame.left.shape[0]} px, {len(points)} points")
    for other, mask in masks.items():
        nearest = f", {depth[mask].min():.3f} m away" if mask.any() else ""
        print(f"{other}: {int(mask.sum())} px{nearest}")


if __name__ == "__main__":
    sys.exit(run_command(main))
