"""Every way into the package, with its scenes by number."""

from bricks import brick_body, brick_indented, cable_on_posts
from files import deck_beside_python, febio_beside_python, scene_file_beside_python
from half_spaces import half_space_dragged, half_space_pressed
from joints import bodies_and_ligaments, joint_beside_scene
from judging import Door
from members import members_touching
from scenes import block_pressed, path_of_steps, row_of_bodies, rows_and_stacks
from sections import section_pressed
from soft import soft_pressed
from solids import meshed_solid
from windows import local_body

SPACE = ("in other units", "turned about z", "mirrored", "renumbered", "swapped", "turned", "in small units")
PLANE = ("in other units", "mirrored", "renumbered", "swapped", "in small units")
UNITS = ("in other units", "in small units")

DOORS = {
    door.name: door
    for door in (
        Door("blocks", block_pressed, (*SPACE, "by wolfe", "by nnls", "by projected-cg")),
        Door("stacks", rows_and_stacks, SPACE, every=2),
        Door("rows", row_of_bodies, (*SPACE, "without copies"), every=2, at_once=3),
        Door("sections", section_pressed, PLANE),
        # up to 1.6e-8 in the first thirty scenes as they are written here
        Door("soft bodies", soft_pressed, SPACE, certificate=1e-7, every=2, at_once=2),
        Door("paths", path_of_steps, (*SPACE, "resumed")),
        Door("half-spaces", half_space_pressed, (*UNITS, "mirrored")),
        Door("dragged half-spaces", half_space_dragged, (*UNITS, "mirrored")),
        Door("local bodies", local_body, (*UNITS, "turned about z", "renumbered"), every=2, at_once=3),
        Door("brick bodies", brick_body, SPACE),
        Door("large bricks", brick_indented, (*UNITS, "mirrored"), every=3, at_once=1),
        Door("cables", cable_on_posts, UNITS, every=2),
        Door("slender members", members_touching, (*UNITS, "turned", "mirrored", "turned about z"), every=3),
        Door("solids by gmsh", meshed_solid, SPACE, every=2, at_once=2),
        Door("ligaments", bodies_and_ligaments, SPACE, every=3, at_once=2),
        Door("poses of joints", joint_beside_scene, UNITS, every=5, at_once=3),
        Door("decks", deck_beside_python, ("in other units", "renumbered"), every=2),
        Door("FEBio decks", febio_beside_python, ("in other units", "renumbered"), every=2),
        Door("scene files", scene_file_beside_python, ("in other units",), every=2),
    )
}
