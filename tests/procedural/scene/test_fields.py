from __future__ import annotations

import numpy as np
import pytest

from glassware.core.errors import InputError
from glassware.procedural.scene.draw import draw_scene
from glassware.procedural.scene.fields import check_fields
from glassware.procedural.scene.settings import SceneSettings
from glassware.procedural.vessels.settings import VesselSettings


@pytest.fixture(scope="module")
def scene():
    settings = SceneSettings(vessel_count=(1, 1), prop_count=(1, 1), vessels=VesselSettings(fill_probability=1.0))
    return draw_scene(settings, 7, 0)


def _picture(**changes):
    return lambda scene: {"picture": scene.picture.model_copy(update=changes)}


def _first(kind, **changes):
    return lambda scene: {kind: (getattr(scene, kind)[0].model_copy(update=changes), *getattr(scene, kind)[1:])}


def _all(**changes):
    return lambda _: changes


@pytest.mark.parametrize(
    ("change", "line"),
    [
        (_picture(spp=0), "picture.spp: expected greater than or equal to 1, found 0"),
        (_picture(spp=2.5), "picture.spp: expected a whole number, found 2.5"),
        (_picture(spp="8"), "picture.spp: expected a whole number, found '8'"),
        (_picture(spp=True), "picture.spp: expected a whole number, found True"),
        (_picture(light="caustics"), "picture.light: expected 'auto', 'path' or 'shared', found 'caustics'"),
        (_picture(sppp=3), "picture.sppp: expected a known field of Picture (is it spp?), found sppp"),
        (_picture(max_depth=-1), "picture.max_depth: expected greater than or equal to 1, found -1"),
        (_picture(layers=-1), "picture.layers: expected greater than or equal to 0, found -1"),
        (_picture(dispersion=True), "picture.dispersion: expected spectral to be on as well, found it off"),
        (_all(picture={"spp": 3}), "picture: expected a description, not a dict of its fields, found a dict"),
        (_all(picture=None), "picture: expected a description of type Picture, found None"),
        (_all(environment=3), "environment: expected a description of the right type, found 3"),
        (_all(cameras=()), "cameras: expected at least 1 item, found 0"),
        (_all(cameras=[]), "cameras: expected a tuple, found []"),
        (_all(props=({"id": 3},)), "props: expected a description, not a dict of its fields, found a dict"),
        (_all(props=("ball",)), "props: expected a description of type Prop, found 'ball'"),
        (_all(colour=3), "colour: expected a known field of Scene, found colour"),
        (_first("vessels", glass="water"), "vessel-00, glass: expected a description of type Medium, found 'water'"),
        (_first("vessels", roughness=2.0), "vessel-00, roughness: expected less than or equal to 1, found 2.0"),
        (_first("cameras", width="a"), "camera 0, width: expected a whole number, found 'a'"),
        (_first("cameras", focal=float("nan")), "camera 0, focal: expected a finite number, found nan"),
        (_first("cameras", world_T_camera=np.eye(3)), "camera 0, world_T_camera: expected a 4x4 matrix, found shape"),
        (_first("cameras", world_T_camera=np.eye(4).tolist()), "camera 0, world_T_camera: expected a NumPy array"),
        (_first("cameras", world_T_camera=np.full((4, 4), np.nan)), "camera 0, world_T_camera: expected a 4x4 matrix"),
    ],
)
def test_a_changed_field_is_checked_and_named(scene, change, line):
    check_fields(scene)
    with pytest.raises(InputError) as error:
        check_fields(scene.model_copy(update=change(scene)))
    assert str(error.value).startswith(line)
    assert "\n" not in str(error.value)


def test_fields_deep_inside_are_checked(scene):
    liquid = scene.vessels[0].liquid
    medium = liquid.medium.model_copy(update={"density": -1.0})
    vessel = scene.vessels[0].model_copy(update={"liquid": liquid.model_copy(update={"medium": medium})})
    with pytest.raises(InputError, match=r"^vessel-00, liquid, medium, density: expected greater than 0, found -1.0$"):
        check_fields(scene.model_copy(update={"vessels": (vessel,)}))


def test_assignment_to_a_field_names_what_does_it(scene):
    with pytest.raises(InputError, match=r"^Scene.seed: expected a changed copy, model_copy\(update=.*an assignment$"):
        scene.seed = 3
