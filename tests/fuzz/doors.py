"""Every way into the package, with its scenes by number."""

from bricks import brick_body, brick_indented, cable_on_posts
from files import deck_beside_python, scene_file_beside_python
from half_spaces import half_space_dragged, half_space_pressed
from judging import Door
from scenes import block_pressed, path_of_steps, rows_and_stacks
from sections import section_pressed
from windows import local_body

SPACE = ("in other units", "turned about z", "mirrored", "renumbered", "swapped", "turned", "in small units")
PLANE = ("in other units", "mirrored", "renumbered", "swapped", "in small units")
UNITS = ("in other units", "in small units")

DOORS = {
    door.name: door
    for door in (
        Door("blocks", block_pressed, (*SPACE, "by wolfe", "by nnls", "by projected-cg")),
        Door("stacks", rows_and_stacks, SPACE),
        Door("sections", section_pressed, PLANE),
        Door("paths", path_of_steps, (*SPACE, "resumed")),
        Door("half-spaces", half_space_pressed, (*UNITS, "mirrored")),
        Door("dragged half-spaces", half_space_dragged, (*UNITS, "mirrored")),
        Door("local bodies", local_body, (*UNITS, "turned about z", "renumbered")),
        Door("brick bodies", brick_body, SPACE),
        Door("large bricks", brick_indented, (*UNITS, "mirrored")),
        Door("cables", cable_on_posts, UNITS),
        Door("decks", deck_beside_python, ("in other units", "renumbered")),
        Door("scene files", scene_file_beside_python, ("in other units",)),
    )
}
