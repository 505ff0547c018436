"""How the pictures of a scene are computed."""

from __future__ import annotations

from typing import Literal

from pydantic import Field, model_validator

from ...core.model import Model

#: Settings of optics as they are in nature, and those that only the path tracer can simplify.
_TRUE_OPTICS = {"glass_shadows": True, "air_gap": False, "refractivity": 1.0}
PATHS_ALONE = ("glass_shadows", "air_gap")


class Picture(Model):
    """How the pictures are computed."""

    spp: int = Field(
        default=64,
        ge=1,
        le=1_048_576,
        description="Mean samples per pixel of a picture; with `noise`, of each pass",
    )
    noise: float | None = Field(
        default=None,
        gt=0.0,
        lt=1.0,
        description="Relative error of the picture before the denoiser at which passes stop; none takes `spp` samples",
    )
    max_spp: int = Field(default=4096, ge=1, le=1_048_576, description="With `noise`: most samples per pixel")
    adaptive: bool = Field(default=True, description="Whether pixels that show glass get more samples")
    light: Literal["auto", "path", "shared"] = Field(
        default="auto",
        description="Path tracing for every picture (path), an irradiance cache filled once per scene (shared), or "
        "whichever suits the number of samples and the light (auto)",
    )
    keep_light: bool = Field(
        default=False, description="Whether to write the irradiance cache with the scene; implies `shared` light"
    )
    max_depth: int = Field(default=1024, ge=1, le=4096, description="Longest path [surfaces hit]")
    rr_depth: int = Field(default=16, ge=1, le=4096, description="Surfaces hit before Russian roulette begins")
    denoise: bool = Field(default=True, description="Whether to denoise the picture with Open Image Denoise")
    fireflies: Literal["keep", "remove"] = Field(
        default="keep",
        exclude_if=lambda choice: choice == "keep",
        description="Single bright pixels of rare paths whose light cannot be spread without bleaching what is around: "
        "kept, so that the mean of the light is right, or removed, as suits training with few samples",
    )
    glass_shadows: bool = Field(
        default=True,
        exclude_if=lambda on: on,
        description="Whether glass casts shadows and caustics; without them light reaches opaque surfaces as if there "
        "were no glass, as in renderers that leave both out. Needs path tracing",
    )
    air_gap: bool = Field(
        default=False,
        exclude_if=lambda on: not on,
        description="Whether a film of air, too thin to see, lies between glass and liquids, as in renderers that nest "
        "meshes. Labels know nothing of it. Needs path tracing",
    )
    refractivity: float = Field(
        default=1.0,
        ge=0.0,
        le=2.0,
        exclude_if=lambda factor: factor == 1.0,
        description="Factor on the index less one of all media in pictures; 0: light goes straight through glass, "
        "without reflections. Labels keep the true index",
    )
    layers: int = Field(default=16, ge=0, le=64, description="Surfaces recorded along each pixel's unrefracted ray")
    refraction: bool = Field(default=True, description="Whether to record each pixel's refracted ray")
    spectral: bool = Field(default=False, description="Whether to render wavelengths instead of red, green and blue")
    camera: Literal["ideal", "d435", "phone", "webcam"] = Field(
        default="ideal",
        exclude_if=lambda name: name == "ideal",
        description="What takes the pictures: the ideal camera, or one with lens, noise and processing",
    )
    dispersion: bool = Field(default=False, description="Whether indices depend on the wavelength; needs `spectral`")

    @property
    def simplified(self) -> dict[str, tuple[str, str]]:
        """What is simplified in the optics of pictures: by setting, what is true and what was given."""
        choices = {
            "glass_shadows": ("yes", "yes" if self.glass_shadows else "no"),
            "air_gap": ("no", "yes" if self.air_gap else "no"),
            "refractivity": ("1", f"{self.refractivity:g}"),
        }
        return {name: choice for name, choice in choices.items() if getattr(self, name) != _TRUE_OPTICS[name]}

    @model_validator(mode="after")
    def _fit_together(self) -> Picture:
        if self.dispersion and not self.spectral:
            raise ValueError("dispersion: expected spectral to be on as well, found it off")
        if self.light == "shared" and self.spectral:
            raise ValueError("light: expected path or auto where spectral is on, found shared")
        for name, (true, found) in self.simplified.items():
            if name in PATHS_ALONE and (self.light == "shared" or self.keep_light):
                cause = "keep_light" if self.keep_light else "light shared"
                raise ValueError(f"{name}: expected {true} with {cause}, found {found}")
        if self.keep_light and (self.light == "path" or self.spectral):
            found = "path" if self.light == "path" else "spectral on"
            raise ValueError(f"keep_light: expected light to be stored, found {found}")
        return self
