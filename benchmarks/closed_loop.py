# SPDX-License-Identifier: MIT
"""How well a controller follows the profiles: constant, fastest, smooth, and the constant factor as slow as the smooth.

In MuJoCo, with delay, lag, friction and a load that plans do not know; docs/smooth.md says how.
"""

import sys
from pathlib import Path

sys.path.insert(0, str(Path(__file__).resolve().parents[1] / "tests" / "simulations"))
sys.path.insert(0, str(Path(__file__).resolve().parents[1] / "tests" / "cases"))
from closed_loop_trials import GRASPS, MOTIONS, Trial, measures, trial  # the trial that the tests pass

PROFILES = {"constant": "constant", "optimal": "optimal", "smooth": "smooth", "constant, as long": "as_long"}


VARIANTS: dict[str, tuple[str, dict[str, float]]] = {
    "no limit of wrench rates": ("clamps", {"filled": 1e-6}),
    "0.018 s to fill a contact's limit": ("clamps", {"filled": 0.018}),
    "0.040 s to fill a contact's limit": ("clamps", {"filled": 0.04}),
    "8 torque limits a second": ("clamps", {"torque_rate": 8.0}),
    "15 torque limits a second": ("clamps", {"torque_rate": 15.0}),
    "no velocity limits": ("rigid", {"velocity_limits": False}),
    "dry friction of 5 % of the torque limits": ("rigid", {"dry": 0.05}),
}
"""What is changed of the trial of the UR5s, and with which grasps."""


def show(title: str, of: Trial, grasp: str) -> None:
    """Print the table of one trial."""
    print(f"{title}, grasps: {grasp}")
    for label, profile in PROFILES.items():
        found = measures(of.played(profile, grasp))
        if profile == "constant":
            print(f"  {'profile':<18}" + "".join(f"{column:>15}" for column in found))
        values = [f"{value:.4f}" if "[s]" in column else f"{value:.2f}" for column, value in found.items()]
        print(f"  {label:<18}" + "".join(f"{value:>15}" for value in values), flush=True)


def main() -> None:
    """Print the tables; with `--variants` those of changed trials."""
    if "--variants" in sys.argv[1:]:
        for title, (grasp, changed) in VARIANTS.items():
            show(title, trial("dual_ur5", **changed), grasp)
        return
    for name in MOTIONS:
        for grasp in GRASPS:
            show(name, trial(name), grasp)


if __name__ == "__main__":
    main()
