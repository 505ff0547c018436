"""A picture whose light cannot be is refused while it is made."""

from __future__ import annotations

from dataclasses import replace

import pytest

from glassware.render.pictures.integrator import trace
from glassware.render.pictures.picture import PATH_TRACER, LightError, Tracer, trace_picture


def test_light_without_bound_is_refused_with_its_place(loaded_glasses) -> None:
    def blown_up(*arguments):
        found = trace(*arguments)
        return replace(found, radiance=found.radiance * 1e25)  # squared it is beyond single precision

    tracer = Tracer(blown_up, PATH_TRACER.weights)
    camera = loaded_glasses.description.cameras[0]
    with pytest.raises(LightError, match=r"right picture: \d+ pixels without a finite radiance, the first in row \d+"):
        trace_picture(loaded_glasses, camera, "right", seed=1, tracer=tracer)
