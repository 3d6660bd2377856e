"""A lattice beside the particles, on which c + d (-Laplacian) is inverted by fast Fourier transforms.

What is left of a linear system after a few Jacobi sweeps is smooth; it is brought from the particles to the nodes of
the lattice by bilinear weights, solved for there with the symbol of the five-point Laplacian, and brought back by the
same weights. As a preconditioner that leaves a number of iterations that does not depend on the number of particles.
Each node gathers from the particles in the four cells around it, in the order of their numbers: the same bits for any
number of threads.
"""

import numpy as np

from tisph.neighbours.counting_sort import counting_sort
from tisph.runtime import integer, real, scalar, size_class, threads, ti, view


@ti.data_oriented
class Lattice:
    """Nodes of the periodic box of a ``flow``, in which all places are, about as far apart as the particles.

    ``members`` are the particles cell by cell, those of cell c from ``begin[c + 1]`` to ``begin[c + 2]``; ``part`` is
    where in its ``cell`` a particle is, from 0 to 1 along each axis.
    """

    def __init__(self, points, flow, height):
        from scipy import fft  # not before it is needed: it takes as long to import as a small run

        self.fft = fft
        self.points = points
        length = flow.length
        columns, rows = fft.next_fast_len(flow.columns, real=True), fft.next_fast_len(flow.rows)
        self.shape = rows, columns
        self.columns, self.rows = integer(columns), integer(rows)
        self.per_x, self.per_y = scalar(columns / length), scalar(rows / height)
        self.share = scalar(rows * columns / (flow.rows * flow.columns))
        nodes = size_class(rows * columns + 2)
        self.begin = ti.field(ti.i32, nodes)
        self.cell, self.members = (ti.field(ti.i32, points.capacity) for _ in range(2))
        self.part = ti.field(ti.types.vector(2, real()), points.capacity)
        wave_x = (2.0 * columns / length * np.sin(np.pi * np.arange(columns // 2 + 1) / columns)) ** 2
        self.waves = self.waves_across(rows, height)[:, None] + wave_x
        self.workers = threads()  # each transforms rows of its own: the bits do not depend on their number

    def nodes(self, width):
        """Return a field of ``width`` numbers for each node."""
        return ti.field(ti.types.vector(width, real()), self.begin.shape)

    @ti.kernel
    def sort(self):
        """Take up the present places of the points."""
        particles = self.points.particles[None]
        columns, rows = self.columns[None], self.rows[None]
        ti.loop_config(serialize=self.points.serial)
        for i in range(particles):
            place = self.points.position[i]
            x, y = self.points.domain.wrap_x(place.x) * self.per_x[None], place.y * self.per_y[None]
            column = ti.max(0, ti.min(columns - 1, ti.cast(x, ti.i32)))
            row = ti.max(0, ti.min(rows - 1, ti.cast(y, ti.i32)))
            self.part[i] = [x - column, y - row]
            self.cell[i] = row * columns + column
        ti.loop_config(serialize=True)
        for _ in range(1):
            counting_sort(self.cell, self.begin, self.members, rows * columns, particles, ti.Vector([0, 0]))

    @ti.func
    def deposit(self, values: ti.template(), node):
        """Return what node number ``node`` gets of the particles' values."""
        columns, rows = self.columns[None], self.rows[None]
        column, row = node % columns, node // columns
        left, below = ti.select(column == 0, columns, column) - 1, ti.select(row == 0, rows, row) - 1
        total = 0.0 * values[0]
        for upper in ti.static(range(2)):
            for right in ti.static(range(2)):
                cell = (row if ti.static(upper) else below) * columns + (column if ti.static(right) else left)
                for s in range(self.begin[cell + 1], self.begin[cell + 2]):
                    i = self.members[s]
                    part = self.part[i]
                    along = 1.0 - part.x if ti.static(right) else part.x
                    across = 1.0 - part.y if ti.static(upper) else part.y
                    total += along * across * values[i]
        return self.share[None] * total

    @ti.func
    def interpolate(self, values: ti.template(), i):
        """Return the nodes' values at particle ``i``."""
        columns, rows = self.columns[None], self.rows[None]
        cell, part = self.cell[i], self.part[i]
        column, row = cell % columns, cell // columns
        right, above = ti.select(column == columns - 1, 0, column + 1), ti.select(row == rows - 1, 0, row + 1)
        lower = (1.0 - part.x) * values[row * columns + column] + part.x * values[row * columns + right]
        upper = (1.0 - part.x) * values[above * columns + column] + part.x * values[above * columns + right]
        return (1.0 - part.y) * lower + part.y * upper

    def waves_across(self, rows, height):
        """Return what minus the second difference across makes of each wave."""
        return (2.0 * rows / height * np.sin(np.pi * np.arange(rows) / rows)) ** 2

    def invert(self, field, own, coefficient):
        """Replace the nodes' values f by (``own`` - ``coefficient`` Laplacian)^-1 f; the mean is 0 where own is 0."""
        rows, columns = self.shape
        values = view(field)[: rows * columns].reshape(rows, columns, -1)
        symbol = own + coefficient * self.waves
        if own == 0.0:
            symbol[0, 0] = np.inf
        self.divide(values, symbol[:, :, None])

    def divide(self, values, symbol):
        """Divide the waves of ``values`` (rows, columns, width) by ``symbol``, in place."""
        known = self.fft.rfft2(values, axes=(0, 1), workers=self.workers)
        known /= symbol
        values[...] = self.fft.irfft2(known, s=self.shape, axes=(0, 1), workers=self.workers, overwrite_x=True)


@ti.data_oriented
class WalledLattice(Lattice):
    """Nodes of a channel, for fields that mirror oddly in its walls: the first row of nodes, at the bottom wall, holds
    zeros, and stands for the row at the top wall too. Waves across are sines."""

    def waves_across(self, rows, height):
        """Return what minus the second difference across makes of each sine."""
        return (2.0 * rows / height * np.sin(0.5 * np.pi * np.arange(1, rows) / rows)) ** 2

    def divide(self, values, symbol):
        """Divide the waves of ``values`` (rows, columns, width) by ``symbol``, in place."""
        known = self.fft.dst(values[1:], 1, axis=0, workers=self.workers)
        known = self.fft.rfft(known, axis=1, workers=self.workers)
        known /= symbol
        known = self.fft.irfft(known, self.shape[1], axis=1, workers=self.workers, overwrite_x=True)
        values[1:] = self.fft.idst(known, 1, axis=0, workers=self.workers, overwrite_x=True)
        values[0] = 0.0
