"""One word for one meaning, and that of the field's textbooks: words and phrases that are not used here."""

import re
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[2]
TEXTS = [
    *sorted((ROOT / "tisph").rglob("*.py")),
    *sorted((ROOT / "docs").rglob("*.md")),
    *sorted((ROOT / "docs" / "_gallery").glob("*.yaml")),
    *sorted((ROOT / "configs").glob("*.yaml")),
    *sorted((ROOT / "tisph" / "suites").glob("*.yaml")),
    ROOT / "README.md",
    ROOT / "CONTRIBUTING.md",
]

READ = {path: " ".join(path.read_text(encoding="utf-8").split()) for path in TEXTS}

# A pattern that is not used, and what is said instead.
PHRASES = {
    r"\bflows? (that )?turns?\b|\bturning flows?\b|where it turns": "two-dimensional flow",
    r"\bliquids?\b": "fluid",
    r"\b(fluids?|ones?|models?) with(out)? memory\b|\bwithout memory\b": "viscoelastic, inelastic",
    r"without sound": "with no acoustic time-step limit",
    r"\ba stress drives\b|\bdriven by a stress\b": "stress-controlled wall",
    r"\bwalls? (that|which) (jump|jumps|jumped|has jumped|have jumped)\b": "impulsively started wall",
    r"walls of any shape": "curved walls",
    r"\ba spacing deep\b": "one spacing thick",
    r"rows? (that )?slides?( past| along)": "layers shear",
    r"\berrs?\b(?!=)": "has an error of",
    r"\bto rounding\b": "to round-off",
    r"\bsame bits\b": "bitwise reproducible",
    r"\bon any arrangement\b": "polynomially consistent",
    r"(fell|falls?) back to order": "order reduction",
    r"preconditioner enough": "Jacobi suffices",
    r"lattice beside the particles": "auxiliary grid",
    r"free by a constant": "up to a constant",
    r"\bwhat (the )?walls give\b": "boundary terms",
    r"velocities expected": "extrapolated velocities",
    r"\btwo turns\b": "two outer iterations",
    r"\bhas settled\b|\bhad settled\b": "is developed",
    r"\bturns? as a solid\b": "rigid rotation",
    r"\bto and fro\b": "oscillating",
    r"\bsolved to 1e-8\b": "numerical reference",
    r"\bsees? as far as\b": "support radius",
    r"\bmirror(s|ed)? (oddly|evenly)\b": "odd or even reflection",
    r"\bover the density\b": "per unit density",
    r"polymer answers": "elastic faster than the diffusive time over dx",
    r"\bwhat is left\b": "residual",
    r"\bdies? away\b|\bdied away\b": "decays",
    r"plate rings|\bringing\b(?!_plate)": "free oscillation",
    r"\bas read\b": "apparent",
    r"\blittle solvent\b": "low viscosity ratio",
    r"\b(stopped|ended|refused|refuses \w+) by name\b": "with a specific message",
    r"\bgoes with\b": "scales with",
    r"\bin disorder\b": "for disordered particles",
    r"\bgoes before\b": "takes precedence",
}

