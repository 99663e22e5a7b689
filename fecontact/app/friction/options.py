"""Studies of ``fecontact friction``; needs no numerical package."""

from __future__ import annotations

#: Studies and what they show.
STUDIES: dict[str, str] = {
    "mindlin": "a ball dragged within friction, beside Cattaneo and Mindlin",
    "fretting": "the same to and fro, beside Mindlin and Deresiewicz",
    "carter": "a roller that starts to roll under a tangential force, beside Carter",
    "block": "a block of finite elements on a rigid plane, held, then dragged to and fro, beside Coulomb's law",
}
