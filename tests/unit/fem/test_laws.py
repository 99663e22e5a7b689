"""Hyperelastic laws: stress and moduli against differences of the energy, and closed forms of simple deformations."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
import pytest

import fecontact as fc
from fecontact.common.arrays import Array
from fecontact.common.material import FIRST, SECOND
from fecontact.fem.laws import CompressibleOgden, InvariantLaw, InvertedError, Law
from tests.refusals import refused

LAWS: dict[str, Law] = {
    "neo-hooke": fc.NeoHookean(E=1.0, nu=0.45),
    "st-venant": fc.StVenantKirchhoff(E=1.0, nu=0.3),
    "holmes-mow": fc.HolmesMow(E=1.0, nu=0.2, beta=0.3),
    "mooney": fc.MooneyRivlin(c10=0.4, c01=0.1, bulk=5.0),
    "ogden": fc.Ogden(mu=(0.4, 0.1, 0.2), alpha=(2.0, -2.0, 4.5), bulk=5.0),
    "compressible-ogden": CompressibleOgden(mu=(0.4, 0.1, 0.2), alpha=(2.0, -2.0, 4.5), lame=0.8),
}
FIBRES = fc.Fibres(LAWS["neo-hooke"], (1, 2, 2), ksi=0.5, alpha=1.5)


def deformations() -> Array:
    """General ones, one with two equal stretches, the rest and one with stretches that differ by 1e-7."""
    given = np.eye(3) + 0.25 * np.random.default_rng(1).standard_normal((6, 3, 3))
    given[:3] = np.diag([1.3, 0.8, 0.8]), np.eye(3), np.diag([1.1, 1.1 + 1e-7, 0.7])
    assert (np.linalg.det(given) > 0.1).all()
    return given


@pytest.mark.parametrize("law", [*LAWS.values(), FIBRES], ids=[*LAWS, "fibres"])
def test_stress_and_moduli_are_the_derivatives_by_order(law: Law) -> None:
    F = deformations()
    if law is FIBRES:  # taut and slack ones, none at the bend between
        F = F[3:]
        longer = ((F @ np.array([1, 2, 2]) / 3) ** 2).sum(axis=1) - 1
        assert longer.min() < -0.05 < 0.05 < np.abs(longer).min()
        assert longer.max() > 0.05
    G = np.random.default_rng(2).standard_normal(F.shape)
    at = law.response(F)
    d = (G + np.swapaxes(G, 1, 2)) / 2
    lie = np.zeros(F.shape)
    lie[:, FIRST, SECOND] = np.einsum("nij,nj->ni", at.all_moduli, d[:, FIRST, SECOND] * [1, 1, 1, 2, 2, 2])
    lie[:, SECOND, FIRST] = lie[:, FIRST, SECOND]
    rate = lie + G @ at.stress + at.stress @ np.swapaxes(G, 1, 2)
    power = (at.stress * G).sum(axis=(1, 2))
    errors = []
    for h in (2e-3, 1e-3):
        ahead, behind = (law.response(F + sign * h * G @ F) for sign in (1, -1))
        errors.append(
            (
                np.abs((ahead.energy - behind.energy) / (2 * h) - power).max(),
                np.abs((ahead.stress - behind.stress) / (2 * h) - rate).max(),
            )
        )
    # central differences are off by the square of their step
    assert np.array(errors[0]) / errors[1] == pytest.approx(4.0, abs=0.05)
    assert max(errors[1]) < 1e-3


@pytest.mark.parametrize("law", LAWS.values(), ids=LAWS)
def test_small_strains_follow_hooke_and_rotations_carry_the_stress(law: Law) -> None:
    strain = 1e-7 * np.array([[1.0, 0.3, -0.2], [0.3, -0.5, 0.7], [-0.2, 0.7, 2.0]])
    rest = law.at_rest
    hooke = rest.lame * np.trace(strain) * np.eye(3) + 2 * rest.shear_modulus * strain
    assert np.abs(law.cauchy(np.eye(3) + strain) - hooke).max() < 1e-6 * np.abs(hooke).max()
    turn = fc.rotation_about((1.0, 2.0, 3.0), 0.7)
    F = deformations()
    assert np.abs(law.cauchy(turn @ F) - turn @ law.cauchy(F) @ turn.T).max() < 1e-13
    assert np.abs(law.cauchy(F @ turn) - law.cauchy(F)).max() < 1e-12  # isotropic


def incompressible(stretch: float) -> dict[str, Array]:
    """Deformations without a change of volume."""
    return {
        "uniaxial": np.diag([stretch, stretch**-0.5, stretch**-0.5]),
        "biaxial": np.diag([stretch, stretch, stretch**-2]),
    }


def st_venant(s: float, t: float) -> float:
    """Its law along one stretch less that along another; the third is as either, at constant volume."""
    rest = LAWS["st-venant"].at_rest
    trace = (s**2 + t**2 + 1 / (s * t) ** 2 - 3) / 2
    return rest.lame * trace * (s**2 - t**2) + rest.shear_modulus * (s**2 * (s**2 - 1) - t**2 * (t**2 - 1))


def holmes_mow(a: float, b: float, c: float) -> float:
    """The stress along the squared stretch a less that along c: 2 (W1 + b W2) (a - c) at constant volume."""
    lame, mu = LAWS["holmes-mow"].at_rest.lame, LAWS["holmes-mow"].at_rest.shear_modulus
    Q = 0.3 / (lame + 2 * mu) * ((2 * mu - lame) * (a + b + c - 3) + lame * (a * b + b * c + c * a - 3))
    return float(np.exp(Q) * ((2 * mu - lame) + lame * b) / 2 * (a - c))


CLOSED: dict[str, dict[str, Callable[[float], float]]] = {
    "neo-hooke": {
        "uniaxial": lambda s: (s**2 - 1 / s) / 2.9,
        "biaxial": lambda s: (s**2 - s**-4) / 2.9,
    },
    "mooney": {
        "uniaxial": lambda s: 2 * (s**2 - 1 / s) * (0.4 + 0.1 / s),
        "biaxial": lambda s: 2 * (s**2 - s**-4) * (0.4 + 0.1 * s**2),
    },
    "st-venant": {
        "uniaxial": lambda s: st_venant(s, s**-0.5),
        "biaxial": lambda s: st_venant(s, s**-2),
    },
    "holmes-mow": {
        "uniaxial": lambda s: holmes_mow(s**2, 1 / s, 1 / s),
        "biaxial": lambda s: holmes_mow(s**2, s**2, s**-4),
    },
    "ogden": {
        "uniaxial": lambda s: sum(2 * m / a * (s**a - s ** (-a / 2)) for m, a in ((0.4, 2.0), (0.1, -2.0), (0.2, 4.5))),
        "biaxial": lambda s: sum(2 * m / a * (s**a - s ** (-2 * a)) for m, a in ((0.4, 2.0), (0.1, -2.0), (0.2, 4.5))),
    },
}


@pytest.mark.parametrize("stretch", [0.5, 0.9, 2.0])
@pytest.mark.parametrize("kind", ["uniaxial", "biaxial"])
@pytest.mark.parametrize("name", CLOSED)
def test_stress_of_a_stretch_at_constant_volume(name: str, kind: str, stretch: float) -> None:
    """Differences of principal stresses, Holzapfel (2000), section 6.5."""
    found = LAWS[name].cauchy(incompressible(stretch)[kind]).diagonal()
    assert found[0] - found[2] == pytest.approx(CLOSED[name][kind](stretch), rel=1e-12)


def test_simple_shear() -> None:
    """Rivlin's relations: s12 = 2 (W1 + W2) g, s11 - s33 = 2 W1 g^2, s22 - s33 = -2 W2 g^2."""
    g = 0.8
    F = np.eye(3) + g * np.outer([1, 0, 0], [0, 1, 0])
    rest = LAWS["holmes-mow"].at_rest
    grown = np.exp(0.3 * 2 * rest.shear_modulus / (rest.lame + 2 * rest.shear_modulus) * g**2) / 4
    for law, W1, W2 in (
        (LAWS["mooney"], 0.4, 0.1),
        (LAWS["neo-hooke"], 0.5 / 2.9, 0.0),
        (LAWS["holmes-mow"], grown * (2 * rest.shear_modulus - rest.lame), grown * rest.lame),
    ):
        s = law.cauchy(F)
        assert [s[0, 1], s[0, 0] - s[2, 2], s[1, 1] - s[2, 2]] == pytest.approx(
            [2 * (W1 + W2) * g, 2 * W1 * g**2, -2 * W2 * g**2], abs=1e-13
        )


