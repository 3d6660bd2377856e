"""What Taichi compiles for ``consistent_image.py``, where its formulas are."""

from tisph.runtime import ti
from tisph.walls._images import ImageWalls
from tisph.walls._track import WallStress


@ti.data_oriented
class Treatment(ImageWalls):
    """Mirror images corrected by the curvature that the velocity has at the wall."""

    def __init__(self, lists, kernel, fluid, parameters):
        super().__init__(lists, kernel, fluid, parameters)
        self.fluid = fluid
        self.tracks_walls = fluid.carries_stress
        self.corrects = self.tracks_walls or self.domain.has_body_force or self.domain.oscillates
        if self.tracks_walls:
            self.track = WallStress(lists, fluid, self.domain.columns)

    def load(self, channel):
        """Place the tracked points on the walls."""
        if self.tracks_walls:
            self.track.load(channel)

    def parts(self):
        """Return what else holds fields, by name."""
        return {"track": self.track} if self.tracks_walls else {}

    def lay_out(self, now):
        """Lay out the images after a sort, and see to it that tracked points find their particles."""
        if self.tracks_walls:
            self.track.locate()
        self.lay_out_images(now)

    @ti.func
    def image_velocity(self, top: ti.template(), position, velocity):
        """Return the velocity of the image of a particle: reflected about that of the wall, on a curved profile."""
        image = ti.Vector([2.0 * self.domain.wall_velocity(top) - velocity.x, -velocity.y])
        if ti.static(self.corrects):
            distance = self.domain.wall_distance(top, position.y)
            image.x += distance * distance * self.curvature(top, position)
        return image

    @ti.func
    def curvature(self, top: ti.template(), position):
        """Return the second derivative of the velocity across the wall below or above a particle."""
        curvature = self.domain.relative_acceleration(top) / self.fluid.kinematic_viscosity[None]
        if ti.static(self.tracks_walls):
            curvature = self.track.curvature_at(top, position.x)
        return curvature

    @ti.func
    def image_stress(self, top: ti.template(), position, stress):
        """Return the polymer stress of the image: continued with its slope at the wall."""
        height = self.domain.wall_distance(top, position.y)
        if ti.static(top):
            height = -height
        return stress - 2.0 * height * self.track.slope_at(top, position.x)
