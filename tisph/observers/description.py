"""What the files of a run say of themselves: software, flow, units, and the config that made them."""

from dataclasses import dataclass
from functools import cached_property
from typing import Any

from tisph.snapshot import STRESSES, STRESSES_AROUND
from tisph.version import __version__


@dataclass(frozen=True)
class Description:
    """Of the run of ``config`` in ``scene``; the same for the same config, whenever it runs."""

    config: Any
    scene: Any

    @cached_property
    def resolved(self):
        """The config as YAML; to write that takes longer than all else here."""
        return self.config.resolved_yaml()

    def attributes(self, content):
        """Return names and values, text and numbers in the config's units, of a file with this ``content``."""
        scene, units = self.scene, self.config.units
        return {
            "content": content,
            "name": self.config.name,
            "tisph_version": __version__,
            "scene": self.config.scene,
            "units": f"length {units.length}, mass {units.mass}, time {units.time}",
            **scene.description(),
            "spacing": scene.spacing,
            "density": scene.density,
            "kinematic_viscosity": scene.kinematic_viscosity,
            "rheology": self.config.fluid.rheology.type,
            **(vars(scene.polymer) if scene.polymer else {}),
            "reference_velocity": scene.reference_velocity,
            "frame_velocity": scene.frame_velocity,
            "config": self.resolved,
        }

    @property
    def units(self):
        """Units by the name of a field."""
        length, mass, time = (getattr(self.config.units, name) for name in ("length", "mass", "time"))
        fields = {"x": length, "y": length, "u": f"{length}/{time}", "v": f"{length}/{time}", "w": f"{length}/{time}"}
        stresses = ("pressure", *STRESSES, *STRESSES_AROUND, "normal_stress")
        fields |= {"centre": length, "velocity": f"{length}/{time}", "angle": "rad", "angular_velocity": f"rad/{time}"}
        loads = {"force": f"{mass}/{time}^2", "torque": f"{mass} {length}/{time}^2"}  # per length across the plane
        if self.config.axisymmetric:
            loads = {"force": f"{mass} {length}/{time}^2", "torque": f"{mass} {length}^2/{time}^2"}
        fields |= {"contact_force": loads["force"], "t": time}
        fields |= dict.fromkeys(("stresslet", "contact_torque", "contact_stresslet"), loads["torque"])
        fields |= {f"{part}{name}": unit for name, unit in loads.items() for part in ("", "pressure_")}
        fields["vorticity"] = f"1/{time}"
        return {**fields, "density": f"{mass}/{length}^3", **dict.fromkeys(stresses, f"{mass}/({length} {time}^2)")}

    def comment(self, content):
        """Return the attributes as lines that begin with ``#``."""
        lines = []
        for name, value in self.attributes(content).items():
            first, *more = str(value).splitlines() if name != "config" else ["", *value.splitlines()]
            lines += [f"# {name}: {first}".rstrip(), *(f"#   {line}" for line in more)]
        return "".join(f"{line}\n" for line in lines)