# Names that the code once had, and those of the field that replaced them.
NAMES = {
    "CornerPaths": "SingularPaths",
    "SlidingCorner": "CornerSingularity",
    "_logarithm": "_log_conformation",
    "ElasticStages": "CoupledStages",
    "ElasticSolver": "CoupledSolver",
    "ElasticWalls": "WallDerivatives",
    "AtWall": "WallSystem",
    "ViscoelasticStep": "NonNewtonianStep",
    "HeavyPlate": "InertialWall",
    "HeavyWalls": "InertialWall",
    "HeavyStages": "InertialWall",
    "PlateWalls": "MasslessWall",
    "PlateSolver": "MasslessWall",
    "DrivenWall": "StressControlledWall",
    "DrivenWalls": "StressControlledWalls",
    "DrivenStages": "StressControlledStages",
    "WallSeries": "WallTaylorSeries",
    "VirtualGhosts": "FixedGhosts",
    "implicit_rows": "ImplicitLayers",
    "elastic_rows": "CoupledLayers",
    "explicit_rows": "ExplicitLayers",
    "ElasticRows": "CoupledLayers",
    "LeastSquaresRows": "LeastSquaresOperators",
    "WalledLattice": "DirichletGrid",
    "MultilevelSolver": "TwoLevelBiCGStab",
    "OpenBox": "PeriodicDomain",
    "open_across": "periodic_y",
    "WallTrack": "WallStress",
    "Reflections": "MirrorPointDummies",
    "KernelAverages": "ShepardDummies",
    "_pointwise": "_local_newton",
    "_turning": "_two_dimensional",
    "Monitored": "ExtraSeries",
    "LaterWall": "ShiftedWall",
    "jolt": "impulse_rhs",
    "twist": "normal_curl",
    "yield_way": "apply_impulse",
    "let_go": "apply_stress_jump",
    "look_back": "sum_history",
    "slow_numbers": "stokes_coefficients",
    "inertial_numbers": "inertial_coefficients",
    "HOPELESS": "MAX_LOG_JUMP",
    "FARTHER": "WALL_SUPPORT",
    "led_to": "cut_by",
    "EVENED": "VOLUME_SMOOTHING",
    "take_along": "shift_fields",
    "looks_inside": "uses_mirror_points",
    "came_from": "departure_point",
    "normal_growth": "normal_stress_growth",
    "spreading_share": "diffusive_fraction",
    "flow_numbers": "flow_quantities",
    "loses_its_scale": "vanishing_scale",
    "in_own_frame": "in_flow_frame",
    "misfits": "incommensurate",
}

# Attributes and methods that had a word of their own, or one with several meanings.
ATTRIBUTES = {
    "changes": "jump_times",
    "driven": "stress_controlled",
    "ways": "periodic_offsets",
    "give": "set_dummy",
    "seen_from": "relative_to",
    "reach": "cutoff, radius, bounding_radius, decay_length",
    "stretch": "displacement_factor",
    "inside": "contains, to_body_frame",
    "outside": "to_lab_frame",
    "turned": "rotated",
    "room": "ghost_capacity",
    "spin": "angular_velocity",
    "dropped": "singular",
    "reduced": "order_reduced",
}

# Where a listed word is meant: file name, the word as it stands there, and why.
EXCEPTIONS = {
    ("rheometry.yaml", "ringing"): "rows that tisph verify prints, and programs may read",
    ("readers.py", "liquid"): "what files of other codes may call their fluid",
    ("start_up.py", "liquids"): "the title of a book",
    ("multi_mode.py", "liquids"): "the title of a book",
    ("power_law.py", "liquids"): "the title of a book",
}


@pytest.mark.parametrize("pattern", PHRASES)
def test_a_phrase_of_its_own_is_not_used(pattern):
    expression = re.compile(pattern, re.IGNORECASE)
    found = [
        f"{path.relative_to(ROOT)}: {match.group()}"
        for path, text in READ.items()
        for match in expression.finditer(text)
        if (path.name, match.group().lower()) not in EXCEPTIONS
    ]
    assert not found, f"say {PHRASES[pattern]!r} instead: {found}"


def test_names_are_those_of_the_field():
    used = {path: set(re.findall(r"\w+", text)) for path, text in READ.items()}
    found = [
        f"{path.relative_to(ROOT)}: {name}, say {NAMES[name]}" for path in used for name in used[path] & set(NAMES)
    ]
    assert not found


def test_attributes_have_one_meaning():
    code = {path: text for path, text in READ.items() if path.suffix == ".py"}
    found = [
        f"{path.relative_to(ROOT)}: {name}, say {ATTRIBUTES[name]}"
        for path, text in code.items()
        for name in re.findall(r"(?:def |self\.)(\w+)\b", text)
        if name in ATTRIBUTES
    ]
    assert not found


def test_names_of_tests_have_at_most_a_dozen_words():
    names = [
        name for path in ROOT.glob("tests/*/*.py") for name in re.findall(r"def test_(\w+)", path.read_text("utf-8"))
    ]
    assert [name for name in names if name.count("_") > 11] == []
