"""Random scenes through every door: nothing foreign, nothing silent, the same however they are written."""

import pytest
from doors import DOORS
from judging import judge

#: Scenes of a door, and how many one test takes: `make test` runs two, `make check` all; `make fuzz` takes any.
SCENES, AT_ONCE = 30, 5


@pytest.mark.by_day(*(f"{door}-{first}" for door in DOORS for first in (0, AT_ONCE)))
@pytest.mark.parametrize("first", range(0, SCENES, AT_ONCE))
@pytest.mark.parametrize("door", DOORS)
def test_scenes_have_no_faults(door, first):
    found = {}
    for number in range(first, first + AT_ONCE):
        if faults := judge(DOORS[door], number).faults:
            found[number] = faults
    assert not found
