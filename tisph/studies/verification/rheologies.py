"""Rheological laws in the verification suite: start-up from rest, and what it leads to.

Laws that remember are those of ``tisph/rheology`` with the numbers of the Oldroyd-B base: total viscosity 1, a tenth of
it the solvent's, longest relaxation time 1. The reference is ``tisph/exact/start_up.py``; bounds are those of the
velocity and of the stress at the walls.
"""

from tisph.studies import flows
from tisph.studies.flows import across, merged
from tisph.studies.verification.criteria import at_most

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

VISCOUS = {
    "thinning": {"type": "power_law", "index": 0.3, "reference_rate": 1.0, "least_rate": 1e-2},
    "thickening": {"type": "power_law", "index": 1.5, "reference_rate": 1.0, "least_rate": 1e-2},
    "carreau": {"type": "carreau_yasuda", "time": 1.0, "index": 0.5},
    "bingham": {
        "type": "herschel_bulkley",
        "yield_stress": 0.2,
        "index": 1.0,
        "reference_rate": 1.0,
        "regularisation": 200.0,
    },
}
"""Inelastic; driven, since the reference of an impulsively started wall takes long."""

QUICK_VISCOUS = ("carreau", "bingham")

QUICK_DRIVES = {"giesekus": "couette", "exponential_ptt": "poiseuille", "fene_p": "couette", "two_modes": "poiseuille"}
"""What drives each law in a quick run; the linear form of Phan-Thien and Tanner's differs from the other in a function
of one number."""

SOON, SETTLED = 0.2, 2.0
"""t* at which their layers have met, and at which their flows are steady."""

DRIVES = {"couette": flows.walls(0.0, 1.0), "poiseuille": flows.drive(4.0)}


def runs(quick):
    """Configs by run name: law and what drives the fluid."""
    times, resolution = ((1.0,), across(25)) if quick else ((0.5, 1.0, 2.0, LATE), {})
    found = {f"{law}_{drive}": _config(LAWS[law], DRIVES[drive], resolution, times) for law, drive in _driven(quick)}
    times = (SOON,) if quick else (SOON, SETTLED)
    return found | {
        law: _config(VISCOUS[law], flows.drive(2.0), resolution, times) for law in (QUICK_VISCOUS if quick else VISCOUS)
    }


def criteria(quick):
    """What the runs are held to."""
    bounds = {1.0: START_UP} if quick else {0.5: START_UP, 1.0: START_UP, 2.0: START_UP, LATE: STEADY}
    cases = {f"{law}_{drive}": bounds for law, drive in _driven(quick)}
    viscous = {SOON: START_UP} if quick else {SOON: START_UP, SETTLED: STEADY}
    cases |= dict.fromkeys(QUICK_VISCOUS if quick else VISCOUS, viscous)
    return [
        at_most(case, t_star, quantity, bound)
        for case, bounds in cases.items()
        for t_star, bound in bounds.items()
        for quantity in ("l2", "wall_shear")
    ]


def _driven(quick):
    """Laws that remember, each with what drives it."""
    return list(QUICK_DRIVES.items()) if quick else [(law, drive) for law in LAWS for drive in DRIVES]


def _config(law, drive, resolution, times):
    fluid = {"fluid": {"kinematic_viscosity": 1.0, "rheology": law}, "scheme": {"type": "implicit"}}
    return flows.sampled(merged(flows.NEWTONIAN, fluid, drive, resolution), times)
