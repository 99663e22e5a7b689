"""Semi-analytic solutions of plane contact problems without finite elements: Michell's series, transforms."""

import numpy as np

from fecontact.solvers import ContactProblem, solve


def hat_transform(t):
    """Fourier transform of a hat of unit integral and half-width 1."""
    return np.sinc(t / (2 * np.pi)) ** 2


def layer_on_rigid_plane(thickness, modulus, half_width, load, n=400, reach=3.0):
    """Pressure under a free elastic layer that lies on a frictionless rigid plane (receding contact, plane strain).

    The layer's flexibilities at wave number k, h = 2c: symmetric pressures 2/(E'k) 2 sinh^2(kc)/(sinh 2kc + 2kc),
    antisymmetric ones 2/(E'k) 2 cosh^2(kc)/(sinh 2kc - 2kc) (Filon 1903; Barber, Contact Mechanics, chapter on
    receding contact). Their small-k limits are the rod and the plate, 12/(E'h^3 k^4).

    Parameters
    ----------
    thickness : float
    modulus : float
        E' = E/(1 - nu^2).
    half_width, load : float
        Of the strip on top, and its total force.
    n : int
        Hats over half the length `reach` x thickness.

    Returns
    -------
    x, pressure : (n,) arrays
        On x >= 0.
    """
    x = np.linspace(0, reach * thickness, n)
    dx = x[1]
    c = thickness / 2
    k = np.concatenate([np.linspace(1e-4, 2, 801)[:-1], np.linspace(2, 60, 4001)[:-1], np.geomspace(60, 40 / dx, 8001)])
    k = k / thickness
    t = k * c
    half = 2 / (modulus * k)
    with np.errstate(over="ignore", invalid="ignore"):
        symmetric = half * np.where(t > 200, 1.0, 2 * np.sinh(t) ** 2 / (np.sinh(2 * t) + 2 * t))
        bending = half * np.where(t > 200, 1.0, 2 * np.cosh(t) ** 2 / (np.sinh(2 * t) - 2 * t))
    small = t < 0.02  # here sinh 2t - 2t has lost its digits
    bending[small] = half[small] * 2 * (1 + t[small] ** 2) / (8 * t[small] ** 3 / 6 * (1 + t[small] ** 2 / 5))
    wave = np.cos(np.outer(k, x)) * hat_transform(k * dx)[:, None]
    strip = np.sinc(k * half_width / np.pi)
    weights = np.gradient(k) / np.pi  # trapezoidal rule
    weights[[0, -1]] /= 2
    squeeze, bend = (weights * symmetric / 2)[:, None], (weights * bending / 2)[:, None]
    many = np.where(np.arange(n) == 0, 1.0, 2.0)  # a hat off the axis has its mirror image beside it
    # loads balance, so that cos(kx) may be counted from its value at x = 0, where the plate's motion is not determined
    S = 2 * (wave.T @ (squeeze * wave) + (wave - 1).T @ (bend * (wave - 1)))
    g = 2 * load * (wave.T @ (squeeze[:, 0] * strip) - (wave - 1).T @ (bend[:, 0] * (strip - 1)))
    problem = ContactProblem(S * np.outer(many, many) / 2, g * many / 2, many[None, :], np.array([load]))
    return x, solve(problem, "auto").forces / dx


