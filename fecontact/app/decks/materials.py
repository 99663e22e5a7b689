"""Materials of decks: laws of finite strain, or linear ones by their moduli at rest.

Sources: Abaqus Theory Guide, "Hyperelastic material behavior" (initial shear and bulk modulus of each strain energy);
FEBio User Manual, "Materials". With W of the invariants of the isochoric strain, mu = 2 (dW/dI1 + dW/dI2) at rest.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from typing import TypeVar

from fecontact.app.options import FINITE, SMALL
from fecontact.common.errors import InputError
from fecontact.common.material import Material
from fecontact.fem.laws import CompressibleOgden, HolmesMow, Law, MooneyRivlin, NeoHookean, Ogden, StVenantKirchhoff

_T = TypeVar("_T")
#: What makes a material of its constants and density.
_Maker = Callable[[Mapping[str, float], float | None], _T]
#: Poisson's ratio of laws without compressibility: K is about 20 mu (CalculiX User's Manual, section "Hyperelastic and
#: hyperfoam materials"; Abaqus/Explicit).
NEARLY_INCOMPRESSIBLE = 0.475
#: FEBio's laws whose constants are those of small strains.
BY_E_AND_V = (
    "neo-Hookean",
    "isotropic elastic",
    "isotropic Hencky",
    "natural neo-Hookean",
    "St.Venant-Kirchhoff",
    "Holmes-Mow",
)
#: How many of a law's first constants are of the first order, where that is more than one: mu = 2 times their sum.
OF_FIRST_ORDER = {"MOONEY-RIVLIN": 2, "POLYNOMIAL": 2}
REMEDY = "laws='small-strain' (--laws small-strain) takes its moduli at rest."


def from_moduli(shear: float, bulk: float | None, density: float | None = None) -> Material:
    """Material by its shear and bulk modulus; without the latter nearly incompressible.

    Examples
    --------
    >>> round(from_moduli(1.0, 5 / 3).nu, 12)
    0.25
    """
    if bulk is None:
        return Material(2 * shear * (1 + NEARLY_INCOMPRESSIBLE), NEARLY_INCOMPRESSIBLE, density)
    if shear <= 0 or bulk <= 0:
        raise InputError(f"A material needs positive shear and bulk moduli at rest; found {shear:g} and {bulk:g}.")
    return Material(9 * bulk * shear / (3 * bulk + shear), (3 * bulk - 2 * shear) / (2 * (3 * bulk + shear)), density)


def hyperelastic(form: str, order: int, c: Sequence[float], density: float | None, laws: str = SMALL) -> Material | Law:
    """Law of *HYPERELASTIC, or its material at rest.

    At finite strain the bulk part is (ln J)^2 / D in place of (J - 1)^2 / D.

    Parameters
    ----------
    form : str
        'NEO HOOKE', 'MOONEY-RIVLIN', 'YEOH', 'POLYNOMIAL', 'REDUCED POLYNOMIAL', 'OGDEN' or 'ARRUDA-BOYCE'.
    order : int
        N of a sum.
    c : sequence of float
        Constants of the first data lines.
    density : float, optional
    laws : {'small-strain', 'finite-strain'}

    Raises
    ------
    InputError
        For another law or too few constants.

    Examples
    --------
    Neo-Hooke with C10 = 0.5 and D1 = 1.2: mu = 1, K = 5/3.

    >>> hyperelastic("NEO HOOKE", 1, [0.5, 1.2], None)
    Material(E=2.5, nu=0.25, density=None, expansion=None)
    """
    D = compressibility(form, order, c)
    bulk = 2 / D if D else None
    if laws == FINITE:
        return _as_law(form, order, [*c, 0.0], bulk, density)
    if form == "OGDEN":
        return from_moduli(sum(c[0 : 2 * order : 2]), bulk, density)
    if form == "ARRUDA-BOYCE":
        return from_moduli(c[0] * _chain(c[1] ** 2), bulk, density)
    return from_moduli(2 * sum(c[: OF_FIRST_ORDER.get(form, 1)]), bulk, density)


def compressibility(form: str, order: int, c: Sequence[float]) -> float:
    """D of *HYPERELASTIC, the first of several; zero where there is none.

    Raises
    ------
    InputError
        For another law or too few constants.

    Examples
    --------
    >>> compressibility("NEO HOOKE", 1, [0.5, 1.2]), compressibility("OGDEN", 1, [0.5, 2.0])
    (1.2, 0.0)
    """
    before = {
        "NEO HOOKE": 1,
        "MOONEY-RIVLIN": 2,
        "YEOH": 3,
        "REDUCED POLYNOMIAL": order,
        "POLYNOMIAL": (order + 1) * (order + 2) // 2 - 1,
        "OGDEN": 2 * order,
        "ARRUDA-BOYCE": 2,
    }
    if form not in before:
        raise InputError(f"*HYPERELASTIC, {form} is not known; expected {', '.join(before)}.", code="unknown-law")
    if len(c) < before[form]:
        raise InputError(f"*HYPERELASTIC, {form} needs {before[form]} constants; found {len(c)}.", code="constants")
    return [*c, 0.0][before[form]]


def _as_law(form: str, order: int, c: Sequence[float], bulk: float | None, density: float | None) -> Law:
    """Law of *HYPERELASTIC at finite strain.

    Raises
    ------
    InputError
        For one that is not offered.
    """
    ogden = form == "OGDEN"
    if form not in ("NEO HOOKE", "MOONEY-RIVLIN", "OGDEN") or (ogden and any(c[2 * order + 1 : 3 * order])):
        raise InputError(
            f"*HYPERELASTIC, {form} is not offered at finite strain; there are NEO HOOKE, MOONEY-RIVLIN and OGDEN with "
            f"one D. {REMEDY}",
            code="unknown-law",
        )
    c10, c01 = c[0], c[1] if form == "MOONEY-RIVLIN" else 0.0
    mu, alpha = c[0 : 2 * order : 2], c[1 : 2 * order : 2]
    nu = NEARLY_INCOMPRESSIBLE
    kappa = bulk or 2 * (1 + nu) / (3 * (1 - 2 * nu)) * (sum(mu) if ogden else 2 * (c10 + c01))
    return Ogden(mu, alpha, kappa, density) if ogden else MooneyRivlin(c10, c01, kappa, density)


def hyperfoam(order: int, c: Sequence[float], density: float | None, laws: str = SMALL) -> Material:
    """Material of *HYPERFOAM at rest: mu = sum mu_i, K = sum 2 mu_i (1/3 + beta_i), beta = nu_i / (1 - 2 nu_i).

    `c` are mu_1, alpha_1, mu_2, ..., then nu_1, nu_2, ...

    Examples
    --------
    >>> round(hyperfoam(1, [1.0, 2.0, 0.25], None).E, 12)
    2.5
    """
    if laws == FINITE:
        raise InputError(f"*HYPERFOAM is not offered at finite strain. {REMEDY}", code="unknown-law")
    mu, nu = c[0 : 2 * order : 2], [*c[2 * order : 3 * order], *[0.0] * order][:order]
    if len(mu) < order:
        raise InputError(f"*HYPERFOAM of order {order} needs {2 * order} constants or more; found {len(c)}.")
    bulk = sum(2 * m * (1 / 3 + v / (1 - 2 * v)) for m, v in zip(mu, nu, strict=True))
    return from_moduli(sum(mu), bulk, density)


def _chain(n: float) -> float:
    """Shear modulus at rest of Arruda and Boyce's law over its mu, by the segments n of a chain."""
    return 1 + 3 / (5 * n) + 99 / (175 * n**2) + 513 / (875 * n**3) + 42039 / (67375 * n**4)


