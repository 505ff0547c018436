"""The options that people use most, by command: what ``--help`` shows, in sections. ``--help-all`` shows the rest.

A command without an entry shows all of its options. `tests/dataset/settings/test_help_page.py` refuses a name that is
no option of its command any more.
"""

from __future__ import annotations

#: Title of a section, and its options by the names that are typed.
CommonSection = tuple[str, tuple[str, ...]]

#: What every command that makes scenes has.
_SCENE: tuple[CommonSection, ...] = (
    (
        "objects",
        (
            "--vessel-count",
            "--vessels.categories",
            "--vessels.glasses",
            "--vessels.liquids",
            "--vessels.fill",
            "--prop-count",
        ),
    ),
    ("your own files", ("--hdri-dir", "--mesh-dir", "--vessel-dir", "--texture-dir", "--cameras.poses")),
    ("cameras and pictures", ("--cameras.preset", "--views", "--width", "--height", "--spp")),
)

#: By the name of the command.
COMMON: dict[str, tuple[CommonSection, ...]] = {
    "render-scene": (
        ("scene", ("--seed", "--scene", "--preset", "--config", "--out", "--write", "--verbose")),
        *_SCENE,
    ),
    "build-dataset": (
        ("scenes", ("--scenes", "--count", "--seed", "--preset", "--config", "--out", "--write")),
        ("work", ("--workers", "--shard", "--yes")),
        *_SCENE,
    ),
    "glassware export": (
        ("export", ("DIRECTORY", "--format", "--out")),
        ("what of it", ("--split", "--labels", "--vessels-only", "--eye", "--copy-pictures")),
        ("of some formats", ("--liquids", "--polygons", "--layers", "--licence")),
    ),
    "glassware train": (
        ("run", ("DATA", "--network", "--config", "--out", "--resume")),
        ("training", ("--seed", "--steps", "--batch", "--views.count", "--machine.accelerator", "--machine.workers")),
    ),
    "glassware tables": (
        ("table", ("DATA", "--experiment", "--config", "--out", "--split", "--compare")),
        ("runs", ("--budget", "--seeds", "--only", "--checkpoints", "--batch", "--machine.accelerator")),
    ),
}