def test_simple_shear_of_the_laws_of_other_measures() -> None:
    """F S F^T by hand of St. Venant and Kirchhoff; of Ogden (t(l) - t(1/l)) / (l + 1/l) with l - 1/l = g."""
    g = 0.8
    F = np.eye(3) + g * np.outer([1, 0, 0], [0, 1, 0])
    rest, s = LAWS["st-venant"].at_rest, LAWS["st-venant"].cauchy(F)
    across = rest.lame * g**2 / 2 + rest.shear_modulus * g**2
    exact = [rest.shear_modulus * g + g * across, 2 * rest.shear_modulus * g**2 + g**2 * across]
    assert [s[0, 1], s[0, 0] - s[2, 2]] == pytest.approx(exact, abs=1e-14)
    stretch = (g + np.sqrt(g**2 + 4)) / 2
    pull = sum(2 * m / a * (stretch**a - stretch**-a) for m, a in ((0.4, 2.0), (0.1, -2.0), (0.2, 4.5)))
    assert LAWS["ogden"].cauchy(F)[0, 1] == pytest.approx(pull / (stretch + 1 / stretch), abs=1e-13)


@pytest.mark.parametrize("stretch", [0.6, 0.95, 1.2])
def test_confined_compression(stretch: float) -> None:
    """Holmes & Mow (1990): M/2 (l^2 - 1) / l^(2 beta + 1) exp(beta (l^2 - 1)); the others by hand."""
    F = np.diag([1.0, stretch, 1.0])
    square = stretch**2 - 1
    M = {name: LAWS[name].at_rest.lame + 2 * LAWS[name].at_rest.shear_modulus for name in LAWS}
    exact = {
        "holmes-mow": M["holmes-mow"] / 2 * square * stretch**-1.6 * np.exp(0.3 * square),
        "st-venant": M["st-venant"] / 2 * square * stretch,
        "neo-hooke": (square / 2.9 + LAWS["neo-hooke"].at_rest.lame * np.log(stretch)) / stretch,
    }
    for name, stress in exact.items():
        assert LAWS[name].cauchy(F)[1, 1] == pytest.approx(stress, rel=1e-12)


