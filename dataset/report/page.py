"""The page: one HTML file without scripts, which loads nothing."""

from __future__ import annotations

import base64
from collections.abc import Iterator
from html import escape

import numpy as np

from ...core.user_text import counted, sized
from .distributions import counts, distributions
from .quantities import SECTIONS
from .sources import sources
from .style import STYLE
from .summary import Summary
from .tables import cards, section
from .thumbnails import Thumbnail
from .work import drawn_again, work

#: What a browser may load: nothing but what the page itself holds. Text of a user's files can do nothing either.
_POLICY = "default-src 'none'; img-src data:; style-src 'unsafe-inline'"

#: What is alike in all histograms.
_LEGEND = '<p class="soft">In histograms, the number at the left is that of the tallest bar; dashed is the median.</p>'


def page(summary: Summary) -> str:
    """Return the page of a data set; the same data set gives the same text."""
    parts = dict(_sections(summary))
    title = escape(summary.head.name)
    links = "".join(f'<a href="#{anchor}">{escape(name)}</a>' for anchor, (name, _) in parts.items())
    body = "".join(section(anchor, name, content) for anchor, (name, content) in parts.items())
    return (
        f'<!DOCTYPE html>\n<html lang="en"><head><meta charset="utf-8">'
        f'<meta http-equiv="Content-Security-Policy" content="{_POLICY}">'
        f'<meta name="viewport" content="width=device-width, initial-scale=1">'
        f"<title>{title}: what was drawn</title><style>{STYLE}</style></head><body>"
        f"<header><h1>{title}</h1>{_lead(summary)}<nav>{links}</nav></header>{_faults(summary)}{_LEGEND}<main>{body}</main>"
        "</body></html>\n"
    )


def _lead(summary: Summary) -> str:
    """Return the line below the name: what it is, and how large."""
    head, views = summary.head, int(summary.numbers.get("views", np.zeros(1)).sum())
    facts = [
        f"{counted(summary.scenes, 'scene')} of seed {head.seed}",
        counted(views, "stereo view"),
        sized(sum(summary.sizes.values())),
        f"glassware {head.versions.get('glassware', 'unknown')}",
        head.backend,
    ]
    if head.developed is not None:
        facts.append(f"developed by the camera {head.developed.camera.name}")
    if summary.names.get("optics"):
        facts.append(f"simplified light: {', '.join(sorted(summary.names['optics']))}")
    if summary.names.get("colour_sensors"):
        facts.append(f"sensor {', '.join(sorted(summary.names['colour_sensors']))}")
    return f"<p>{escape(', '.join(facts))}</p>"


def _faults(summary: Summary) -> str:
    """Return what a reader has to know first: scenes that are not on this page."""
    lines = [f"scene {scene_id} is left out: {reason}" for scene_id, reason in summary.left_out.items()]
    if summary.missing:
        lines.append(f"{counted(summary.missing, 'scene')} of the data set ({summary.head.scenes}) not there")
    return f'<div class="warning">{"<br>".join(map(escape, lines))}</div>' if lines else ""


def _sections(summary: Summary) -> Iterator[tuple[str, tuple[str, str]]]:
    """Yield anchor, title and content of each section."""
    if summary.gallery:
        yield "gallery", ("Gallery", _gallery(summary))
    for anchor, title in SECTIONS.items():
        lists = [*work(summary), *drawn_again(summary)] if anchor == "work" else counts(summary, anchor)
        content = cards(distributions(summary, anchor)) + cards(lists)
        if content:
            yield anchor, (title, content)
    yield "sources", ("Files, licences and splits", cards(sources(summary)))


def _gallery(summary: Summary) -> str:
    more = summary.scenes - len(summary.gallery)
    note = "The first left picture of each scene." if more <= 0 else "The first left pictures of evenly spaced scenes."
    return f'<p class="soft">{note}</p><div class="gallery">{"".join(map(_thumbnail, summary.gallery))}</div>'


def _thumbnail(one: Thumbnail) -> str:
    data = base64.b64encode(one.jpeg).decode("ascii")
    image = f'<img width="{one.width}" height="{one.height}" alt="scene {one.scene_id}" '
    caption = f'<figcaption class="soft">scene {one.scene_id}</figcaption>'
    return f'<figure>{image}src="data:image/jpeg;base64,{data}">{caption}</figure>'