def _terms(v: Mapping[str, float]) -> tuple[list[float], list[float]]:
    """Moduli and exponents of FEBio's sum c_i / m_i^2 (l1^m + l2^m + l3^m - 3): mu_i = c_i / 2."""
    found = [(c / 2, v.get(f"m{i}", 1.0)) for i in range(1, 7) if (c := v.get(f"c{i}", 0.0))]
    return [mu for mu, _ in found], [alpha for _, alpha in found]


#: FEBio's laws at rest by their constants and density.
AT_REST: dict[str, _Maker[Material]] = {
    **dict.fromkeys(BY_E_AND_V, lambda v, rho: Material(v["E"], v["v"], rho)),
    "Mooney-Rivlin": lambda v, rho: from_moduli(2 * (v["c1"] + v.get("c2", 0.0)), v["k"], rho),
    "incomp neo-Hookean": lambda v, rho: from_moduli(v["G"], v["k"], rho),
    # c1 c2 (I1 - 3) - c1 c2 / 2 (I2 - 3)
    "Veronda-Westmann": lambda v, rho: from_moduli(v["c1"] * v["c2"], v["k"], rho),
    "Ogden": lambda v, rho: from_moduli(sum(_terms(v)[0]), v["k"], rho),
    "Ogden unconstrained": lambda v, rho: from_moduli((mu := sum(_terms(v)[0])), v["cp"] + 2 * mu / 3, rho),
    "Arruda-Boyce": lambda v, rho: from_moduli(v["mu"] * _chain(v["N"]), v["k"], rho),
}
#: FEBio's laws at finite strain; the bulk part of uncoupled ones is k/2 (ln J)^2.
LAWS: dict[str, _Maker[Law]] = {
    "isotropic elastic": lambda v, rho: StVenantKirchhoff(v["E"], v["v"], rho),
    "neo-Hookean": lambda v, rho: NeoHookean(v["E"], v["v"], rho),
    "Holmes-Mow": lambda v, rho: HolmesMow(v["E"], v["v"], rho, beta=v["beta"]),
    "Mooney-Rivlin": lambda v, rho: MooneyRivlin(v["c1"], v.get("c2", 0.0), v["k"], rho),
    "incomp neo-Hookean": lambda v, rho: MooneyRivlin(v["G"] / 2, 0.0, v["k"], rho),
    "Ogden": lambda v, rho: Ogden(*_terms(v), v["k"], rho),
    "Ogden unconstrained": lambda v, rho: CompressibleOgden(*_terms(v), v["cp"], rho),
}


def of_febio(kind: str, values: Mapping[str, float]) -> Material | None:
    """Material of an FEBio law at rest; None for one that is not known.

    Examples
    --------
    >>> of_febio("neo-Hookean", {"E": 2.5, "v": 0.25})
    Material(E=2.5, nu=0.25, density=None, expansion=None)
    >>> of_febio("Mooney-Rivlin", {"c1": 0.4, "c2": 0.1, "k": 5 / 3}).E
    2.5
    """
    return _made(AT_REST, kind, values)


def law_of_febio(kind: str, values: Mapping[str, float]) -> Law | None:
    """FEBio's law at finite strain; None for one that is not offered.

    Examples
    --------
    >>> law_of_febio("neo-Hookean", {"E": 2.5, "v": 0.25})
    NeoHookean(E=2.5, nu=0.25, density=None)
    """
    return _made(LAWS, kind, values)


def _made(known: Mapping[str, _Maker[_T]], kind: str, values: Mapping[str, float]) -> _T | None:
    if kind not in known:
        return None
    try:
        return known[kind](values, values.get("density") or None)
    except KeyError as error:
        raise InputError(
            f"The material {kind!r} has no constant {error}; found {', '.join(values) or 'none'}."
        ) from None
