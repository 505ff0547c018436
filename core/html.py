"""HTML fragments for notebooks: pictures, a table, a plan seen from above."""

from __future__ import annotations

import base64
from collections.abc import Iterable, Sequence
from html import escape

import cv2
import numpy as np

#: Width of a plan in a notebook [px], and the margin around what it shows [fraction of its larger side].
_PLAN_WIDTH, _PLAN_MARGIN = 360, 0.06


def html_images(pictures: Iterable[tuple[str, np.ndarray]], width: int = 320) -> str:
    """Return captioned pictures side by side.

    Parameters
    ----------
    pictures : iterable of (str, (H, W, 3) uint8)
        Caption and picture (red, green, blue).
    width : int
        Width that each is shown at [px].
    """
    captioned = (
        f'<figure style="display:inline-block;margin:4px"><img width="{width}" src="data:image/png;base64,'
        f'{_png_base64(picture)}"/><figcaption>{escape(caption)}</figcaption></figure>'
        for caption, picture in pictures
    )
    return "<div>" + "".join(captioned) + "</div>"


def html_table(header: Sequence[str], rows: Iterable[Sequence[object]]) -> str:
    """Return a table of texts."""
    head = "".join(f"<th>{escape(cell)}</th>" for cell in header)
    body = "".join("<tr>" + "".join(f"<td>{escape(str(cell))}</td>" for cell in row) + "</tr>" for row in rows)
    return f"<table><tr>{head}</tr>{body}</table>"


def svg_plan(outlines: Sequence[tuple[str, np.ndarray, str]]) -> str:
    """Return a plan as an SVG picture: +x to the right, +y up.

    Parameters
    ----------
    outlines : sequence of (str, (n, 2) float, str)
        Label, corners in order [m], and fill colour of each outline, from the lowest to the highest.
    """
    corners = np.concatenate([points for _, points, _ in outlines])
    low, high = corners.min(0), corners.max(0)
    margin = _PLAN_MARGIN * float((high - low).max())
    (left, bottom), (width, height) = low - margin, high - low + 2.0 * margin
    shapes = "".join(_svg_outline(label, points, fill, margin) for label, points, fill in outlines)
    box = f"{left:.4f} {-(bottom + height):.4f} {width:.4f} {height:.4f}"
    return f'<svg width="{_PLAN_WIDTH}" viewBox="{box}" xmlns="http://www.w3.org/2000/svg">{shapes}</svg>'


def convex_outline(points: np.ndarray) -> np.ndarray:
    """Return the corners of the convex hull of points in the plane, (n, 2) -> (m, 2) float32, in order."""
    return cv2.convexHull(np.ascontiguousarray(points, dtype=np.float32))[:, 0]


def _svg_outline(label: str, points: np.ndarray, fill: str, size: float) -> str:
    # The y axis of SVG points down.
    path = " ".join(f"{x:.4f},{-y:.4f}" for x, y in points)
    x, y = points.mean(0)
    stroke = f'stroke="#333" stroke-width="{0.05 * size:.5f}"'
    text = f'<text x="{x:.4f}" y="{-y:.4f}" font-size="{0.6 * size:.4f}" text-anchor="middle">{escape(label)}</text>'
    return f'<polygon points="{path}" fill="{fill}" {stroke}/>{text}'


def _png_base64(picture: np.ndarray) -> str:
    done, data = cv2.imencode(".png", np.ascontiguousarray(picture[..., ::-1]))
    if not done:
        raise ValueError(f"picture of shape {picture.shape} could not be encoded")
    return base64.b64encode(data.tobytes()).decode("ascii")
