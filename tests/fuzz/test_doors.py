"""Random scenes through every door: nothing foreign, nothing silent, the same however they are written."""

import pytest
from doors import DOORS
from judging import judge

#: Scenes of a door, and how many one test takes: `make test` runs two, `make check` all; `make fuzz` takes any.
SCENES, AT_ONCE = 30, 5
#: Faults that are known, by door and number: the diagonal along which the outline's triangles cut a face of four nodes
#: follows the numbering, which shows in the area of a contact of three faces.
KNOWN = {("stacks", 9): {"differs mirrored"}}


@pytest.mark.by_day(*(f"{door}-{first}" for door in DOORS for first in (0, AT_ONCE)))
@pytest.mark.parametrize("first", range(0, SCENES, AT_ONCE))
@pytest.mark.parametrize("door", DOORS)
def test_scenes_have_no_faults(door, first):
    found = {}
    for number in range(first, first + AT_ONCE):
        faults = judge(DOORS[door], number).faults
        assert KNOWN.get((door, number), set()) <= set(faults), "a known fault is gone: take it off the list"
        if new := {kind: faults[kind] for kind in faults if kind not in KNOWN.get((door, number), ())}:
            found[number] = new
    assert not found