def test_ogden_with_one_term_of_2_is_mooney_without_its_second() -> None:
    one, other = fc.Ogden(mu=(0.5,), alpha=(2.0,), bulk=3.0), fc.MooneyRivlin(c10=0.25, c01=0.0, bulk=3.0)
    a, b = (law.response(deformations()) for law in (one, other))
    assert np.abs(a.stress - b.stress).max() < 1e-13
    assert np.abs(a.all_moduli - b.all_moduli).max() < 1e-8  # two stretches of one deformation are nearly equal
    assert np.abs(a.energy - b.energy).max() < 1e-13


def test_units_scale_the_stress() -> None:
    F = deformations()
    soft, hard = fc.HolmesMow(E=1.0, nu=0.2, beta=0.3), fc.HolmesMow(E=1e9, nu=0.2, beta=0.3)
    assert np.abs(hard.cauchy(F) / 1e9 - soft.cauchy(F)).max() < 1e-12


@pytest.mark.parametrize("name", ["neo-hooke", "st-venant"])
@pytest.mark.parametrize("parts", [(1.0, 1.0), (0.0, 1.0), (1.0, 0.0)])
def test_what_a_law_computes_in_the_initial_shape_is_what_is_pulled_back(name: str, parts: tuple[float, float]) -> None:
    """Against differences: dW = S : dE and dS = D : dE, with dE = (F^T G + G^T F) / 2."""
    law, F, h = LAWS[name], deformations(), 1e-5
    G = np.random.default_rng(4).standard_normal(F.shape)
    at, ahead, behind = (law.pulled(F + s * h * G, *parts) for s in (0, 1, -1))
    dE = (np.swapaxes(F, 1, 2) @ G + np.swapaxes(G, 1, 2) @ F) / 2
    X = at.metric
    assert X is not None
    work = (at.stress * dE).sum(axis=(1, 2))
    own = (at.lame * (X * dE).sum(axis=(1, 2)))[:, None, None] * X + 2 * at.shear.reshape(-1, 1, 1) * (X @ dE @ X)
    assert np.abs((ahead.energy - behind.energy) / (2 * h) - work).max() < 1e-7 * np.abs(work).max()
    assert np.abs((ahead.stress - behind.stress) / (2 * h) - own).max() < 1e-7 * np.abs(own).max()
    if name == "neo-hooke":
        assert np.abs(at.stress - Law.pulled(law, F, *parts).stress).max() < 1e-13


def along(stretch: float, angle: float) -> tuple[Array, Array]:
    """A stretch along z, and unit fibres at an angle from z towards x."""
    return np.diag([1.0, 1.0, stretch]), np.array([np.sin(angle), 0.0, np.cos(angle)])


