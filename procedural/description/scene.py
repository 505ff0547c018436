"""The description of a scene: frozen, typed, free of any renderer.

Metres, radians; world frame right-handed, z up, table top at z = 0. ``a_T_b`` takes coordinates in b to coordinates
in a. These models are what ``scene.json`` holds (`procedural.scene.scene_file` reads and writes it).
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from html import escape
from typing import Annotated, Literal

import numpy as np
from pydantic import Discriminator, Field, Tag

from ...core.arguments import check_type, number, point, whole_number
from ...core.errors import InputError
from ...core.html import convex_outline, html_table, svg_plan
from ...core.images import id_colour
from ...core.model import Model, Vector3
from ...core.pose import look_at
from ...core.setting_errors import suggest
from ...core.user_text import counted
from ..optics.catalogue import dyed, glass_named
from ..optics.draw import liquid_named
from ..optics.medium import Medium
from .bodies import FIRST_OBJECT_ID as FIRST_OBJECT_ID
from .bodies import TABLE_ID as TABLE_ID
from .bodies import Cavity as Cavity
from .bodies import Content as Content
from .bodies import GlassBody, Prop, SceneObject, Vessel
from .bodies import Interface as Interface
from .bodies import Liquid as Liquid
from .bodies import MeshVessel as MeshVessel
from .bodies import Origin as Origin
from .bodies import PropPart as PropPart
from .bodies import content_solid as content_solid
from .bodies import glass_solid as glass_solid
from .bodies import liquid_solid as liquid_solid
from .camera import Camera
from .edits import LEVEL, check_place, made_unique, moved_with_parts, surrounded
from .picture import Picture
from .polarisation_camera import PolarisationCamera
from .rest import Rest
from .sensitivities import Sensitivities
from .surroundings import AreaLight, Environment, Table
from .time_of_flight import DepthDevice
from .twin import Twin

#: Version of the description; the last part changes when an old reader would be misled.
SCENE_SCHEMA = "glassware/scene/1"


def _kind_of_body(body: object) -> str:
    """Return the type of a glass body in a scene file, or of one made by hand: by profiles or a solid of its own."""
    if isinstance(body, dict):
        if body.keys() & {"solid", "cavities"}:
            return "mesh vessel"
        return "vessel" if body.keys() & {"wall", "outer", "inner"} else "body"
    if isinstance(body, MeshVessel):
        return "mesh vessel"
    return "vessel" if isinstance(body, Vessel) else "body"


class Scene(Model):
    """Table, objects, light, cameras and picture settings."""

    schema_version: Literal["glassware/scene/1"] = SCENE_SCHEMA
    seed: int = Field(ge=0, description="Seed of the data set")
    scene_id: int = Field(ge=0, description="Number of the scene in the data set")
    table: Table
    vessels: tuple[
        Annotated[
            Annotated[Vessel, Tag("vessel")]
            | Annotated[MeshVessel, Tag("mesh vessel")]
            | Annotated[GlassBody, Tag("body")],
            Discriminator(_kind_of_body),
        ],
        ...,
    ] = Field(description="Vessels and other transparent bodies")
    props: tuple[Prop, ...]
    environment: Environment
    lights: tuple[AreaLight, ...]
    cameras: tuple[Camera, ...] = Field(min_length=1)
    picture: Picture
    # Left out of files where there is none: scenes whose objects stand apart stay what they were.
    rest: Rest | None = Field(
        default=None, exclude_if=lambda rest: rest is None, description="How a pile came to rest, where there is one"
    )
    placed_again: int = Field(
        default=0,
        ge=0,
        exclude_if=lambda count: count == 0,
        description="How often the places of all objects were drawn again, as they did not fit on the table",
    )
    depth_camera: DepthDevice | None = Field(
        default=None, exclude_if=lambda device: device is None, description="Beside the left colour camera"
    )
    polarisation_camera: PolarisationCamera | None = Field(
        default=None, exclude_if=lambda device: device is None, description="In the place of the left colour camera"
    )
    sensitivities: Sensitivities | None = Field(
        default=None,
        exclude_if=lambda sensor: sensor is None,
        description="Of the colour cameras' sensors; none: pictures are those of the standard observer",
    )
    twin: Twin | None = Field(
        default=None, exclude_if=lambda twin: twin is None, description="Which scene it is a twin of, where it is one"
    )

    @property
    def objects(self) -> tuple[SceneObject, ...]:
        """Glass bodies and props in the order of their ids."""
        return tuple(sorted((*self.vessels, *self.props), key=lambda item: item.id))

    def with_glass(self, name: str, glass: Medium | str, roughness: float | None = None) -> Scene:
        """Return a copy in which a vessel is of another glass.

        Where the vessel's liquid wets the new glass at another angle, its surface follows.

        Parameters
        ----------
        name : str
            Name of the vessel.
        glass : Medium or str
            A medium, or its name in the catalogue (`optics.catalogue.glasses`), such as ``"lead crystal"``.
        roughness : float, optional
            GGX alpha of the glass; unchanged by default.

        Raises
        ------
        InputError
            Where there is no such vessel or glass, or the roughness is not within 0 and 1.
        """
        check_type("glass", glass, (str, Medium), "a Medium, or its name in the catalogue")
        if roughness is not None:
            roughness = number("roughness", roughness, 0.0, 1.0)
        medium = glass_named(glass) if isinstance(glass, str) else glass
        body = self._body(name)
        changed = body.with_media(glass=medium, roughness=roughness)
        if not isinstance(changed, Vessel | MeshVessel) or not isinstance(body, Vessel | MeshVessel):
            return self._with_body(changed)
        # Here, as these load SciPy, and the settings import this module.
        from .mesh_vessel import with_mesh_wall
        from .pouring import held, is_plain, poured
        from .refill import with_wall

        if is_plain(body, self.objects):
            if isinstance(body, MeshVessel):
                return self._with_body(with_mesh_wall(body, medium, roughness))
            return self._with_body(with_wall(body, medium, roughness))
        return self._with_poured(*poured(changed, held(changed), self.objects))

    def with_liquid(self, name: str, liquid: Medium | str | None, fill: float | str | None = None) -> Scene:
        """Return a copy in which a vessel holds another liquid, or nothing.

        The liquid's body, its capillary surface and the media of all interfaces follow.

        Parameters
        ----------
        name : str
            Name of the vessel.
        liquid : Medium, str or None
            A medium, or its name in the catalogue (`optics.catalogue.liquids`), such as ``"olive oil"``; None empties
            the vessel.
        fill : float or str, optional
            Fraction of the brimful volume, or a volume such as ``"150ml"``; by default as much as the vessel holds, or
            half of an empty one.

        Raises
        ------
        InputError
            Where there is no such vessel or liquid, the body has no inside, or the liquid does not fit in.
        """
        body = self._body(name)
        if not isinstance(body, Vessel) and not (isinstance(body, MeshVessel) and body.cavities):
            raise InputError(f"{name}, liquid", "a vessel, which has an inside", f"a {body.category}")
        check_type("liquid", liquid, (str, Medium, type(None)), "a Medium, its name in the catalogue, or None")
        medium = liquid_named(liquid) if isinstance(liquid, str) else liquid
        if medium is not None:
            _check_upright(body)
        # Here, as it loads SciPy, and the settings import this module.
        from .pouring import repoured

        return self._with_poured(*repoured(body, medium, fill, self.objects))

    def with_liquids(
        self, name: str, liquids: Mapping[str, float | str] | Sequence[tuple[Medium | str, float | str]]
    ) -> Scene:
        """Return a copy in which a vessel holds liquids that float on each other, the heaviest on its floor.

        Ice in it floats at its new level, and straws and rods get new waterlines.

        Parameters
        ----------
        name : str
            Name of the vessel.
        liquids : mapping or sequence of pairs
            Each liquid, a medium or its name in the catalogue, with how much of it: a fraction of the brimful volume,
            or a volume, such as ``{"water": "120ml", "olive oil": 0.2}``; in any order.

        Raises
        ------
        InputError
            Where there is no such vessel or liquid, two liquids mix, or they do not fit in.
        """
        body = self._body(name)
        if not isinstance(body, Vessel) and not (isinstance(body, MeshVessel) and body.cavities):
            raise InputError(f"{name}, liquids", "a vessel, which has an inside", f"a {body.category}")
        check_type("liquids", liquids, (Mapping, Sequence), "liquids with their volumes")
        _check_upright(body)
        from .pouring import poured, pours_of  # here, as it loads SciPy, and the settings import this module

        pairs = list(liquids.items()) if isinstance(liquids, Mapping) else list(liquids)
        media = [(liquid_named(liquid) if isinstance(liquid, str) else liquid, amount) for liquid, amount in pairs]
        return self._with_poured(*poured(body, pours_of(body, media), self.objects))

    def with_dye(self, name: str, dye: str, concentration: float) -> Scene:
        """Return a copy in which a dye is dissolved in a vessel's liquid (`optics.catalogue.dyed`).

        Parameters
        ----------
        name : str
            Name of the vessel.
        dye : str
            Name of the dye (`optics.dyes.DYES`), such as ``"brilliant blue FCF"``.
        concentration : float
            Of the dye [kg/m^3], 0 to 1000; a soft drink has 0.002 to 0.1.

        Raises
        ------
        InputError
            Where there is no such vessel or dye, the vessel is empty, or the concentration is impossible.
        """
        body = self._body(name)
        if body.liquid is None:
            raise InputError(f"{name}, liquid", "a vessel that holds one", "an empty one")
        medium = dyed(body.liquid.medium, dye, concentration)
        before = body.liquid.medium
        changed = self._with_body(body.with_media(liquid=medium))
        return changed._with_objects([surrounded(item, name, before, medium) for item in changed.objects])

    def with_camera(self, view: int, eye: Vector3, target: Vector3 = (0.0, 0.0, 0.0)) -> Scene:
        """Return a copy in which a camera is at another place and looks at a point, +z up in the picture.

        Parameters
        ----------
        view : int
            Number of the camera.
        eye, target : (float, float, float)
            Place of its left eye, and the point in the middle of its picture, world frame [m].

        Raises
        ------
        InputError
            Where there is no such camera, eye or target is no point, or they are the same point.
        """
        view = whole_number("view", view, 0, len(self.cameras) - 1)
        place, aim = point("camera, eye", eye), point("camera, target", target)
        if np.allclose(place, aim, rtol=0.0, atol=1e-9):
            raise InputError("camera, target", "a point away from the eye", aim.tolist())
        moved = self.cameras[view].model_copy(update={"world_T_camera": look_at(place, aim)})
        return self.model_copy(update={"cameras": (*self.cameras[:view], moved, *self.cameras[view + 1 :])})

    def with_pose(self, name: str, world_T_object: np.ndarray) -> Scene:
        """Return a copy in which a vessel, with what goes with it or stands in it, or a prop is in another place.

        Parameters
        ----------
        name : str
            Name of the object.
        world_T_object : (4, 4) float
            Its pose: a rotation and a shift [m].

        Raises
        ------
        InputError
            Where there is no such object, the pose is not rigid, the object would be in the table or in another one, or
            what is in a vessel would flow or roll out of its place.
        """
        before = self._object(name)
        if before.within is not None:
            raise InputError(name, f"a pose of the vessel that it stands in ({before.within})", "one of its own")
        changed = moved_with_parts(before, world_T_object, self.objects)
        rest = [other for other in self.objects if other.name not in changed]
        for item in changed.values():
            check_place(item, rest)
        return self._with_objects([changed.get(other.name, other) for other in self.objects])

    def without(self, *names: str) -> Scene:
        """Return a copy without some vessels or props; InputError where there are no such ones.

        What goes with a vessel or stands in it goes with it; without that, a liquid keeps its volume and its level
        falls.
        """
        gone = {self._object(name).name for name in names}
        gone |= {item.name for item in self.objects if {item.within, item.part_of} & gone}
        left = [item for item in self.objects if item.name not in gone]
        scene = self._with_objects(left)
        vessels = {item.within for item in self.objects if item.name in gone and item.within} - gone
        if vessels:
            from .pouring import held, poured  # here, as it loads SciPy, and the settings import this module

            for body in [scene._body(name) for name in sorted(vessels)]:
                if isinstance(body, Vessel | MeshVessel):
                    scene = scene._with_poured(*poured(body, held(body), left))
        return scene

    def add(self, *bodies: SceneObject) -> Scene:
        """Return a copy with more bodies (`procedural.primitives.bodies` makes them).

        A body whose id, or the names of whose meshes, another one has gets free ones.

        Raises
        ------
        InputError
            For what is no body, a name that another one has, or a body in the table or in another one.
        """
        objects = [*self.objects]
        for body in bodies:
            check_type("add", body, (GlassBody, Prop), "bodies: vessels, other glass bodies, or props")
            check_place(body, objects)
            objects.append(made_unique(body, objects))
        return self._with_objects(objects)

    def _object(self, name: str) -> SceneObject:
        check_type("object", name, str, "the name of a vessel or a prop")
        names = [item.name for item in self.objects]
        if name not in names:
            known = ", ".join(names) or "nothing, as the scene has no object"
            raise InputError("object", f"one of {known}", repr(name) + suggest(name, names))
        return self.objects[names.index(name)]

    def _with_objects(self, objects: Sequence[SceneObject]) -> Scene:
        kinds = {"vessels": GlassBody, "props": Prop}
        chosen = {field: tuple(item for item in objects if isinstance(item, kind)) for field, kind in kinds.items()}
        return self.model_copy(update=chosen)

    def _body(self, name: str) -> GlassBody:
        check_type("vessel", name, str, "the name of a vessel")
        names = [body.name for body in self.vessels]
        if name not in names:
            known = ", ".join(names) or "nothing, as the scene has no vessel"
            raise InputError("vessel", f"one of {known}{suggest(name, names)}", repr(name))
        return self.vessels[names.index(name)]

    def _with_poured(self, vessel: GlassBody, standing: Sequence[SceneObject]) -> Scene:
        changed = {item.name: item for item in (vessel, *standing)}
        return self._with_objects([changed.get(item.name, item) for item in self.objects])

    def _with_body(self, body: GlassBody) -> Scene:
        vessels = tuple(body if other.id == body.id else other for other in self.vessels)
        return self.model_copy(update={"vessels": vessels})

    def __repr__(self) -> str:
        """Return one line: the seed, what is in the scene, and the pictures' size."""
        counts = (("vessel", self.vessels), ("prop", self.props), ("camera", self.cameras))
        vessels, props, cameras = (counted(len(some), name) for name, some in counts)
        surroundings = {"picture": "map"}.get(self.environment.kind, self.environment.kind)
        sizes = sorted({f"{camera.width}x{camera.height}" for camera in self.cameras})
        seed = f"seed {self.seed}/{self.scene_id}"
        return f"Scene({seed}: {vessels}, {props}, {surroundings}, {cameras} {' '.join(sizes)})"

    __str__ = __repr__

    def _repr_html_(self) -> str:
        """Show a plan of the table from above and a list of the objects in a notebook; nothing is rendered."""
        length, width, _ = self.table.size
        board = 0.5 * np.array([[-length, -width], [length, -width], [length, width], [-length, width]])
        outlines = [("", board, "#e8e0d4")]
        for item in self.objects:
            mesh = item.mesh if isinstance(item, Prop) else glass_solid(item)
            places = mesh.vertices @ item.world_T_object[:3, :3].T + item.world_T_object[:3, 3]
            outlines.append((str(item.id), convex_outline(places[:, :2]), "#" + bytes(id_colour(item.id)).hex()))
        rows = [(item.id, item.name, repr(item).partition(": ")[2].rstrip(")")) for item in self.objects]
        text = f"<p>{escape(repr(self))}</p>"
        return text + svg_plan(outlines) + html_table(("id", "name", "what"), rows)


def _check_upright(body: GlassBody) -> None:
    """Refuse to fill a vessel that leans or lies: liquids are level."""
    upright = float(body.world_T_object[2, 2])
    if upright < np.cos(LEVEL):
        found = f"one tilted by {np.degrees(np.arccos(max(upright, -1.0))):.0f} degrees"
        raise InputError(f"{body.name}, liquid", "a vessel that stands upright, as liquids are level", found)
