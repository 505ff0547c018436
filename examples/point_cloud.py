"""Write what a view shows as a coloured point cloud, in a PLY file that MeshLab, CloudCompare and Open3D open.

    .venv/bin/render-scene --seed 7 --out out
    .venv/bin/python examples/point_cloud.py out [--view 0] [--out cloud.ply] [--behind]

A point is the first surface of a pixel: glass is a surface, as a robot's hand meets it. With `--behind` it is the first
surface that is not glass, which is about what a depth camera measures where light passes straight through.
"""

from __future__ import annotations

import sys
from argparse import ArgumentParser
from pathlib import Path

import numpy as np
import trimesh

import glassware as gw
from glassware.annotate.projection import transformed, unproject
from glassware.core.exit_codes import run_command


def main() -> None:
    """Read the view and write its points in the world frame [m]."""
    parser = ArgumentParser(description="Write a view as a coloured point cloud.")
    parser.add_argument("data", type=Path, help="folder of the data set")
    parser.add_argument("--view", type=int, default=0, help="number of the view among all")
    parser.add_argument("--out", type=Path, default=Path("cloud.ply"))
    parser.add_argument("--behind", action="store_true", help="the first surface that is not glass")
    given = parser.parse_args()
    view = gw.Dataset.open(given.data).views()[given.view]
    camera, geometry = view.camera(), view.geometry()
    places = unproject(geometry.background_Z if given.behind else geometry.Z, camera.K)
    hit = np.isfinite(places[..., 2])
    points = transformed(camera.world_T_camera, places[hit])
    trimesh.PointCloud(points, view.picture("left")[hit]).export(given.out)
    print(f"{given.out}: {len(points)} points")


if __name__ == "__main__":
    sys.exit(run_command(main))
