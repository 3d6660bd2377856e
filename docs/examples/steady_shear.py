"""Print viscosity and N1 of polymers in steady shear, over their values at small rates: ``python steady_shear.py``."""

from tisph import registry
from tisph.exact.uniform_shear import UniformShear

POLYMERS = [
    {"type": "oldroyd_b"},
    {"type": "giesekus", "mobility": 0.1},
    {"type": "giesekus", "mobility": 0.3},
    {"type": "phan_thien_tanner", "extensibility": 0.02},
    {"type": "phan_thien_tanner", "extensibility": 0.25},
    {"type": "phan_thien_tanner", "extensibility": 0.25, "form": "exponential"},
    {"type": "fene_p", "maximum_extension": 20},
    {"type": "fene_p", "maximum_extension": 100},
]
RATES = 0.1, 1.0, 10.0

print("| law | viscosity at 0.1/λ | 1/λ | 10/λ | N1/rate² at 0.1/λ | 1/λ | 10/λ |\n|---|--:|--:|--:|--:|--:|--:|")
for polymer in POLYMERS:
    mode = registry.load("rheology", polymer["type"]).Mode(relaxation_time=1.0, **polymer)
    shear = UniformShear(lambda rate: 0.0 * rate, (mode.law(1.0),))  # a polymer viscosity of 1, without solvent
    steady = [shear.steady(rate) for rate in RATES]
    cells = [stress / rate for rate, (stress, _) in zip(RATES, steady, strict=True)]
    cells += [n1 / (2.0 * rate**2) for rate, (_, n1) in zip(RATES, steady, strict=True)]
    law = [f"`{polymer['type']}`", *(f"`{key}` {value}" for key, value in polymer.items() if key != "type")]
    print(f"| {', '.join(law)} | {' | '.join(f'{cell:.3g}' for cell in cells)} |")
