"""Materials of decks, linearised at rest: the small-strain moduli of hyperelastic laws.

Sources: Abaqus Theory Guide, "Hyperelastic material behavior" (initial shear and bulk modulus of each strain energy);
FEBio User Manual, "Materials". With W of the invariants of the isochoric strain, mu = 2 (dW/dI1 + dW/dI2) at rest.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence

from fecontact.common.errors import InputError
from fecontact.common.material import Material

#: Poisson's ratio of laws without compressibility: K is about 20 mu (Abaqus: default of *HYPERELASTIC).
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


def hyperelastic(form: str, order: int, c: Sequence[float], density: float | None) -> Material:
    """Material of *HYPERELASTIC at rest.

    Parameters
    ----------
    form : str
        'NEO HOOKE', 'MOONEY-RIVLIN', 'YEOH', 'POLYNOMIAL', 'REDUCED POLYNOMIAL', 'OGDEN' or 'ARRUDA-BOYCE'.
    order : int
        N of a sum.
    c : sequence of float
        Constants of the first data lines.
    density : float, optional

    Raises
    ------
    InputError
        For another law or too few constants.

    Examples
    --------
    Neo-Hooke with C10 = 0.5 and D1 = 1.2: mu = 1, K = 5/3.

    >>> hyperelastic("NEO HOOKE", 1, [0.5, 1.2], None)
    Material(E=2.5, nu=0.25, density=None)
    """
    sizes = {
        "NEO HOOKE": (1, 1),
        "MOONEY-RIVLIN": (2, 2),
        "YEOH": (3, 1),
        "REDUCED POLYNOMIAL": (order, 1),
        "POLYNOMIAL": ((order + 1) * (order + 2) // 2 - 1, 2),
    }
    if form == "OGDEN":
        needed = 2 * order + 1
    elif form == "ARRUDA-BOYCE":
        needed = 3
    elif form in sizes:
        needed = sizes[form][0] + 1
    else:
        raise InputError(
            f"*HYPERELASTIC, {form} is not known; expected {', '.join((*sizes, 'OGDEN', 'ARRUDA-BOYCE'))}.",
            code="unknown-law",
        )
    values = [*c, 0.0]
    if len(values) < needed:
        raise InputError(f"*HYPERELASTIC, {form} needs {needed} constants; found {len(c)}.", code="constants")
    D = values[needed - 1]
    bulk = 2 / D if D else None
    if form == "OGDEN":
        return from_moduli(sum(values[0 : 2 * order : 2]), bulk, density)
    if form == "ARRUDA-BOYCE":
        # mu0 = mu (1 + 3/(5 l^2) + 99/(175 l^4) + 513/(875 l^6) + 42039/(67375 l^8))
        l2 = values[1] ** 2
        series = 1 + 3 / (5 * l2) + 99 / (175 * l2**2) + 513 / (875 * l2**3) + 42039 / (67375 * l2**4)
        return from_moduli(values[0] * series, bulk, density)
    return from_moduli(2 * sum(values[: sizes[form][1]]), bulk, density)


def hyperfoam(order: int, c: Sequence[float], density: float | None) -> Material:
    """Material of *HYPERFOAM at rest: mu = sum mu_i, K = sum 2 mu_i (1/3 + beta_i), beta = nu_i / (1 - 2 nu_i).

    `c` are mu_1, alpha_1, mu_2, ..., then nu_1, nu_2, ...

    Examples
    --------
    >>> round(hyperfoam(1, [1.0, 2.0, 0.25], None).E, 12)
    2.5
    """
    mu, nu = c[0 : 2 * order : 2], [*c[2 * order : 3 * order], *[0.0] * order][:order]
    if len(mu) < order:
        raise InputError(f"*HYPERFOAM of order {order} needs {2 * order} constants or more; found {len(c)}.")
    bulk = sum(2 * m * (1 / 3 + v / (1 - 2 * v)) for m, v in zip(mu, nu, strict=True))
    return from_moduli(sum(mu), bulk, density)


def of_febio(kind: str, values: Mapping[str, float]) -> Material | None:
    """Material of an FEBio law at rest; None for one that is not known.

    Examples
    --------
    >>> of_febio("neo-Hookean", {"E": 2.5, "v": 0.25})
    Material(E=2.5, nu=0.25, density=None)
    >>> of_febio("Mooney-Rivlin", {"c1": 0.4, "c2": 0.1, "k": 5 / 3}).E
    2.5
    """
    density = values.get("density") or None
    try:
        if kind in BY_E_AND_V:
            return Material(values["E"], values["v"], density)
        if kind in ("Mooney-Rivlin", "Veronda-Westmann"):
            # Veronda-Westmann at rest: C1 C2 (I1 - 3) - C1 C2 / 2 (I2 - 3), so mu = C1 C2
            c1, c2 = values["c1"], values.get("c2", 0.0)
            shear = 2 * (c1 + c2) if kind == "Mooney-Rivlin" else c1 * c2
            return from_moduli(shear, values["k"], density)
        if kind in ("Ogden", "Ogden unconstrained"):
            # sum c_i / m_i^2 (l1^m + l2^m + l3^m - 3 ...): mu = sum c_i / 2; unconstrained: cp is lambda
            shear = sum(values.get(f"c{i}", 0.0) for i in range(1, 7)) / 2
            bulk = values["k"] if kind == "Ogden" else values["cp"] + 2 * shear / 3
            return from_moduli(shear, bulk, density)
        if kind == "Arruda-Boyce":
            n = values["N"]
            series = 1 + 3 / (5 * n) + 99 / (175 * n**2) + 513 / (875 * n**3) + 42039 / (67375 * n**4)
            return from_moduli(values["mu"] * series, values["k"], density)
    except KeyError as error:
        raise InputError(
            f"The material {kind!r} has no constant {error}; found {', '.join(values) or 'none'}."
        ) from None
    return None
