"""Ghosts of the implicit scheme: points beyond the walls, whose values close the rows of the particles near them.

Of a field u that obeys u_t = nu u_yy + g near a wall with velocity U(t), the Taylor series in the distance d from the
wall gives for a particle F and its mirror image I

    u_I = 2 U - u_F + d^2 w_2 + d^4/12 w_4 + O(d^6),    w_2 = u_yy = (U' - g)/nu,  w_4 = u_yyyy = U''/nu^2

(the odd terms cancel; p_x = 0 at the wall as in ``walls/consistent_image.py``, of which this is the continuation to
the order of the operators): ``consistent_image``. Without the terms in w: ``comoving_image``, and ``virtual_image``,
where the ghosts stay on the lattice and u_F is interpolated at their mirror points.
"""

import math

from tisph.runtime import integer, real, scalar, ti, view


@ti.data_oriented
class Ghosts:
    """What all ghosts have: ``depth[k]`` of ghost k beyond wall ``side[k]``, ``count`` of them, series in the depth.

    ``reach``: how far from a wall a particle has ghosts among its neighbours.
    """

    mirrors = False
    """Whether the points list the neighbours of mirror points."""

    def __init__(self, points, domain, reach):
        self.points, self.domain, self.reach = points, domain, scalar(reach)
        self.count, self.needed = points.ghosts, integer(0)
        self.side = ti.field(ti.i32, shape=points.most_ghosts)
        self.depth = ti.field(real(), shape=points.most_ghosts)
        self.series = ti.field(real(), shape=(2, 3))

    def find(self):
        """Place the ghosts for the present places of the particles, before neighbours are listed."""

    def weigh(self):
        """Prepare what ghosts take from their neighbours, for the final places of the particles."""

    def overflow(self):
        """Return the number of ghosts if there was no room for them, else 0."""
        needed = int(view(self.needed))
        return needed if needed > self.points.room else 0

    @ti.func
    def follow(self, k):
        """Let ghost ``k`` follow particles that have been shifted."""

    def prescribe(self, bottom, top):
        """Take up the series of each wall, c0 + c1 d^2 + c2 d^4: three numbers."""
        view(self.series)[...] = bottom, top

    @ti.func
    def given(self, k):
        """Return what the series of its wall prescribes for ghost ``k``."""
        square = self.depth[k] * self.depth[k]
        side = self.side[k]
        return self.series[side, 0] + square * (self.series[side, 1] + square * self.series[side, 2])

    @ti.func
    def series_slope(self, k):
        """Return the derivative across the channel of the series at ghost ``k``."""
        side, depth = self.side[k], self.depth[k]
        outwards = 2.0 * depth * (self.series[side, 1] + 2.0 * depth * depth * self.series[side, 2])
        return ti.select(side == 1, outwards, -outwards)

    @ti.func
    def near(self, i):
        """Tell whether particle ``i`` is within reach of a wall."""
        y = self.points.place[i].y
        return y < self.reach[None] or self.domain.gap[None] - y < self.reach[None]


@ti.data_oriented
class MirrorGhosts(Ghosts):
    """Mirror images: ghost k is that of particle ``source[k]``."""

    def __init__(self, points, domain, reach, channel):
        super().__init__(points, domain, reach)
        self.source = ti.field(ti.i32, shape=self.side.shape)

    @staticmethod
    def room(channel, reach):
        """Return the number of ghosts to have room for."""
        rows = math.ceil(1.5 * reach / channel.spacing) + 1
        return 2 * min(rows, channel.rows) * channel.columns

    @ti.kernel
    def find(self):
        """Mirror every particle within reach of a wall."""
        particles, reach = self.points.particles[None], self.reach[None]
        ti.loop_config(serialize=True)
        for _ in range(1):
            found = 0
            for top in ti.static(range(2)):
                for i in range(particles):
                    if self.domain.inside(top, self.points.place[i].y) < reach:
                        k = ti.min(found, self.source.shape[0] - 1)
                        self.source[k] = i
                        self.side[k] = top
                        self.follow(k)
                        found += 1
            self.needed[None] = found
            self.count[None] = ti.min(found, self.source.shape[0])

    @ti.func
    def follow(self, k):
        """Place ghost ``k`` where the mirror image of its source is."""
        for top in ti.static(range(2)):
            if self.side[k] == top:
                place = self.points.place[self.source[k]]
                self.depth[k] = self.domain.inside(top, place.y)
                self.points.place[self.points.most + k] = self.domain.mirrored(top, place)

    @ti.func
    def value(self, values: ti.template(), k):
        """Return the value that ghost ``k`` mirrors."""
        return values[self.source[k]]
