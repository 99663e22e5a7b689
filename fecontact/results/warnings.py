"""Warnings of modelling and discretisation errors of a certified result, each with a figure and a remedy.

A check is a function of the result that yields sentences; `CHECKS` lists them. A note is for information only.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator

import numpy as np

from fecontact.common.error_estimate import LARGEST_ERROR, percent
from fecontact.halfspace.validity import validity_warnings
from fecontact.results.checks.linearisation import BEARABLE, linearisation_error
from fecontact.results.checks.overlaps import undeclared_overlaps
from fecontact.results.checks.resolution import coarse_pressures, overlap_between_nodes, overlap_left, springs_at_nodes
from fecontact.results.checks.rims import contact_at_rims
from fecontact.results.checks.tall_cells import held_across, tall_cells
from fecontact.results.convergence import accuracy_text, asked
from fecontact.results.solved_scene import SolvedScene

#: Strain above which a result warns: the relative error of small-strain elasticity is of the size of the strain.
LARGEST_STRAIN = 0.05
#: Motion, relative to a body's size, above which it has moved.
LEAST_MOVED = 1e-9
#: Error of linearised motions above which a result warns whose poses were carried along already: nothing else mends it,
#: so that less than a percent, of the size of other errors of modelling, needs no action.
UNMENDED = 0.01
#: What errors of forces and motions do where elements are too stiff.
SIGNS = {"force": "large", "approach": "small", "tilt": "small"}


def unborne_motions(result: SolvedScene) -> Iterator[str]:
    """Warnings of motions and deflections too large for linearisation."""
    error = linearisation_error(result)
    # poses take up motions of bodies, and neither deflections nor the shift of a contact by them; directions that
    # change by no more than twice the turn of a body change by its motion
    turned = error.direction <= 2 * np.sqrt(2 * error.stretch)
    carries = not result.originals and (error.deflected < 1 or turned)
    if error.worst > (BEARABLE if carries else UNMENDED) or error.friction > LARGEST_ERROR:
        if not np.isfinite(error.gap):
            what = "linearised motions lose or overlook the contact"
        else:
            rubbed = f", change tractions of friction by {percent(error.friction)}" if error.friction > BEARABLE else ""
            what = (
                f"linearised motions leave out {100 * error.gap / error.approach:.2g} % of the indentation in gaps and "
                f"{error.direction:.2g} rad in directions of forces{rubbed}, and stretch bodies by "
                f"{100 * error.stretch:.2g} %"
            )
        if carries:
            remedy = "Use finite_motion='auto' (or True), which carries the poses along."
        else:
            remedy = (
                "Carrying the poses along does not mend it: start nearer to the contact, hold motions that find no "
                "rest, stiffen what bends far, or use the bricks of fecontact.ancf, whose contacts follow deflections."
            )
        yield f"Bodies move or turn far: {what}. {remedy}"
    elif result.carried is not None and result.carried.rest > UNMENDED:
        yield (
            "Bodies move or turn far: the poses have not settled, and the motions would go on by "
            f"{100 * result.carried.rest:.2g} %. The load may find no rest: hold the motion, or apply less."
        )


def pushed_aside(result: SolvedScene) -> Iterator[str]:
    """Warnings of bodies that overlap alone has moved, until nothing touched them."""
    if result.loading.magnitude or any(contact.active.any() for contact in result.contacts):
        return
    for number, (body, size) in enumerate(zip(result.scene.bodies, result.scene.sizes, strict=True)):
        given = (result.originals or result.scene.bodies)[number]
        motion = result.rigid_motion(given)
        moved = np.concatenate([motion.translation, size * motion.rotation])
        moved[list(result.loading.frames[number].prescribed_components)] = 0.0
        if (most := float(np.abs(moved).max())) > LEAST_MOVED * size:
            yield (
                f"Nothing touches any more: {body.name!r} was pushed aside by what overlapped it, by {most:.2g}, as "
                "neither a support nor friction holds it. Hold that motion, if it is to be pressed."
            )


def carried_motions(result: SolvedScene) -> Iterator[str]:
    """Note on what carrying the poses has changed, or on what is left out where it has not converged."""
    if (carried := result.carried) is not None:
        yield (
            f"Poses were carried along: rigid motions differ by {100 * carried.motion:.2g} % and forces of contacts by "
            f"{100 * carried.force:.2g} % from those of linearised motions (finite_motion=False); "
            f"{100 * carried.rest:.1g} % of the motions are still linearised."
        )
    elif result.originals and result.linearisation is not None and BEARABLE < result.linearisation.worst <= UNMENDED:
        yield (
            f"Poses could not be carried along: linearised motions leave out {100 * result.linearisation.worst:.2g} %, "
            "in gaps of the indentation, in directions of forces or in lengths."
        )


def large_strains(result: SolvedScene) -> Iterator[str]:
    """Warnings of strains too large for small-strain elasticity."""
    found = zip(result.scene.bodies, result.state.displacements, result.response_errors.primal, strict=True)
    displaced = {id(body): (u, errors) for body, u, errors in found}
    for body in result.elastic_bodies:
        u, errors = displaced[id(body)]
        strain = errors.largest if len(errors.cells) else float(np.nanmax(np.abs(body.model.gauss_strain(u))))
        if strain > LARGEST_STRAIN:
            yield f"{body.name!r} is strained by {100 * strain:.1f} %: small-strain elasticity is a guess there."


def strained_half_spaces(result: SolvedScene) -> Iterator[str]:
    """Warnings of strains and slopes too large for the theory of half-spaces, as of a half-space alone."""
    for contact in result.contacts:
        if (cells := contact.on_cells) is not None:
            number = result.scene.bodies.index(contact.slave)
            moved = result.loading.frames[number].modes(result.motions[number][:, None])[:, 0]
            into = (moved - contact.displacements[0]).reshape(-1, 3) @ cells.surface.normal
            found = validity_warnings(contact.slave, cells.pressure, cells.gap, into.reshape(cells.pressure.shape))
            yield from (f"{contact.slave.name!r}: {text}" for text in found)


def missed_accuracy(result: SolvedScene) -> Iterator[str]:
    """Warnings of a requested accuracy that was not reached, and of figures that are worse than what was asked."""
    steps = result.convergence
    if steps is None:
        return
    last, wanted = steps.steps[-1], asked(steps.accuracy)
    if not steps.met:
        yield (
            f"The accuracy {accuracy_text(steps.accuracy)} was not reached: the estimated error is "
            f"{last.text(steps.accuracy)}. {steps.reason[0].upper()}{steps.reason[1:]}."
        )
    loosest = max(wanted.values())
    worse = {name: error for name, error in last.errors.items() if name not in wanted and error > loosest}
    if worse:
        found = ", ".join(f"{name} {percent(error)}" for name, error in worse.items())
        ask = ", ".join(f"{name!r}: {value:g}" for name, value in (wanted | dict.fromkeys(worse, loosest)).items())
        yield (
            f"The accuracy {accuracy_text(steps.accuracy)} was asked of {' and '.join(wanted)}. Estimated errors of "
            f"other figures are larger: {found}. Ask for them by name, accuracy={{{ask}}}"
            f"{_better_cells(result, worse)}."
        )


def stiff_bodies(result: SolvedScene) -> Iterator[str]:
    """Warning of forces and motions that are off because the elements of the bodies are too stiff."""
    found = {name: v for name, v in vars(result.response_error).items() if v is not None and v > LARGEST_ERROR}
    if found and result.convergence is None:
        stiff = result.response_errors.stiff
        ways = {name: f"too {SIGNS[name]}" if stiff[name] else "off" for name in found}
        off = ", ".join(f"the {name} about {percent(v)} {ways[name]}" for name, v in found.items())
        what = "" if all(stiff[name] for name in found) else " or the faces in contact too large"
        ask = ", ".join(f"{name!r}: 0.05" for name in found)
        yield (
            f"The elements of the bodies are too stiff{what}: {off}. Refine the meshes or solve with accuracy={{{ask}}}"
            f"{_better_cells(result, found)}."
        )


def _better_cells(result: SolvedScene, figures: Iterable[str]) -> str:
    """Advice on linear cells, where figures are off because cells are too stiff."""
    linear = [b.name for b in result.elastic_bodies if b.mesh.cells.shape[1] == 8]
    if not linear or not set(figures) & set(SIGNS):
        return ""
    return f"; or give {linear[0]!r} cells of 20 nodes, mesh.upgraded(20), which bend better than those of 8"


def friction_not_unique(result: SolvedScene) -> Iterator[str]:
    """Warning of a solution with friction beyond which others exist or which is not stable."""
    if result.friction is not None and result.friction.orientation < 0:
        yield (
            "With this much friction the solution is not the only one, or not stable (the determinant of Newton's "
            "matrix has changed its sign). Follow the load in smaller steps by Scene.solve_path, and compare."
        )


def large_steps(result: SolvedScene) -> Iterator[str]:
    """Warnings of friction that smaller load steps would change."""
    for k, moved in () if result.step_end is None else result.step_end.moved.items():
        contact = result.contacts[k]
        assert contact.friction is not None
        changed, rubbed = (
            float(np.linalg.norm(size / np.sqrt(contact.friction.weights)))
            for size in (moved.changes, np.linalg.norm(contact.friction.forces, axis=1))
        )
        if changed > LARGEST_ERROR * rubbed:
            yield (
                f"The load steps are large: the tractions of friction between {contact.slave.name!r} and "
                f"{contact.master.name!r} may be off by about {percent(changed / rubbed)}, as steps in halves change "
                "what is pressed anew. Press in smaller steps."
            )


def single_step(result: SolvedScene) -> Iterator[str]:
    """Note on friction under loads applied at once."""
    if result.friction is not None and not result.follows_step:
        yield (
            "Friction depends on the order of loads: these act together, in one step from the unloaded state. "
            "Scene.solve_path applies them one after the other."
        )


def mended(result: SolvedScene) -> Iterator[str]:
    """Notes of corrections made by readers and surfaces."""
    notes = ((body.name, text) for body in result.scene.bodies for text in body.notes)
    yield from dict.fromkeys(f"{name!r}: {text}" for name, text in notes)


def unbounded_pressures(result: SolvedScene) -> Iterator[str]:
    """Notes of pressures without bound."""
    for contact in result.contacts:
        if (edge := contact.singular_edge) is not None:
            yield (
                f"The pressure between {contact.slave.name!r} and {contact.master.name!r} is {edge.peak}: its largest "
                f"value, {contact.max_pressure:.3g}, depends on the mesh. Round the edge to get one that does not."
            )


def warnings_of_scene(result: SolvedScene) -> Iterator[str]:
    """Warnings that the scene carries."""
    yield from result.scene.warnings


def warnings_of_meshes(result: SolvedScene) -> Iterator[str]:
    """Warnings that meshes carry."""
    yield from dict.fromkeys(f"{b.name!r}: {text}" for b in result.elastic_bodies for text in b.mesh.warnings)


def notes_of_scene(result: SolvedScene) -> Iterator[str]:
    """Notes that the scene carries."""
    yield from result.scene.notes


#: Checks for `ContactResult.warnings` and for `ContactResult.notes`.
CHECKS: tuple[Callable[[SolvedScene], Iterator[str]], ...] = (
    warnings_of_scene,
    warnings_of_meshes,
    unborne_motions,
    pushed_aside,
    large_strains,
    strained_half_spaces,
    held_across,
    contact_at_rims,
    undeclared_overlaps,
    overlap_left,
    overlap_between_nodes,
    coarse_pressures,
    springs_at_nodes,
    stiff_bodies,
    tall_cells,
    missed_accuracy,
    friction_not_unique,
    large_steps,
)
NOTES: tuple[Callable[[SolvedScene], Iterator[str]], ...] = (
    notes_of_scene,
    carried_motions,
    mended,
    single_step,
    unbounded_pressures,
)


def warnings_of(result: SolvedScene) -> tuple[str, ...]:
    """All warnings of a result."""
    return tuple(text for check in CHECKS for text in check(result))


def notes_of(result: SolvedScene) -> tuple[str, ...]:
    """All notes of a result."""
    return tuple(text for check in NOTES for text in check(result))
