"""Materials of glTF 2.0 (section 3.9) and of its extensions, as looks.

Factors are linear. Base colours multiply their picture; roughness and metalness multiply channels of one picture.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from ...core.errors import InputError
from ..description.material import ChannelMap, NormalMap, PictureTexture, UniformTexture
from ..materials.picture_files import read_opacity
from .cutouts import cutout
from .embedded import kept_picture
from .gltf_file import BROKEN, Gltf, uri_content, view_content
from .model import Cutout, GlassLook, Glow, Look
from .references import picture

#: Reflectance of a dielectric at normal incidence that the standard assumes [1] (section 3.9.2, index 1.5).
_DIELECTRIC = 0.04
#: Transmission or one minus opacity from which a surface is glass [1].
_GLASS = 0.5
_IDENTITY = np.eye(3)


@dataclass(frozen=True, eq=False)
class _Picture:
    """A texture of a material: its picture, and how it lies on the surface."""

    texture: PictureTexture | None
    uv_set: int
    uv_T_uv: np.ndarray  #: (3, 3) of KHR_texture_transform


def look_of(gltf: Gltf, number: int | None) -> tuple[Look, int, np.ndarray]:
    """Return a material with the set of texture coordinates that it uses, and their (3, 3) transform.

    Raises
    ------
    InputError
        Where a factor is no finite number.
    KeyError, TypeError, ValueError
        Where the structure is not that of the standard.
    """
    if number is None:
        return Look(), 0, _IDENTITY
    if not 0 <= number < len(gltf.document["materials"]):
        raise ValueError(f"expected one of {len(gltf.document['materials'])} materials, found {number}")
    record = gltf.document["materials"][number]
    extensions = record.get("extensions", {})
    name = str(record.get("name") or f"material {number}")[:80]
    if "KHR_materials_pbrSpecularGlossiness" in extensions:
        look, first = _specular_glossiness(gltf, extensions["KHR_materials_pbrSpecularGlossiness"], name)
    else:
        look, first = _metallic_roughness(gltf, record, name)
    if "KHR_materials_unlit" in extensions:
        look = replace(look, roughness=1.0, metallic=0.0, maps={})
    glow, first = _glow(gltf, record, extensions, first, name)
    look = replace(look, glow=glow)
    look = _with_normals(gltf, record, look, first, name)
    look = replace(look, glass=_glass(gltf, record, extensions))
    if look.glass is not None and "transmissionTexture" in extensions.get("KHR_materials_transmission", {}):
        gltf.source.notes.say(f"{name!r}: its picture of transmission is not used; it is glass all over")
    return _with_opacity(gltf, record, look, name), first.uv_set, first.uv_T_uv


def _metallic_roughness(gltf: Gltf, record: dict[str, Any], name: str) -> tuple[Look, _Picture]:
    surface = record.get("pbrMetallicRoughness", {})
    factor = _numbers(gltf, surface, "baseColorFactor", 4, 1.0)[:3]
    base = _picture_of(gltf, surface.get("baseColorTexture"), f"the colour of {name!r}")
    roughness, metallic = (_numbers(gltf, surface, field, 1, 1.0)[0] for field in ("roughnessFactor", "metallicFactor"))
    both = _picture_of(gltf, surface.get("metallicRoughnessTexture"), f"the roughness of {name!r}")
    first = base if base is not None else both or _Picture(None, 0, _IDENTITY)
    maps: dict[str, object] = {}
    if both is not None and both.texture is not None and _same_place(gltf, both, first, name):
        asset = both.texture.asset
        maps = {"roughness_map": ChannelMap(asset=asset, channel="green")}
        maps["metallic_map"] = ChannelMap(asset=asset, channel="blue")
    return Look(name, _coloured(base, factor), roughness, metallic, maps), first


def _specular_glossiness(gltf: Gltf, surface: dict[str, Any], name: str) -> tuple[Look, _Picture]:
    """Return the look of KHR_materials_pbrSpecularGlossiness as metalness and roughness.

    The metalness and base colour are those of the converter in Khronos's repository of the extension
    (examples/convert-between-workflows): a surface of the same diffuse and specular reflectance.
    """
    diffuse = np.array(_numbers(gltf, surface, "diffuseFactor", 4, 1.0)[:3])
    specular = np.array(_numbers(gltf, surface, "specularFactor", 3, 1.0))
    gloss = _numbers(gltf, surface, "glossinessFactor", 1, 1.0)[0]
    base = _picture_of(gltf, surface.get("diffuseTexture"), f"the colour of {name!r}")
    both = _picture_of(gltf, surface.get("specularGlossinessTexture"), f"the gloss of {name!r}")
    first = base if base is not None else both or _Picture(None, 0, _IDENTITY)
    if both is not None and both.texture is not None:
        opacity = read_opacity(both.texture.asset.path, "alpha")
        gloss *= 1.0 if opacity is None else float(opacity.mean())
        specular = np.minimum(specular, _DIELECTRIC)
        gltf.source.notes.say(f"{name!r}: of its picture of gloss the mean is used")
    if base is not None and base.texture is not None:
        return Look(name, _coloured(base, tuple(diffuse.tolist())), 1.0 - gloss, 0.0), first
    metallic, colour = _metal_of(diffuse, specular)
    return Look(name, UniformTexture(colour=_reflectance(colour)), 1.0 - gloss, metallic), first


def _metal_of(diffuse: np.ndarray, specular: np.ndarray) -> tuple[float, np.ndarray]:
    """Return metalness and base colour of a diffuse and a specular reflectance."""
    weights = np.array([0.299, 0.587, 0.114])
    light, shine = (float(np.sqrt(weights @ value**2)) for value in (diffuse, specular))
    rest = 1.0 - float(specular.max())
    metallic = 0.0
    if shine >= _DIELECTRIC:
        b = light * rest / (1.0 - _DIELECTRIC) + shine - 2.0 * _DIELECTRIC
        root = math.sqrt(max(b * b - 4.0 * _DIELECTRIC * (_DIELECTRIC - shine), 0.0))
        metallic = min(max((root - b) / (2.0 * _DIELECTRIC), 0.0), 1.0)
    of_diffuse = diffuse * rest / (1.0 - _DIELECTRIC) / max(1.0 - metallic, 1e-6)
    of_specular = (specular - _DIELECTRIC * (1.0 - metallic)) / max(metallic, 1e-6)
    return metallic, np.clip(of_diffuse + (of_specular - of_diffuse) * metallic**2, 0.0, 1.0)


def _glow(
    gltf: Gltf, record: dict[str, Any], extensions: dict[str, Any], first: _Picture, name: str
) -> tuple[Glow | None, _Picture]:
    """Return the emission of a material (section 3.9.3, KHR_materials_emissive_strength), and how its picture lies.

    Where no other picture says how pictures lie, that of the emission does.
    """
    factor = np.array(_numbers(gltf, record, "emissiveFactor", 3, 0.0))
    strength = extensions.get("KHR_materials_emissive_strength", {})
    (stated,) = _signed(gltf, strength, "emissiveStrength", 1, 1.0)
    brightest = float(factor.max())
    if brightest * stated <= 0.0:
        return None, first
    found = _picture_of(gltf, record.get("emissiveTexture"), f"the emission of {name!r}")
    if found is not None and first.texture is None:
        first = found
    if found is not None and not _same_place(gltf, found, first, name):
        return None, first
    return Glow(_coloured(found, tuple((factor / brightest).tolist())), brightest * stated), first


def _with_normals(gltf: Gltf, record: dict[str, Any], look: Look, first: _Picture, name: str) -> Look:
    reference = record.get("normalTexture")
    found = _picture_of(gltf, reference, f"the normals of {name!r}")
    if reference is None or found is None or found.texture is None or not _same_place(gltf, found, first, name):
        return look
    strength = min(max(_numbers(gltf, reference, "scale", 1, 1.0)[0], 0.0), 4.0)
    return replace(look, maps=look.maps | {"normal_map": NormalMap(asset=found.texture.asset, strength=strength)})


def _glass(gltf: Gltf, record: dict[str, Any], extensions: dict[str, Any]) -> GlassLook | None:
    transmission = _numbers(gltf, extensions.get("KHR_materials_transmission", {}), "transmissionFactor", 1, 0.0)[0]
    surface = record.get("pbrMetallicRoughness", {})
    opacity = _numbers(gltf, surface, "baseColorFactor", 4, 1.0)[3]
    clear = record.get("alphaMode") == "BLEND" and 1.0 - opacity >= _GLASS and "baseColorTexture" not in surface
    if transmission < _GLASS and not clear:
        return None
    volume = extensions.get("KHR_materials_volume", {})
    index = _numbers(gltf, extensions.get("KHR_materials_ior", {}), "ior", 1, 1.5)[0]
    red, green, blue = _numbers(gltf, volume, "attenuationColor", 3, 1.0)
    distance = volume.get("attenuationDistance", math.inf)
    distance = float(distance) if isinstance(distance, int | float) and distance > 0.0 else math.inf
    return GlassLook(index if 1.0 < index <= 4.0 else 1.5, (red, green, blue), distance)


def _with_opacity(gltf: Gltf, record: dict[str, Any], look: Look, name: str) -> Look:
    """Return the look with what its opacity cuts away, where the material is masked or blended."""
    mode = record.get("alphaMode", "OPAQUE")
    if mode not in ("MASK", "BLEND") or look.glass is not None:
        return look
    threshold = _numbers(gltf, record, "alphaCutoff", 1, 0.5)[0] if mode == "MASK" else 0.5
    surface = record.get("pbrMetallicRoughness", {})
    factor = _numbers(gltf, surface, "baseColorFactor", 4, 1.0)[3]
    if factor < threshold:
        return replace(look, cutout=Cutout(np.zeros((1, 1), np.float32), 0.5))
    if not isinstance(look.texture, PictureTexture):
        return look
    found = cutout(gltf.source, look.texture.asset.path, threshold / factor, name, "alpha")
    if found is not None and mode == "BLEND":
        gltf.source.notes.say(f"{name!r} is cut out where its opacity is below one half; blending is not rendered")
    return replace(look, cutout=found)


def _picture_of(gltf: Gltf, reference: dict[str, Any] | None, what: str) -> _Picture | None:
    if reference is None:
        return None
    change = reference.get("extensions", {}).get("KHR_texture_transform", {})
    texture = gltf.document["textures"][reference["index"]]
    extensions = texture.get("extensions", {})
    number = extensions.get("EXT_texture_webp", {}).get("source", texture.get("source"))
    uv_set = int(change.get("texCoord", reference.get("texCoord", 0)))
    if number is None:
        gltf.source.notes.say(f"{what} is in a format that is not read ({', '.join(extensions) or 'none stated'})")
        return _Picture(None, uv_set, _transform(gltf, change))
    return _Picture(_image(gltf, number, what), uv_set, _transform(gltf, change))


def _image(gltf: Gltf, number: int, what: str) -> PictureTexture | None:
    image = gltf.document["images"][number]
    source = gltf.source
    try:
        if "bufferView" in image:
            content = view_content(gltf, image["bufferView"])[0]
        else:
            content = uri_content(source, image["uri"], what)
        path = kept_picture(source, content, what)
    except InputError as error:
        source.notes.say(str(error))
        return None
    except BROKEN:
        source.notes.say(f"{what}: expected a picture inside the file, found none")
        return None
    return picture(source, path, what)


def _transform(gltf: Gltf, change: dict[str, Any]) -> np.ndarray:
    """Return the matrix of KHR_texture_transform: scale, then rotation, then offset."""
    if not change:
        return _IDENTITY
    du, dv = _signed(gltf, change, "offset", 2, 0.0)
    su, sv = _signed(gltf, change, "scale", 2, 1.0)
    (angle,) = _signed(gltf, change, "rotation", 1, 0.0)
    cos, sin = math.cos(angle), math.sin(angle)
    turn = np.array([[cos, sin, 0.0], [-sin, cos, 0.0], [0.0, 0.0, 1.0]])
    shift = np.array([[1.0, 0.0, du], [0.0, 1.0, dv], [0.0, 0.0, 1.0]])
    return shift @ turn @ np.diag([su, sv, 1.0])


def _same_place(gltf: Gltf, one: _Picture, other: _Picture, name: str) -> bool:
    """Return whether two pictures lie on the surface alike; a material has one set of texture coordinates here."""
    if one.uv_set == other.uv_set and np.allclose(one.uv_T_uv, other.uv_T_uv):
        return True
    gltf.source.notes.say(f"{name!r}: a picture with texture coordinates of its own is not used")
    return False


def _coloured(base: _Picture | None, factor: tuple[float, ...]) -> PictureTexture | UniformTexture:
    colour = _reflectance(np.array(factor))
    if base is None or base.texture is None:
        return UniformTexture(colour=colour)
    return base.texture.model_copy(update={"factor": colour})


def _reflectance(colour: np.ndarray) -> tuple[float, float, float]:
    red, green, blue = np.clip(colour, 0.0, 1.0).tolist()
    return red, green, blue


def _numbers(gltf: Gltf, record: dict[str, Any], field: str, count: int, default: float) -> tuple[float, ...]:
    """Return a factor, in [0, 4] (one index of refraction is no fraction)."""
    return tuple(min(max(value, 0.0), 4.0) for value in _signed(gltf, record, field, count, default))


def _signed(gltf: Gltf, record: dict[str, Any], field: str, count: int, default: float) -> tuple[float, ...]:
    stored = record.get(field, [default] * count)
    values = stored if isinstance(stored, list) else [stored]
    numbers = all(isinstance(value, int | float) and not isinstance(value, bool) for value in values)
    if len(values) != count or not numbers or not all(math.isfinite(value) for value in values):
        expected = f"finite numbers for {field}" if count > 1 else f"a finite number for {field}"
        raise InputError(gltf.source.path, expected, ascii(stored)[:40])
    return tuple(float(value) for value in values)