def ring_flexibility(n, loaded, clamped, material):
    """Radial displacement of a ring's edge, towards the ring, by pressure cos(n theta) on it; the other edge is held.

    Plane strain. The displacement is u_r = U r^k cos(n theta), u_t = V r^k sin(n theta) with k = n + 1, n - 1, 1 - n,
    -n - 1 (Michell 1899; Barber, Elasticity, chapter 8); double roots bring a logarithm (n = 1) or fall away (n = 0).
    """
    lam, mu = material.lame, material.shear_modulus
    functions = []  # (u_r, u_t and their derivatives) at r, each scaled to 1 where it is largest

    def power(k, U, V):
        scale = max(loaded, clamped) if k > 0 else min(loaded, clamped)
        return lambda r: np.array([U, V, U * k / r, V * k / r]) * (r / scale) ** k

    def logarithm(r):
        A = -(lam + mu) / (lam + 3 * mu)
        return np.array([np.log(r), -np.log(r) + A, 1 / r, -1 / r])

    if n == 0:
        functions = [power(1, 1.0, 0.0), power(-1, 1.0, 0.0)]
    else:
        for k in {n + 1, n - 1, 1 - n, -n - 1}:
            U = n * ((lam + mu) * k - (lam + 3 * mu))
            V = -((lam + 2 * mu) * (k**2 - 1) - mu * n**2)
            functions.append(power(k, U / max(abs(U), abs(V)), V / max(abs(U), abs(V))))
        if n == 1:
            functions.append(logarithm)
    rows, right = [], []
    for r, held in ((clamped, True), (loaded, False)):
        u, v, du, dv = np.array([f(r) for f in functions]).T
        stress = (lam + 2 * mu) * du + lam * (u + n * v) / r
        shear = mu * (dv - (v + n * u) / r)
        rows += [u, v] if held else [stress * r / mu, shear * r / mu]
        right += [0.0, 0.0] if held else [-loaded / mu, 0.0]
    if n == 0:
        rows, right = rows[::2], right[::2]
    u = np.array([f(loaded)[0] for f in functions]) @ np.linalg.solve(np.array(rows), np.array(right))
    return float(u * np.sign(clamped - loaded))


def pin_in_hole(radius, clearance, approach, pin, plate, n=400):
    """Pressure between a ring round a rigid core and the hole of a ring held outside, plane strain.

    Parameters
    ----------
    radius, clearance, approach : float
        Of the hole; hole minus pin; motion of the core towards theta = 0.
    pin, plate : (float, Material)
        Radius at which each is held, and what it is made of.
    n : int
        Hats over half the circumference.

    Returns
    -------
    angle, pressure : (n + 1,) arrays
    """
    angle = np.linspace(0, np.pi, n + 1)
    step = angle[1]
    orders = np.arange(8 * n)
    F = np.array([sum(ring_flexibility(k, radius, held, m) for held, m in (pin, plate)) for k in orders])
    wave = np.cos(np.outer(orders, angle))
    share = np.where(orders == 0, 0.5, 1.0) * hat_transform(orders * step) * step / np.pi
    many = np.where((angle == 0) | (angle == np.pi), 1.0, 2.0)
    S = wave.T @ ((F * share)[:, None] * wave)
    g = clearance - approach * np.cos(angle)
    scale = S.max() / g[-1]
    solution = solve(ContactProblem(S * np.outer(many, many), g * scale * many), "auto")
    return angle, solution.forces / scale


#: Kalker's coefficient C11 of creepage along the way of rolling, circular contact, at nu = 0, 1/4 and 1/2: table E3 of
#: J. J. Kalker, Three-Dimensional Elastic Bodies in Rolling Contact, 1990. The parabola through them serves between.
KALKER_C11 = ((0.0, 3.40), (0.25, 4.12), (0.5, 5.20))


def rolling_creepage(share, load, mu, a, shear, nu):
    """Creepage of a ball that rolls under a share of the tangential force mu P, by its contact radius a.

    Q / (mu P) = 1 - (1 - G a^2 C11 xi / (3 mu P))^3: the law of P. J. Vermeulen & K. L. Johnson, J. Appl. Mech. 31
    (1964) 338, with the slope of Kalker's linear theory (Z. Y. Shen, J. K. Hedrick & J. A. Elkins 1983), for equal
    bodies, or a rigid one and one with nu = 1/2, of which `shear` is twice the modulus.
    """
    nus, values = zip(*KALKER_C11, strict=True)
    c11 = np.polyval(np.polyfit(nus, values, 2), nu)
    return 3 * mu * load / (shear * a**2 * c11) * (1 - (1 - share) ** (1 / 3))
