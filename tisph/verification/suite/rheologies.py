"""Liquids that remember by laws of their own in the verification suite: start-up from rest, and what it leads to.

Laws are those of ``tisph/rheology`` with the numbers of the Oldroyd-B base: total viscosity 1, a tenth of it the
solvent's, longest relaxation time 1; the reference is ``tisph/exact/start_up.py``. Bounds are those of the velocity and
of the stress at the walls.
"""

from tisph.verification import flows
from tisph.verification.criteria import at_most
from tisph.verification.flows import across, merged

START_UP, STEADY = 1e-3, 1e-4

LATE = 20.0
"""t* at which all flows are steady: 20 relaxation times."""

POLYMER = {"relaxation_time": 1.0, "solvent_fraction": 0.1}

LAWS = {
    "giesekus": {"type": "giesekus", **POLYMER, "mobility": 0.3},
    "linear_ptt": {"type": "phan_thien_tanner", **POLYMER, "extensibility": 0.25},
    "exponential_ptt": {"type": "phan_thien_tanner", **POLYMER, "extensibility": 0.25, "form": "exponential"},
    "fene_p": {"type": "fene_p", **POLYMER, "maximum_extension": 20.0},
    "two_modes": {
        "type": "multi_mode",
        "solvent_fraction": 0.1,
        "modes": [
            {"type": "oldroyd_b", "relaxation_time": 1.0, "fraction": 0.6},
            {"type": "giesekus", "relaxation_time": 0.2, "mobility": 0.2, "fraction": 0.3},
        ],
    },
}

DRIVES = {"couette": flows.walls(0.0, 1.0), "poiseuille": flows.drive(4.0)}


def runs(quick):
    """Configs by run name: law and what drives the liquid."""
    times = (1.0,) if quick else (0.5, 1.0, 2.0, LATE)
    return {
        f"{law}_{drive}": _config(LAWS[law], DRIVES[drive], across(25) if quick else {}, times)
        for law in LAWS
        for drive in DRIVES
    }


def criteria(quick):
    """What the runs are held to."""
    bounds = {1.0: START_UP} if quick else {0.5: START_UP, 1.0: START_UP, 2.0: START_UP, LATE: STEADY}
    return [
        at_most(f"{law}_{drive}", t_star, quantity, bound)
        for law in LAWS
        for drive in DRIVES
        for t_star, bound in bounds.items()
        for quantity in ("l2", "wall_shear")
    ]


def _config(law, drive, resolution, times):
    liquid = {"fluid": {"kinematic_viscosity": 1.0, "rheology": law}, "scheme": {"type": "implicit"}}
    return flows.sampled(merged(flows.NEWTONIAN, liquid, drive, resolution), times)
