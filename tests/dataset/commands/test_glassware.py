"""`glassware COMMAND` is the same as the command itself."""

import pytest

from glassware.dataset.commands.glassware import main


def test_render_is_render_scene(capsys):
    with pytest.raises(SystemExit) as stop:
        main(["render", "--help-all"])
    assert stop.value.code == 0
    assert "--cameras.views" in capsys.readouterr().out


@pytest.mark.parametrize("given", [[], ["rendre"]])
def test_an_unknown_command_is_one_line_that_names_the_known_ones_and_code_2(given, capsys):
    assert main(given) == 2
    told = capsys.readouterr().err
    assert told.count("\n") == 1
    assert "render" in told
