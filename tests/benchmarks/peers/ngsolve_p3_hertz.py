"""As `ngsolve_hertz.py`, with tetrahedra of degree 3."""

from ngsolve_hertz import main

if __name__ == "__main__":
    main(3, (0.5, 0.35, 0.25, 0.18))
