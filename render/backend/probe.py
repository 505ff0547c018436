"""A trial of one Mitsuba variant, run as a child process because a bad LLVM aborts the process that loads it.

``python -P -m glassware.render.backend.probe llvm_ad_rgb`` exits with 0 only if the variant compiles and runs right.
"""

from __future__ import annotations

import resource
import sys

import drjit as dr
import mitsuba as mi

#: Lanes of the trial; more than one SIMD register of any machine, so that vector code is generated.
_LANES = 64

#: Both results are exact up to float32 rounding of values near 1.
_TOLERANCE = 1e-5


def minimum_is_right() -> bool:
    """Compile minimum and maximum, the operations that LLVM 15 and 16 cannot select."""
    x = dr.linspace(mi.Float, 0, 1, _LANES)
    folded = dr.minimum(x, 0.5) + dr.maximum(x, 0.5)
    return bool(dr.all(dr.abs(folded - (x + 0.5)) < _TOLERANCE))


def trace_is_right() -> bool:
    """Trace rays down the z axis onto a unit sphere: they travel 3 - sqrt(1 - x^2)."""
    scene = mi.load_dict({"type": "scene", "sphere": {"type": "sphere"}})
    x = dr.linspace(mi.Float, -0.5, 0.5, _LANES)
    hit = scene.ray_intersect(mi.Ray3f(mi.Point3f(x, 0, 3), mi.Vector3f(0, 0, -1)))
    return bool(dr.all(dr.abs(hit.t - (3 - dr.sqrt(1 - dr.square(x)))) < _TOLERANCE * 3))


def main() -> int:
    """Try the variant named on the command line; 0 if all is right, 1 if a result is wrong."""
    # An abort is an expected answer here, not a crash to keep a core file of.
    resource.setrlimit(resource.RLIMIT_CORE, (0, 0))
    mi.set_variant(sys.argv[1])
    return 0 if minimum_is_right() and trace_is_right() else 1


if __name__ == "__main__":
    sys.exit(main())
