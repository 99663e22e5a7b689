"""Two spheres pressed together: the main job as a script, with picture and files.

Run: python examples/two_spheres.py
"""

from pathlib import Path

from fecontact.app.spheres.spheres import solve_spheres


def main(level: int = 2, out: str | Path = "out") -> float:
    folder = Path(out)
    folder.mkdir(parents=True, exist_ok=True)
    result = solve_spheres("equal", level=level)
    print(result)
    result.plot(folder / "two_spheres.png")
    result.result.save(folder / "two_spheres.json")
    return result.pressure_l2_error


if __name__ == "__main__":
    main()
