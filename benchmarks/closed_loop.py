# SPDX-License-Identifier: MIT
"""How well a controller follows the profiles: constant, fastest, smooth, and the constant factor as slow as the smooth.

In MuJoCo, with delay, lag, friction and a load that plans do not know; docs/smooth.md says how.
"""

import sys
from pathlib import Path

sys.path.insert(0, str(Path(__file__).resolve().parent.parent / "tests" / "cases"))
from closed_loop_trials import GRASPS, MOTIONS, measures, trial  # the trial that the tests pass

PROFILES = {"constant": "constant", "optimal": "optimal", "smooth": "smooth", "constant, as long": "as_long"}


def main() -> None:
    """Print the tables."""
    for name in MOTIONS:
        of = trial(name)
        for grasp in GRASPS:
            print(f"{name}, grasps: {grasp}")
            for label, profile in PROFILES.items():
                found = measures(of.played(profile, grasp))
                if profile == "constant":
                    print(f"  {'profile':<18}" + "".join(f"{column:>15}" for column in found))
                values = [f"{value:.4f}" if "[s]" in column else f"{value:.2f}" for column, value in found.items()]
                print(f"  {label:<18}" + "".join(f"{value:>15}" for value in values), flush=True)


if __name__ == "__main__":
    main()
