"""Wear of a scene's contacts along a path of loads, see `common.wear`.

Worn depth is at the nodes of the body that a contact names first, and goes with it. The other body keeps its shape.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Any

import numpy as np

from fecontact.common.arguments import mapping
from fecontact.common.arrays import Array
from fecontact.common.checks import positive
from fecontact.common.errors import InputError
from fecontact.common.path import Steps
from fecontact.common.wear import NO_CYCLE, check_change, faded, steady, worn_in_halves
from fecontact.contact.contact import Contact
from fecontact.contact.loads import LoadStep
from fecontact.contact.step_end import StepEnd, at_nodes
from fecontact.results.result import ContactResult
from fecontact.scene.finite_rotation import carried_poses
from fecontact.surfaces.facet_surface import with_nodes

if TYPE_CHECKING:
    from fecontact.scene.load_path import SceneSteps


@dataclass(frozen=True, eq=False)
class _At:
    """A state on the path: loads, the end of the step, its result if there is one, and the state before."""

    loads: LoadStep
    end: StepEnd
    result: ContactResult | None = None
    before: _At | None = None


@dataclass(frozen=True, eq=False)
class WornResult:
    """Result of a part of a step, and what its contacts have worn by their numbers, with changes by smaller steps."""

    at: _At
    worn: Array
    change: Array
    parts: tuple[ContactResult, ...] = ()

    @property
    def result(self) -> ContactResult:
        """The result."""
        assert self.at.result is not None
        return self.at.result


@dataclass(frozen=True, eq=False)
class WornSteps(Steps[WornResult]):
    """Load steps of a scene whose contacts wear, in the order of the numbers of these contacts.

    Attributes
    ----------
    way : SceneSteps
    wear : mapping of int to float
        Archard's coefficients by the numbers of contacts.
    cycles : sequence of float or None
        How often each step is passed.
    """

    way: SceneSteps
    wear: Mapping[int, float]
    cycles: Sequence[float | None]

    def part(
        self, k: int, before: WornResult | None, start: float, end: float, last: WornResult | None, known: Any = None
    ) -> WornResult:
        """Result at the end of a part of step k, worn; a step passed several times has parts of its cycles."""
        model, once = self.way.model, self.cycles[k] is None
        rest = _At(LoadStep(), StepEnd(tuple(body.pose for body in model.bodies)))
        state, worn = (rest, np.zeros(sum(self._sizes))) if last is None else (last.at, last.worn)
        half, found, worn, change = worn_in_halves(
            lambda share, at, depth: self._leg(k, share, at, depth),
            lambda length, share, depth, leg: self._worn(k, length, share, depth, leg),
            (start, end), state, worn, once,
        )  # fmt: skip
        result = found.result
        assert result is not None
        assert half.result is not None
        check_change(change, worn, result._state.scale, (start, end))
        if last is not None:
            change = faded(change, last.change, self._pressure(result), self._pressure(last.result), not once)
        contacts = list(result.contacts)
        for (i, depth), off in zip(self._by_contact(worn).items(), self._by_contact(change).values(), strict=True):
            error = float(np.abs(off).max(initial=0.0) / depth.max()) if depth.any() else 0.0
            contacts[i] = replace(contacts[i], wear_error=error)
        found = replace(found, result=replace(result, contacts=tuple(contacts), _follows_step=True))
        return WornResult(found, worn, change, (half.result,) if once else ())

    def joined(self, parts: Sequence[WornResult]) -> WornResult:
        """The last part; of a step passed once with the work and the sliding of all before it."""
        last = parts[-1]
        each = [one for part in parts for one in (*part.parts, part.result)]
        result = self.way.joined(each) if last.parts else last.result
        return replace(last, at=replace(last.at, result=result))

    def prints(self) -> Mapping[str, Mapping[str, str]]:
        """Fingerprints by part of each step by its number."""
        return self.way.prints()

    @property
    def _sizes(self) -> list[int]:
        """Numbers of nodes of the bodies that wear."""
        return [len(with_nodes(c.bodies[0].surface(c.surfaces[0])).points) for c in self._contacts if c.surfaces]

    @property
    def _contacts(self) -> list[Contact]:
        return [self.way.model.contacts[i] for i in self.wear]

    def _by_contact(self, values: Array) -> dict[int, Array]:
        """Values at the nodes of the bodies that wear, one after the other, by the numbers of contacts."""
        return dict(zip(self.wear, np.split(values, np.cumsum(self._sizes)[:-1]), strict=True))

    def _nodal(self, result: ContactResult, values: Sequence[Array]) -> Array:
        """Values at these nodes from those (n,) at the points of the contacts that wear."""
        sizes = zip(self.wear, values, self._sizes, strict=True)
        return np.concatenate([at_nodes(v, result._interfaces[i].pairing.nodes, np.arange(n)) for i, v, n in sizes])

    def _pressure(self, result: ContactResult) -> Array:
        return self._nodal(result, [result.contacts[i].pressure for i in self.wear])

    def _loads(self, k: int, share: float) -> LoadStep:
        """Loads a share of the way through step k; at its end if that is passed several times."""
        return self.way.loads(k, share if self.cycles[k] is None else 1.0)

    def _gone(self, last: _At, to: LoadStep, worn: Array, wearing: Array | None = None) -> _At:
        """The state at loads, from the last state, on a worn shape; with what wears off by unit pressure."""
        past = replace(last.end, forces=np.zeros(0), worn=self._by_contact(worn))
        past = past if wearing is None else replace(past, wearing=self._by_contact(wearing))
        poses = () if last.result is None else carried_poses(self.way.model, last.loads, to, past.poses)
        found = self.way.following(to, past, poses, last.result)
        return _At(to, self.way.end(found), found, replace(last, before=None))

    def _leg(self, k: int, share: float, last: _At, worn: Array) -> tuple[Array, _At]:
        """Slip at the nodes on a way to a share of step k on a worn shape, and the state there; of a steady cycle."""
        several = self.cycles[k] is not None

        def passage(start: _At) -> tuple[Array, Array, _At]:
            start = self._gone(start, self._loads(k - 1, 1.0), worn) if several else start
            at = self._gone(start, self._loads(k, share), worn)
            assert at.result is not None
            slips = []
            for friction in (at.result.contacts[i].friction for i in self.wear):
                assert friction is not None
                slips.append(np.where(friction.sticking, 0.0, np.linalg.norm(friction.slip, axis=1)))
            return self._nodal(at.result, slips), self._pressure(at.result), at

        if several:
            return steady(passage, last, k)
        slip, _, at = passage(last)
        return slip, at

    def _worn(self, k: int, length: float, share: float, worn: Array, leg: tuple[Array, _At]) -> Array:
        """Worn depth after a length of step k, by a leg on the shape before."""
        (slip, at), cycles = leg, self.cycles[k]
        assert at.before is not None
        k_of = np.repeat(list(self.wear.values()), self._sizes)
        wearing = k_of * slip * (1.0 if cycles is None else cycles * length)
        found = self._gone(at.before, self._loads(k, share), worn, wearing).result
        assert found is not None
        off = [found._interfaces[i].worn_off(found.contacts[i].forces) for i in self.wear]
        return np.asarray(worn + self._nodal(found, off))


def checked(
    model: Any, wear: Mapping[Contact, float], cycles: Sequence[Any], others: Mapping[str, bool]
) -> tuple[dict[int, float], list[float | None]]:
    """Coefficients by the numbers of contacts, and numbers of cycles.

    Raises
    ------
    InputError
        If a contact is not of the scene, is of a half-space or has infinite friction, a coefficient or a number of
        cycles is not positive, the first step has cycles, or something is asked for that wear is not offered with.
    """
    for name, given in others.items():
        if given:
            raise InputError(f"Wear is not offered together with {name}: leave it out.", code="wear-alone")
    numbers = {id(contact): i for i, contact in enumerate(model.contacts)}
    found = {}
    for contact, coefficient in mapping("wear", wear).items():
        if id(contact) not in numbers:
            raise InputError(f"Wear is given for {contact!r}, which is no contact of this scene.", code="not-in-scene")
        if np.isinf(contact.mu):
            raise InputError("Infinite friction has no sliding and no wear. Give a finite coefficient.", code="no-slip")
        if contact.overclosure is not None:
            raise InputError("A soft contact is not offered with wear: leave one out.", code="wear-alone")
        if any(body._matrix_free for body in contact.bodies):
            raise InputError(
                "Wear in scenes is of bodies with finite elements: press half-spaces with HalfSpace.press_path(wear=).",
                code="wear-body",
            )
        found[numbers[id(contact)]] = positive("the coefficient of wear", coefficient)
    counts = [None if n is None else positive("the number of cycles", n) for n in cycles]
    if counts[0] is not None:
        raise InputError(NO_CYCLE, code="no-cycle")
    return found, counts
