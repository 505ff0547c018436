"""The quantities that a page shows, each with its title, unit and section, and the paper's range where it states one.

A new quantity is a row here, and a line in `facts` that yields its values.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

Axis = Literal["linear", "log", "whole", "percent"]

#: Title of each section of distributions, by its key.
SECTIONS = {
    "counts": "How much is in a scene",
    "vessels": "Vessels",
    "props": "Props",
    "views": "Views",
    "light": "Light and exposure",
    "pictures": "Pictures",
    "sensor": "Depth camera",
    "polarisation": "Polarisation",
    "work": "Time and size",
}


@dataclass(frozen=True)
class Quantity:
    """A quantity of scenes, objects or views; `facts` has its values in SI units."""

    section: str  #: key of `SECTIONS`
    title: str
    unit: str = ""  #: as it is shown; "" for plain numbers
    scale: float = 1.0  #: from SI units to the one that is shown
    axis: Axis = "linear"
    #: Range in Syn-TODD, the data set of Wang et al., "MVTrans: Multi-View Perception of Transparent Objects",
    #: https://arxiv.org/abs/2302.11683: fewest and most.
    paper: tuple[int, int] | None = None
    note: str = ""  #: what exactly is counted


#: By the key that `facts` and the page's anchors use.
QUANTITIES: dict[str, Quantity] = {
    "objects": Quantity(
        "counts", "Objects", axis="whole", paper=(3, 15), note="vessels and props; caps, labels, straws apart"
    ),
    "vessels": Quantity("counts", "Vessels", axis="whole", paper=(0, 7), note="without stoppers and lids of theirs"),
    "props": Quantity("counts", "Props", axis="whole", paper=(0, 8), note="opaque objects on their own"),
    "parts": Quantity(
        "counts", "Parts of vessels, and what leans in them", axis="whole", note="caps, labels, stands, straws, rods"
    ),
    "views": Quantity("counts", "Stereo views", axis="whole"),
    "height": Quantity("vessels", "Height", "mm", 1e3, note="of the bounding box along the vessel's axis"),
    "width": Quantity("vessels", "Width", "mm", 1e3, note="longest side across the axis, handles included"),
    "brimful": Quantity("vessels", "Brimful volume", "ml", 1e6, "log"),
    "glass_index": Quantity("vessels", "Refractive index of the wall", note="at 587.56 nm"),
    "roughness": Quantity("vessels", "Roughness of the wall", note="GGX alpha; 0 is smooth"),
    "fill": Quantity("vessels", "Fill", "%", 1e2, "percent", note="of the brimful volume, all layers; filled ones"),
    "liquid_index": Quantity("vessels", "Refractive index of liquids", note="at 587.56 nm; layers included"),
    "liquid_volume": Quantity("vessels", "Volume of liquids in a vessel", "ml", 1e6, "log"),
    "vessel_mass": Quantity("vessels", "Mass, contents included", "g", 1e3, "log"),
    "longest": Quantity("props", "Longest side", "mm", 1e3, note="of the bounding box"),
    "prop_mass": Quantity("props", "Mass", "g", 1e3, "log"),
    "in_view": Quantity("views", "Objects in view", axis="whole", note="with a pixel of silhouette; parts included"),
    "visible": Quantity(
        "views", "Visible fraction", "%", 1e2, "percent", note="of the silhouette, by object and view, left camera"
    ),
    "seen_through": Quantity("views", "Seen through glass", "%", 1e2, "percent", note="of the silhouette, likewise"),
    "depth": Quantity("views", "Depth of objects", "m", note="planar, to the box's centre, of objects in view"),
    "illuminance": Quantity("light", "Illuminance of the table", "lx", axis="log", note="at its centre, unshadowed"),
    "lamp_flux": Quantity("light", "Luminous flux of lamps", "lm", axis="log"),
    "exposure": Quantity("light", "Exposure", "m^2/kcd", axis="log", note="factor on radiance; one a scene"),
    "spp": Quantity("pictures", "Samples per pixel", axis="log", note="mean of each picture"),
    "noise": Quantity(
        "pictures", "Noise before the denoiser", "%", 1e2, "log", note="relative error, estimated, of each picture"
    ),
    "sensor_measured": Quantity(
        "sensor",
        "Pixels with a depth",
        "%",
        1e2,
        "percent",
        note="of a view; vessels of fewer than 100 visible pixels have no numbers of their own",
    ),
    "sensor_missing": Quantity(
        "sensor", "Missing on vessels", "%", 1e2, "percent", note="of a vessel's visible pixels"
    ),
    "sensor_right": Quantity(
        "sensor", "Right on vessels", "%", 1e2, "percent", note="within 10 mm, of those with a depth"
    ),
    "sensor_behind": Quantity("sensor", "Behind vessels", "%", 1e2, "percent", note="by more than 20 mm, likewise"),
    "sensor_front": Quantity("sensor", "In front of vessels", "%", 1e2, "percent", note="by more than 20 mm, likewise"),
    "sensor_rim": Quantity("sensor", "Missing at rims over inside", note="within 7 px of the silhouette, and the rest"),
    "polarisation_degree": Quantity(
        "polarisation",
        "Degree of linear polarisation of vessels",
        "%",
        1e2,
        "percent",
        note="median over a vessel's visible pixels, of which there are at least 100",
    ),
    "seconds": Quantity("work", "Time of a scene", "s", axis="log", note="of the attempt that made it"),
    "bytes": Quantity("work", "Size of a scene", "MB", 1e-6, "log", note="all files of its folder"),
}

#: What is counted by name: section, title, noun of what is counted ("" where one may count twice), and more about it.
TOPICS: dict[str, tuple[str, str, str, str]] = {
    "families": ("vessels", "Families", "vessel", ""),
    "walls": ("vessels", "Materials of the wall", "vessel", ""),
    "liquids": ("vessels", "Liquids", "", "vessels that hold it"),
    "contents": ("vessels", "Ice, beads and bubbles", "", "vessels that hold them"),
    "kinds": ("props", "Kinds of props", "prop", ""),
    "surfaces": ("props", "Materials of props", "prop", ", by the material of most of their area"),
    "parts_by_kind": ("props", "Parts of vessels, and what leans in them", "object", ""),
    "surroundings": ("light", "Surroundings", "scene", ""),
    "lamps": ("light", "Lamps", "lamp", ""),
    "tables": ("light", "Tables", "scene", ""),
    "optics": ("pictures", "Simplified light", "", "scenes whose pictures have it; their labels are of the true media"),
    "colour_sensors": ("pictures", "Sensors of the colour cameras", "scene", " with measured sensitivities"),
    "depth_cameras": ("sensor", "Devices", "scene", ""),
    "polarisation_cameras": ("polarisation", "Devices", "scene", ""),
    "prints": ("light", "Prints on tables", "", "flat things that are no objects, and scenes without any"),
}