@pytest.mark.parametrize(("alpha", "beta"), [(0.0, 2.0), (1.5, 2.0), (0.7, 3.5)])
@pytest.mark.parametrize("angle", [0.0, 0.6])
@pytest.mark.parametrize("ground", LAWS.values(), ids=LAWS)
def test_taut_fibres_add_their_tension(ground: Law, angle: float, alpha: float, beta: float) -> None:
    """2 W4 F a (x) F a / J with W4 = ksi s^(beta - 1) exp(alpha s^beta), s the squared stretch less one."""
    F, a = along(1.3, angle)
    law = fc.Fibres(ground, 7 * a, ksi=0.8, alpha=alpha, beta=beta)
    s = np.sin(angle) ** 2 + (1.3 * np.cos(angle)) ** 2 - 1
    pull = 2 * 0.8 * s ** (beta - 1) * np.exp(alpha * s**beta) / 1.3
    own = pull * np.outer([np.sin(angle), 0, 1.3 * np.cos(angle)], [np.sin(angle), 0, 1.3 * np.cos(angle)])
    assert np.abs(law.cauchy(F) - ground.cauchy(F) - own).max() < 1e-14
    assert law.at_rest == ground.at_rest


@pytest.mark.parametrize("ground", LAWS.values(), ids=LAWS)
def test_slack_fibres_are_the_ground_law_alone(ground: Law) -> None:
    law = fc.Fibres(ground, (0, 0, 2), ksi=50.0, alpha=3.0)
    F = np.array([np.diag([1.1, 0.9, 0.7]), np.diag([2.0, 0.4, 1 - 1e-9])])
    one, other = law.response(F), ground.response(F)
    assert np.array_equal(one.stress, other.stress)
    assert np.array_equal(one.energy, other.energy)
    assert np.array_equal(one.all_moduli, other.all_moduli)


def test_fibres_turn_with_the_frame_and_the_body() -> None:
    turn = fc.rotation_about((1.0, 2.0, 3.0), 0.7)
    F, given = deformations(), np.array([1.0, 2.0, 2.0])
    stress = FIBRES.cauchy(F)
    assert np.abs(FIBRES.cauchy(turn @ F) - turn @ stress @ turn.T).max() < 1e-13
    other = fc.Fibres(FIBRES.law, turn @ given, ksi=0.5, alpha=1.5)
    assert np.abs(other.cauchy(turn @ F @ turn.T) - turn @ stress @ turn.T).max() < 1e-12
    assert np.abs(other.cauchy(F) - stress).max() > 0.01
    assert np.array_equal(fc.Fibres(FIBRES.law, -given, ksi=0.5, alpha=1.5).cauchy(F), stress)


def test_two_families_of_fibres_add_up() -> None:
    F = deformations()
    both = fc.Fibres(FIBRES, (3, 0, -1), ksi=0.2, alpha=0.0, beta=3.0)
    second = fc.Fibres(FIBRES.law, (3, 0, -1), ksi=0.2, alpha=0.0, beta=3.0)
    ground = FIBRES.law.cauchy(F)
    assert np.abs(both.cauchy(F) + ground - FIBRES.cauchy(F) - second.cauchy(F)).max() < 1e-13


def test_directions_are_those_of_the_place() -> None:
    law = fc.Fibres(FIBRES, lambda x: np.stack([-x[:, 1], x[:, 0], 0 * x[:, 0]], axis=1), ksi=0.4, alpha=1.0)
    places = np.random.default_rng(0).uniform(1, 2, (4, 2, 3))
    F = np.broadcast_to(deformations()[4], (4, 2, 3, 3))
    found = law.at(places).cauchy(F)
    for (i, j), (x, y, _) in zip(np.ndindex(4, 2), places.reshape(-1, 3), strict=True):
        one = fc.Fibres(FIBRES, (-y, x, 0), ksi=0.4, alpha=1.0)
        assert np.abs(found[i, j] - one.cauchy(F[i, j])).max() < 1e-14
    with refused(fc.InputError, "no-place", "at(points)"):
        law.cauchy(F)


