"""Our renderer against Blender's Cycles on the same five scenes: agreement, and time to equal error.

A study: it backs all tables of docs/cycles.md, last run 2026-11-22. It is not maintained beyond importing.

    python bench/studies/render_vs_cycles.py --cycles-python ~/bpy/bin/python
    python bench/studies/render_vs_cycles.py --cycles-python ~/bpy/bin/python --speed

Cycles comes as the package `bpy` 4.5 (LTS) for Python 3.11, in an environment of its own:

    python3.11 -m venv ~/bpy && ~/bpy/bin/pip install "bpy==4.5.*" "numpy<2"

Both draw the same triangles, normals, textures, environment and camera, with the description's longest path, a box
filter one pixel wide and no clamping. Media are clear, because Cycles' glass does not absorb.

Agreement: opaque surfaces are ideal diffusers, because the two principled models differ. Means of independent passes
are compared in blocks against the noise of both. Blocks that show rough glass do not decide: the two models of light
between the facets of a rough surface differ (Cycles scales its single-scattering lobe, ours is a walk).

Speed: opaque surfaces are what each renderer has for our materials, and each is measured against its own converged
reference, in exposed linear units, by the mean of (I - R)^2 / (R^2 + 0.01) less what the reference's own noise adds to
it. The targets are the errors that Cycles has after its denoiser at the two numbers of samples in `--levels`, evenly
spread; its adaptive sampling has rows of its own. Time is tracing and denoising; loading, the tree of triangles and
compilation have a row of their own. Both alternate on the same cores.
"""

from __future__ import annotations

import sys
from pathlib import Path

sys.path.append(str(Path(__file__).resolve().parents[1]))
from command import run
from cycles.agreement_rows import agreement_rows
from cycles.comparison import Options
from cycles.peer import cycles_python
from cycles.speed_rows import speed_rows
from table import report


def main(options: Options) -> int:
    """Compare and print."""
    python = cycles_python(options.cycles_python)
    rows, version = speed_rows(python, options) if options.speed else agreement_rows(python, options)
    facts = {"picture": f"{options.width}x{options.height}", "cycles": version, "threads": options.threads}
    if options.speed:
        return report("Time to equal error", rows, options.json_file, reference_spp=options.reference_spp, **facts)
    facts["samples"] = f"{options.passes} passes of {options.pass_spp}"
    return report("Agreement with Cycles", rows, options.json_file, block=options.block, **facts)


if __name__ == "__main__":
    sys.exit(run(Options, __doc__, main))
