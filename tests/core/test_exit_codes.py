from __future__ import annotations

import errno

import pytest

from glassware.core.errors import InputError
from glassware.core.exit_codes import WorkFailed, run_command


def _raise(error: BaseException, cause: BaseException | None = None) -> None:
    raise error from cause


def test_a_command_that_ends_well_is_0():
    assert run_command(lambda: None) == 0


def test_a_wrong_request_is_2_and_one_line(capsys):
    assert run_command(lambda: _raise(InputError("a.obj", "faces\nor so", "none"))) == 2
    assert capsys.readouterr().err == "a.obj: expected faces or so, found none\n"


@pytest.mark.parametrize(
    "error", [(KeyboardInterrupt(),), (RuntimeError("dr.while_loop(): an exception"), KeyboardInterrupt())]
)
def test_ctrl_c_is_130_also_where_another_error_wraps_it(capsys, error):
    assert run_command(lambda: _raise(*error)) == 130
    assert capsys.readouterr().err == "stopped; no incomplete files are left\n"


@pytest.mark.parametrize("error", [RuntimeError("ours"), ValueError("ours"), KeyError("ours")])
def test_a_fault_of_ours_stays_a_traceback(error):
    with pytest.raises(type(error), match="ours"):
        run_command(lambda: _raise(error))


def test_a_loop_that_is_stopped_while_it_is_recorded_tells_of_ctrl_c(backend):
    import drjit as dr
    import mitsuba as mi

    def body(i):
        raise KeyboardInterrupt

    def record():
        dr.while_loop((dr.arange(mi.UInt32, 4),), lambda i: i < 9, body)

    assert run_command(record) == 130


@pytest.mark.parametrize(
    ("error", "says"),
    [
        (WorkFailed("2 scenes failed"), "2 scenes failed\n"),
        (OSError(errno.ENOSPC, "No space left on device"), "no room to write: [Errno 28] No space left on device\n"),
        (
            OSError(errno.EROFS, "Read-only file system"),
            "writing is no longer permitted: [Errno 30] Read-only file system\n",
        ),
    ],
    ids=["work", "full", "read-only"],
)
def test_work_that_failed_for_a_known_reason_is_1_and_one_line(capsys, error, says):
    assert run_command(lambda: _raise(error)) == 1
    assert capsys.readouterr().err == says
