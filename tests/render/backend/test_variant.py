"""The backend never crashes, never quietly picks a bad LLVM, and says exactly what to install."""

from __future__ import annotations

import os
import subprocess
import sys
from pathlib import Path

import pytest

from glassware.core.errors import InputError
from glassware.render.backend import llvm, trial
from glassware.render.backend.variant import activate

#: Where Debian and Ubuntu put LLVM libraries.
DEBIAN = Path("/usr/lib/x86_64-linux-gnu")

#: Versions that abort the process (15, 16) or that Dr.Jit refuses (14), where a machine has them.
BAD = [path for name in ("libLLVM-14.so.1", "libLLVM-15.so.1", "libLLVM-16.so.1") if (path := DEBIAN / name).is_file()]


def run(program: list[str], **environment: str) -> subprocess.CompletedProcess[str]:
    kept = {name: value for name, value in os.environ.items() if name != llvm.LLVM_PATH}
    return subprocess.run(
        [sys.executable, "-P", *program],
        env=kept | environment,
        capture_output=True,
        text=True,
        check=False,
        timeout=120,
    )


@pytest.fixture
def empty_memory(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path / "cache"))
    return tmp_path / "cache" / "glassware" / "backend.json"


@pytest.fixture
def good_llvm(backend: str) -> Path:
    assert backend == "llvm_ad_rgb"
    return Path(os.environ[llvm.LLVM_PATH])


@pytest.fixture
def trials(monkeypatch: pytest.MonkeyPatch) -> list[str]:
    """Every trial that is made from here on is noted, and then really made."""
    made = []
    really = trial.passes

    def noting(variant: str, environment: dict[str, str]) -> bool:
        made.append(environment[llvm.LLVM_PATH])
        return really(variant, environment)

    monkeypatch.setattr(trial, "passes", noting)
    return made


def test_the_active_variant_computes(backend: str) -> None:
    import drjit as dr
    import mitsuba as mi

    assert mi.variant() == backend
    assert dr.all(dr.minimum(mi.Float([1, 2, 3]), 2) == mi.Float([1, 2, 2]))


def test_the_library_that_was_chosen_is_the_one_in_the_process(good_llvm: Path) -> None:
    import drjit as dr

    assert dr.detail.llvm_version()[0] >= llvm.OLDEST
    mapped = Path("/proc/self/maps")
    if not mapped.exists():
        pytest.skip("this system does not list a process's libraries")
    loaded = {line.split()[-1] for line in mapped.read_text().splitlines() if "libLLVM" in line}
    assert loaded == {str(good_llvm.resolve())}


def test_activating_again_keeps_the_variant(backend: str) -> None:
    assert [activate(), activate(backend)] == [backend, backend]


def test_an_unknown_variant_is_refused_by_name(backend: str) -> None:
    with pytest.raises(InputError, match=rf"expected one of .*{backend}.*, found 'gpu'"):
        activate("gpu")


def test_a_variant_without_kernels_is_refused_by_name(backend: str) -> None:
    with pytest.raises(InputError, match=r"backend: expected one of llvm_ad_rgb.*'scalar_rgb'"):
        activate("scalar_rgb")
    assert activate() == backend


