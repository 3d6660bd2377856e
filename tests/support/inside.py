"""Inner parts of the package that tests look at: the one place to change where a part moves or has another name.

``from inside import NAME`` imports the module of that part alone.
"""

import importlib

PARTS = {
    "bodies._clearance": "clearance_problems=problems",
    "interface": "listen=_listen message_error=_error",
    "measures.fits": "cell_rule=_rule",
    "measures.rheometry": (
        "amplitudes=_amplitudes creep=_creep flow_curve=_flow_curve middle=_middle oscillation=_oscillation "
        "slowest_pair=_slowest_pair start_up=_start_up step_strain=_step_strain window=_window"
    ),
    "numerics.shifting": "SCATTER",
    "observers.samples": "Description Storage write_snapshot",
    "report.movie": "Ranges=_Ranges overlays=_overlays",
    "results._results": "Trajectories typed",
    "scenes": "axisymmetric=_axisymmetric scene_protocol=_scene",
    "scenes._cell": "Cell",
    "scenes._cell_flow": "STRESS_BY_BODIES STRESS_BY_CONTACTS STRESS_ON_WALLS",
    "scenes._scene": "PolymerParameters",
    "schemes": "scheme_estimate=_estimate scheme_protocol=_protocol",
    "schemes._estimate": (
        "EXPLICIT_COST IMPLICIT_COST IMPLICIT_OVERHEAD ImplicitLayers MOST_STEPS "
        "estimate_least_squares=least_squares off_layers profile_lost step_counts"
    ),
    "schemes._local_newton": "SMALL eliminate matrix",
    "schemes._protocol": "SampleEstimate Scheme",
    "schemes._step_control": (
        "LARGEST_FACTOR LARGEST_MULTISTEP_FACTOR MOST_ATTEMPTS REJECTED SAFETY SHARE SMALLEST_FACTOR "
        "StepControl StepPlan"
    ),
    "schemes.implicit": "two_dimensional=planar",
    "schemes.implicit.channel": "channel_operators=operators channel_step=step",
    "schemes.implicit.channel.models": "ViscoelasticModel channel_conformation_excess=conformation_excess",
    "schemes.implicit.channel.step": "B_HAT FlowState GAMMA STAGES_A=A STAGES_B=B",
    "schemes.implicit.channel.stress_controlled": "MasslessWall",
    "schemes.implicit.channel.walls": "CoupledWall OBEY_MOMENTUM PrescribedWall",
    "schemes.implicit.planar": (
        "BETWEEN_WALLS COST OVERHEAD STARTING guessed_steps=_guessed_steps "
        "log_conformation log_conformation_with_swirl two_dimensional_scheme=scheme "
        "step_limits viscoelastic_stress wall_points"
    ),
    "schemes.implicit.planar.corner_singularities": "CornerSingularities FAR STEEPEST SingularPaths",
    "schemes.implicit.planar.free_bodies": "Contact RESIDUAL",
    "schemes.implicit.planar.problem": "Problem problem_of",
    "schemes.implicit.planar.scheme": "COURANT SplittingScheme",
    "schemes.implicit.planar.step_limits": "FIRST TOLERANCE two_dimensional_step_control=step_control",
    "schemes.implicit.planar.time_levels": "PlanarCoordinates TimeWeights VELOCITIES",
    "schemes.implicit.planar.wall_boundary": "scatter",
    "schemes.implicit.planar.wall_points": "WallPoints WallsOfRevolution",
    "schemes.wcsph._bodies": "Loads",
    "schemes.wcsph._boundaries": "ImpulsiveStart",
    "schemes.wcsph._time_step": "SHIFT shift_speed stiffness time_step_limits",
    "schemes.wcsph.operators._pairs": "WeightTable",
    "schemes.wcsph.walls._dummies": "layers_in",
    "schemes.wcsph.walls.virtual_image": "RADIUS SMALLEST_DETERMINANT",
    "simulation.recording": "steady=_steady",
}
"""Module below ``tisph`` -> names in it, or ``name in tests=name there``: attributes, or modules of that package."""

PLACES = {
    part.partition("=")[0]: (module, part.rpartition("=")[2])
    for module, parts in PARTS.items()
    for part in parts.split()
}


def __getattr__(name):
    """Return a part by its name in tests."""
    if name not in PLACES:
        raise AttributeError(name)
    module, attribute = PLACES[name]
    owner = importlib.import_module(f"tisph.{module}")
    if hasattr(owner, attribute):
        return getattr(owner, attribute)
    return importlib.import_module(f"tisph.{module}.{attribute}")