def test_fibres_without_sense_are_refused() -> None:
    ground, points = FIBRES.law, np.ones((5, 3))

    def made(direction: object = (1, 0, 0), ksi: float = 1e-3, alpha: float = 0.0, beta: float = 2.0) -> fc.Fibres:
        return fc.Fibres(ground, direction, ksi=ksi, alpha=alpha, beta=beta).at(points, in_section=True)  # type: ignore[arg-type]

    made()
    with refused(fc.InputError, "not-positive", "ksi"):
        made(ksi=0.0)
    with refused(fc.InputError, "exponents", "alpha", "-0.1"):
        made(alpha=-0.1)
    with refused(fc.InputError, "exponents", "beta", "1.9"):
        made(beta=1.9)
    with refused(fc.InputError, "axis-zero"):
        made((0, 0, 0))
    made(lambda x: x * [1, 0, 1])
    with refused(fc.InputError, "wrong-shape", "nearest centre"):
        made(np.ones((5, 3)))
    with refused(fc.InputError, "wrong-shape", "(2, 3)"):
        made(lambda x: x[:2])
    made((0, 1, 0))
    with refused(fc.InputError, "finite-strain-section", "plane"):
        made((0, 1, 1e-3))
    with refused(fc.InputError, "wrong-class", "ground law"):
        fc.Fibres(fc.Material(1.0, 0.3), (1, 0, 0), ksi=1.0, alpha=0.0)  # type: ignore[arg-type]


@pytest.mark.parametrize(
    ("law", "bearable"),
    [(fc.Fibres(FIBRES.law, (0, 0, 1), ksi=1.0, alpha=1.0), 4.2), (fc.HolmesMow(E=1.0, nu=0.2, beta=1.0), 17.0)],
    ids=["fibres", "holmes-mow"],
)
def test_exponents_beyond_all_numbers_are_refused(law: Law, bearable: float) -> None:
    assert np.isfinite(law.cauchy(np.diag([1.0, 1.0, bearable]))).all()
    with refused(InvertedError, "overflow", "smaller steps"):
        law.cauchy(np.diag([1.0, 1.0, 1.1 * bearable]))


def test_the_stretch_at_which_holmes_and_mow_have_no_stress_left() -> None:
    """At constant volume: there is one where the coefficient of I1 is negative, which is told, and none elsewhere."""
    for nu in (0.3, 0.45):
        law = fc.HolmesMow(E=1.0, nu=nu, beta=0.5)
        stretch = nu / (3 * nu - 1) if nu > 1 / 3 else 3.0
        stresses = [law.cauchy(np.diag([s, s**-0.5, s**-0.5])).diagonal() for s in (stretch - 0.01, stretch + 0.01)]
        before, after = (float(stress[0] - stress[1]) for stress in stresses)
        assert before > 0
        assert (after < 0) == (nu > 1 / 3)
        assert (f"{stretch:.3g}" in law.caution) == (nu > 1 / 3)
        assert fc.Fibres(law, (1, 0, 0), ksi=1.0, alpha=0.0).caution == law.caution
    assert fc.NeoHookean(E=1.0, nu=0.45).caution == ""


class Linear(InvariantLaw):
    """An own law: W = (I1 - 3) - 2 ln J, which is neo-Hooke's with mu = 2 and lambda = 0."""

    density = None
    bulk = 0.0
    at_rest = fc.Material(E=4.0, nu=0.0)

    def derivatives(self, I1, I2, y):  # type: ignore[no-untyped-def]
        """Energy and its derivatives."""
        return I1 - 3 - 2 * y, (1.0, 0.0, -2.0), ()


def test_an_own_law_by_its_derivatives() -> None:
    known, own = (law.response(deformations()) for law in (fc.NeoHookean(E=4.0, nu=0.0), Linear()))
    assert np.abs(known.stress - own.stress).max() < 1e-14
    assert np.abs(known.all_moduli - own.all_moduli).max() < 1e-14


def test_inverted_material_and_wrong_constants_are_refused() -> None:
    with refused(InvertedError, "inverted-material", "-0.5"):
        LAWS["neo-hooke"].cauchy(np.diag([-0.5, 1.0, 1.0]))
    with refused(fc.InputError, "poisson-ratio", "0.5"):
        fc.NeoHookean(E=1.0, nu=0.5)
    with refused(fc.InputError, "not-positive", "-0.1"):
        fc.MooneyRivlin(c10=0.1, c01=-0.2, bulk=1.0)
    with refused(fc.InputError, "not-positive", "beta"):
        fc.HolmesMow(E=1.0, nu=0.3, beta=0.0)
    with refused(fc.InputError, "not-positive", "bulk"):
        fc.Ogden(mu=(1.0,), alpha=(2.0,), bulk=-1.0)
    with refused(fc.InputError, "exponents", "alpha"):
        fc.Ogden(mu=(1.0, 1.0), alpha=(2.0,), bulk=1.0)
    with refused(fc.InputError, "exponents", "mu"):
        fc.Ogden(mu=("a",), alpha=(2.0,), bulk=1.0)  # type: ignore[arg-type]