@pytest.mark.skipif(not BAD, reason="this machine has no LLVM 14, 15 or 16 in Debian's folder")
@pytest.mark.parametrize("library", BAD, ids=lambda path: path.name)
def test_a_bad_library_that_the_user_names_is_refused_and_takes_only_the_child_down(
    library: Path, empty_memory: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv(llvm.LLVM_PATH, str(library))
    with pytest.raises(InputError, match=rf"{llvm.LLVM_PATH}.*{library}.*apt-get install libllvm19"):
        llvm.find_llvm()
    assert not empty_memory.exists()


def test_a_named_library_that_is_missing_or_no_library_is_refused(
    tmp_path: Path, empty_memory: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    fake = tmp_path / "libLLVM.so.19.1"
    monkeypatch.setenv(llvm.LLVM_PATH, str(fake))
    with pytest.raises(InputError, match=f"no file {fake}"):
        llvm.find_llvm()
    fake.write_text("not a library")
    with pytest.raises(InputError, match=f"{fake}, which does not work"):
        llvm.find_llvm()


@pytest.mark.skipif(not BAD, reason="this machine has no LLVM 14, 15 or 16 in Debian's folder")
def test_a_bad_library_under_a_newer_name_is_passed_over(
    tmp_path: Path, good_llvm: Path, empty_memory: Path, trials: list[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    bad, good = tmp_path / "libLLVM.so.23.1", tmp_path / "libLLVM-17.so.1"
    bad.symlink_to(BAD[-1])
    good.symlink_to(good_llvm)
    monkeypatch.delenv(llvm.LLVM_PATH)
    monkeypatch.setattr(llvm, "library_folders", lambda: [tmp_path])
    assert llvm.find_llvm() == good
    assert trials == [str(bad), str(good)]


@pytest.mark.parametrize(
    ("names", "found"), [([], "found none"), (["libLLVM.so.22.1"], "found only .*libLLVM.so.22.1")]
)
def test_a_machine_without_a_good_library_is_told_what_to_install(
    names: list[str], found: str, tmp_path: Path, empty_memory: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    for name in names:
        (tmp_path / name).write_text("not a library")
    monkeypatch.delenv(llvm.LLVM_PATH, raising=False)
    monkeypatch.setattr(llvm, "library_folders", lambda: [tmp_path])
    llvm.export_llvm_path()  # must not raise: a machine with a GPU needs no LLVM
    assert llvm.LLVM_PATH not in os.environ
    with pytest.raises(InputError, match=f"LLVM library of version 17 or newer, {found}.*apt-get install libllvm19"):
        llvm.find_llvm()


def test_a_trial_is_made_once_and_remembered(good_llvm: Path, empty_memory: Path, trials: list[str]) -> None:
    assert [llvm.find_llvm(), llvm.find_llvm()] == [good_llvm, good_llvm]
    assert trials == [str(good_llvm)]


def test_another_file_under_the_same_name_is_tried_anew(
    tmp_path: Path, good_llvm: Path, empty_memory: Path, trials: list[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    library = tmp_path / "libLLVM.so.19.1"
    library.symlink_to(good_llvm)
    monkeypatch.setenv(llvm.LLVM_PATH, str(library))
    llvm.find_llvm()
    library.unlink()
    library.write_text("replaced by a broken one")
    with pytest.raises(InputError, match="does not work"):
        llvm.find_llvm()
    assert len(trials) == 2


@pytest.mark.parametrize("content", [b"{", b"\xff\x00", b'{"a": 1}', b"[1, null]"])
def test_a_spoilt_memory_is_not_fatal_and_is_mended(
    content: bytes, good_llvm: Path, empty_memory: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(trial, "passes", lambda *_: True)
    empty_memory.parent.mkdir(parents=True)
    empty_memory.write_bytes(content)
    assert llvm.find_llvm() == good_llvm
    monkeypatch.setattr(trial, "passes", lambda *_: pytest.fail("the answer was not remembered"))
    assert llvm.find_llvm() == good_llvm


def test_a_memory_that_cannot_be_written_is_not_fatal(
    tmp_path: Path, good_llvm: Path, trials: list[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    (tmp_path / "file").write_text("a file where the cache folder should be")
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path / "file"))
    assert llvm.find_llvm() == good_llvm
    assert len(trials) == 1


@pytest.mark.parametrize(
    ("name", "version"),
    [
        ("libLLVM.so.19.1", 19),
        ("libLLVM-17.so.1", 17),
        ("libLLVM-14.0.6.so.1", 14),
        ("libLLVM-19.dylib", 19),
        ("libLLVM.so", None),
        ("libLLVM-19-rust.so", None),
        ("libLLVMCore.so.19", None),
    ],
)
def test_the_version_is_read_from_the_name(name: str, version: int | None) -> None:
    assert llvm.major_version(Path(name)) == version


def test_libraries_come_newest_first_and_each_file_once(tmp_path: Path) -> None:
    for name in ("libLLVM-17.so.1", "libLLVM-15.so.1", "libLLVM.so.22.1", "libLLVM-18.so.1"):
        (tmp_path / name).touch()
    (tmp_path / "libLLVM-22.so").symlink_to("libLLVM.so.22.1")
    versions = [llvm.major_version(path) for path in llvm.installed_libraries([tmp_path])]
    assert versions == [22, 18, 17]


@pytest.mark.skipif(not BAD, reason="this machine has no LLVM 14, 15 or 16 in Debian's folder")
def test_the_command_ends_with_one_line_and_code_2_where_nothing_works(tmp_path: Path) -> None:
    refused = run(
        ["-m", "glassware.render.backend.variant"], DRJIT_LIBLLVM_PATH=str(BAD[0]), XDG_CACHE_HOME=str(tmp_path)
    )
    assert (refused.returncode, refused.stdout) == (2, "")
    assert len(refused.stderr.splitlines()) == 1
    assert "libllvm19" in refused.stderr


def test_the_command_names_the_variant_it_chose() -> None:
    chosen = run(["-m", "glassware.render.backend.variant"])
    assert chosen.returncode == 0, chosen.stderr
    assert chosen.stdout.split()[0] in ("llvm_ad_rgb", "cuda_ad_rgb")


@pytest.mark.skipif(not BAD, reason="this machine has no LLVM 14, 15 or 16 in Debian's folder")
@pytest.mark.parametrize("library", BAD, ids=lambda path: path.name)
def test_a_bad_library_that_drjit_loaded_before_us_is_refused(library: Path) -> None:
    program = f"""
import os
os.environ["{llvm.LLVM_PATH}"] = "{library}"
import drjit
del os.environ["{llvm.LLVM_PATH}"]
from glassware.render.backend.variant import activate
activate("llvm_ad_rgb")
"""
    refused = run(["-c", program])
    assert refused.returncode == 1
    assert "expected glassware.render imported first" in refused.stderr.splitlines()[-1]


@pytest.mark.skipif(not hasattr(os, "sched_setaffinity"), reason="this system cannot bind a process to one core")
def test_a_process_with_one_core_reads_an_exr_file_without_waiting_for_ever(tmp_path: Path) -> None:
    program = f"""
import os
os.sched_setaffinity(0, {{min(os.sched_getaffinity(0))}})
from glassware.render.backend.variant import activate
activate("llvm_ad_rgb")
import drjit as dr, mitsuba as mi
mi.Bitmap(dr.ones(mi.TensorXf, (32, 32, 3))).write("{tmp_path / "one.exr"}")
assert dr.all(mi.TensorXf(mi.Bitmap("{tmp_path / "one.exr"}")) == 1, axis=None)
"""
    finished = run(["-c", program])
    assert finished.returncode == 0, finished.stderr
