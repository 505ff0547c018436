"""Files of one data set in another: hard links where both are on one file system, else copies."""

from __future__ import annotations

import errno
import os
import shutil
from collections.abc import Collection
from pathlib import Path

from ...core.atomic_io import atomic_file
from ..format import layout


def link_assets(source: Path, root: Path) -> None:
    """Link the asset files of a data set that another does not have yet."""
    for path in sorted((source / layout.ASSETS).glob("*")) if (source / layout.ASSETS).is_dir() else ():
        (root / layout.ASSETS).mkdir(exist_ok=True)
        if not (root / layout.ASSETS / path.name).exists():
            with atomic_file(root / layout.ASSETS / path.name) as partial:
                link(path, partial)


def link_tree(source: Path, folder: Path, without: Collection[str] = ()) -> None:
    """Link all files of a folder into a new one, except those of some names."""
    for parent, _, names in os.walk(source):
        here = folder / Path(parent).relative_to(source)
        here.mkdir(exist_ok=True)
        for name in names:
            if name not in without:
                link(Path(parent, name), here / name)


def link(source: Path, target: Path) -> None:
    """Link a file; copy it where the file system cannot."""
    try:
        os.link(source, target)
    except OSError as error:
        if error.errno not in (errno.EXDEV, errno.EPERM, errno.ENOTSUP, errno.EMLINK):
            raise
        shutil.copyfile(source, target)  # another file system, or one without links
