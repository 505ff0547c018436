"""XML files of scenes: elements by name and attributes, numbers that read back exactly."""

from __future__ import annotations

import xml.etree.ElementTree as tree
from collections.abc import Iterable
from pathlib import Path

import numpy as np
from scipy.spatial.transform import Rotation

from ....core.atomic_io import write_atomically


def element(parent: tree.Element, tag: str, **attributes: object) -> tree.Element:
    """Append an element; numbers and sequences of numbers become text, attributes of None are left out."""
    texts = {name: text_of(value) for name, value in attributes.items() if value is not None}
    return tree.SubElement(parent, tag, texts)


def text_of(value: object) -> str:
    """Return text as it is, and numbers separated by spaces so that they read back exactly."""
    if isinstance(value, str):
        return value
    if isinstance(value, Iterable):
        return " ".join(repr(number) for number in np.asarray(value).ravel().tolist())
    return repr(value)


def quaternion(pose: np.ndarray) -> list[float]:
    """Return the rotation of a pose as a unit quaternion, w first."""
    x, y, z, w = Rotation.from_matrix(pose[:3, :3]).as_quat().tolist()
    return [w, x, y, z]


def write_xml(path: Path, root: tree.Element) -> None:
    """Write a file with indented elements."""
    tree.indent(root)
    text = tree.tostring(root, encoding="unicode")
    write_atomically(path, f'<?xml version="1.0" encoding="utf-8"?>\n{text}\n'.encode())
