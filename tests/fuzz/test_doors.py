"""Random scenes through every door: nothing foreign, nothing silent, the same however they are written."""

import pytest
from doors import DOORS
from judging import judge

#: Scenes of a door: `make check` runs them all, `make test` those of the first test of a door; `make fuzz` any.
SCENES = 30
CASES = [(name, first) for name, door in DOORS.items() for first in range(0, SCENES, door.at_once)]


@pytest.mark.by_day(*(f"{name}-0" for name in DOORS))
@pytest.mark.parametrize(("door", "first"), CASES)
def test_scenes_have_no_faults(door, first):
    found = {}
    for number in range(first, min(first + DOORS[door].at_once, SCENES)):
        if faults := judge(DOORS[door], number).faults:
            found[number] = faults
    assert not found
