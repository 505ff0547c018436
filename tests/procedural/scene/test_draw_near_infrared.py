from __future__ import annotations

import pytest

from glassware.procedural.description.scene import Scene
from glassware.procedural.primitives import bodies, scenes
from glassware.procedural.scene.draw import draw_scene
from glassware.procedural.scene.draw_near_infrared import with_near_infrared
from glassware.procedural.scene.settings import SceneSettings


def materials(scene: Scene):
    return [scene.table.material, *(piece.material for prop in scene.props for piece in prop.pieces)]


def of_black_things(count: int) -> Scene:
    mesh = bodies.box_mesh((0.05, 0.05, 0.05), "block", (0.0, 0.0, 0.1))
    black = scenes.matte((0.02, 0.02, 0.02), "plastic")
    props = [
        scenes.block(mesh, black, id=2 + k).model_copy(update={"name": f"block-{k}", "category": "block"})
        for k in range(count)
    ]
    table = scenes.board((1.0, 1.0, 0.02), scenes.matte((0.02, 0.02, 0.02), "cotton"))
    return scenes.scene((), [scenes.camera((0.0, 0.0, 0.6), width=16, height=12)], props=props, table=table)


def test_things_of_one_stuff_differ_as_carbon_black_has_it_and_are_the_same_again():
    scene = of_black_things(40)
    found = with_near_infrared(scene)
    assert found == with_near_infrared(scene)
    laws = [material.near_infrared for material in materials(found)]
    assert None not in laws
    of_carbon = sum(law is not None and law.neutral == 1.0 for law in laws[1:])
    assert 20 < of_carbon < 40  # four fifths of black plastic
    assert len({law.bare for law in laws if law is not None}) == 41
    for carbon in (0.0, 1.0):
        again = [material.near_infrared for material in materials(with_near_infrared(scene, carbon))]
        assert {law is not None and law.neutral == 1.0 for law in again} == {carbon == 1.0}


@pytest.mark.slow
def test_a_depth_camera_adds_reflectances_and_changes_nothing_else():
    def drawn(depth: str) -> Scene:
        settings = {"vessel_count": (1, 1), "prop_count": (3, 3), "sensors": {"depth": depth}}
        return draw_scene(SceneSettings.model_validate(settings), 4, 0)

    def without(part: object) -> object:
        if isinstance(part, dict):
            return {key: without(one) for key, one in part.items() if key not in ("near_infrared", "depth_camera")}
        return [without(item) for item in part] if isinstance(part, list | tuple) else part

    plain, measured = drawn("none"), drawn("d435")
    assert without(measured.model_dump(mode="json")) == without(plain.model_dump(mode="json"))
    assert all(material.near_infrared is not None for material in materials(measured))
    assert all(material.near_infrared is None for material in materials(plain))
