"""The documents do not promise what is not there: links lead somewhere, commands exist."""

from __future__ import annotations

import re
import tomllib
from itertools import chain
from pathlib import Path

import pytest

REPOSITORY = Path(__file__).resolve().parents[1]

DOCUMENTS = sorted([*REPOSITORY.glob("*.md"), *(REPOSITORY / "docs").rglob("*.md")])

each_document = pytest.mark.parametrize("path", DOCUMENTS, ids=lambda path: str(path.relative_to(REPOSITORY)))

#: Longest line of a page outside tables, as in the code [characters].
LONGEST_LINE = 120

#: [text](target), ![text](target "title") and <img src="target">.
LINK = re.compile(r"\]\(\s*<?([^)\s>]+)[^)]*\)|<(?:img|a)\s[^>]*?(?:src|href)=\"([^\"]+)\"")

#: A fenced block, or a run of lines indented by four spaces after an empty line.
FENCED = re.compile(r"^```[^\n]*\n(.*?)^```", re.MULTILINE | re.DOTALL)
INDENTED = re.compile(r"(?:(?<=\n\n)|\A)((?:    [^\n]*\n?)+)")


def links(text: str) -> list[str]:
    """Return what a document links to."""
    return [first or second for first, second in LINK.findall(FENCED.sub("", text))]


def anchors(text: str) -> set[str]:
    """Return the anchors of a document's headings, as GitHub makes them."""
    headings = re.findall(r"^#+\s+(.*?)\s*$", FENCED.sub("", text), re.MULTILINE)
    return {re.sub(r"[^\w\- ]", "", heading.lower()).replace(" ", "-") for heading in headings}


def command_lines(text: str) -> list[list[str]]:
    """Return the words of each line in a document's code blocks, without prompts and comments."""
    blocks = FENCED.findall(text) + INDENTED.findall(FENCED.sub("", text))
    lines = [line.strip().removeprefix("$ ").split(" #")[0] for block in blocks for line in block.splitlines()]
    return [line.split() for line in lines if line and not line.startswith("#")]


@each_document
def test_internal_links_lead_somewhere(path: Path) -> None:
    for link in links(path.read_text("utf-8")):
        if re.match(r"[a-z][a-z0-9+.-]*:", link):
            continue
        target, _, anchor = link.partition("#")
        file = path.parent / target if target else path
        assert file.exists(), f"{link} leads nowhere"
        if anchor and file.suffix == ".md":
            assert anchor in anchors(file.read_text("utf-8")), f"{link}: no such heading"


@each_document
def test_commands_in_documents_exist(path: Path) -> None:
    scripts = tomllib.loads((REPOSITORY / "pyproject.toml").read_text("utf-8"))["project"]["scripts"]
    targets = set(re.findall(r"^([a-z-]+):", (REPOSITORY / "Makefile").read_text("utf-8"), re.MULTILINE))
    for words in command_lines(path.read_text("utf-8")):
        program, name = words[0], Path(words[0]).name
        if program == "make":
            named = [word for word in words[1:] if "=" not in word and not word.startswith("-")]
            assert set(named) <= targets, " ".join(words)
        elif name.startswith(("render-", "build-", "glassware")) and "/" not in name:
            assert name in scripts, " ".join(words)
        elif name.startswith("python"):
            programs = [word for word in words[1:] if word.endswith(".py")]
            assert all((REPOSITORY / word).is_file() for word in programs), " ".join(words)


@each_document
def test_lines_are_short_except_in_tables(path: Path) -> None:
    lines = path.read_text("utf-8").splitlines()
    assert [line for line in lines if len(line) > LONGEST_LINE and not line.startswith("|")] == []


def test_the_everyday_script_has_at_most_twelve_lines_and_one_import_of_ours() -> None:
    text = (REPOSITORY / "docs" / "guide.md").read_text("utf-8").partition("### Changed copies")[2]
    lines = [line for line in FENCED.findall(text)[0].splitlines() if line.strip()]
    assert len(lines) <= 12
    assert [line for line in lines if "import" in line] == ["import glassware as gw"]
    for step in ("load_scene", "with_glass", "with_dye", "with_camera", "Renderer", "save_png", "masks", ".Z"):
        assert any(step in line for line in lines), step


def test_every_dependency_has_a_row_with_its_reason() -> None:
    project = tomllib.loads((REPOSITORY / "pyproject.toml").read_text("utf-8"))["project"]
    required = [*project["dependencies"], *chain.from_iterable(project["optional-dependencies"].values())]
    names = {re.split(r"[\[<>=]", item)[0] for item in required} - {project["name"]}
    text = (REPOSITORY / "docs" / "dependencies.md").read_text("utf-8")
    rows = [[cell.strip() for cell in row.split("|")] for row in re.findall(r"^\|(.+)\|$", text, re.MULTILINE)]
    explained = {name for first, second, *_, reason in rows if reason for name in (first, second)}
    assert len(names) > 20
    assert names <= explained


def test_the_glossary_names_files_of_this_repository() -> None:
    text = (REPOSITORY / "CONTRIBUTING.md").read_text("utf-8")
    rows = re.findall(r"^\| .+ \|$", text.split("| word | meaning here | where |")[1].split("\n\n")[0], re.MULTILINE)
    assert len(rows) > 30
    missing = []
    for row in rows[1:]:  # the first is the line below the head
        named = re.findall(r"`([^`]+)`", row.split("|")[-2])
        missing += [row] if not named else [name for name in named if not (REPOSITORY / name).is_file()]
    assert not missing


def test_the_checks_see_links_anchors_and_commands() -> None:
    text = 'A [b](c.md#d) and ![p](q.png "t").\n\n## A heading, of `two`\n\n    make scene  # why\n'
    text += "\n```\n$ render-scene\n```\n"
    assert links(text) == ["c.md#d", "q.png"]
    assert anchors(text) == {"a-heading-of-two"}
    assert sorted(command_lines(text)) == [["make", "scene"], ["render-scene"]]
