"""Draw how the five wall treatments give wall particles their velocity: ``python media/walls.py``.

Lengths are in particle spacings, with the wall at height 0; an arrow is as long as the velocity that it shows.
"""

from pathlib import Path

import numpy as np
from matplotlib.axes import Axes
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure
from matplotlib.patches import Circle, FancyArrow, Polygon, Rectangle

from tisph.report import style

FLUID, IMAGE, LINE, PROFILE, SHADE = "#2b6cb0", "#c05621", style.TEXT, "#2f855a", "#dbe8f6"
RADIUS = 0.12  # of a particle
LEFT, RIGHT, BOTTOM, TOP = -0.6, 5.4, -2.3, 2.15

WALL_VELOCITY, SLOPE = 0.55, -0.13
NEAR = np.array([(0.3, 0.56), (1.08, 0.42), (2.85, 0.58), (3.65, 0.46), (4.6, 0.56)])
FAR = np.array([(-0.1, 1.52), (0.85, 1.46), (1.8, 1.56), (3.1, 1.42), (4.1, 1.55)])
PARTICLES = np.concatenate([NEAR, FAR])
LAYERS = np.array([(x, y) for y in (-0.5, -1.5) for x in range(5)], dtype=float)

FIRST = np.array([2.0, -0.5])  # the wall particle of LAYERS whose velocity is explained
NEAREST = PARTICLES[1]  # to it


def profile(y, slope=SLOPE, curvature=0.0):
    """Velocity at height ``y``, of the liquid and of its continuation beyond the wall."""
    return WALL_VELOCITY + slope * y + 0.5 * curvature * y**2


def draw_arrow(axes: Axes, place, velocity, colour, **settings) -> None:
    """Draw a velocity as an arrow from ``place``."""
    arrow = FancyArrow(
        *place, velocity, 0.0, width=0.045, head_width=0.17, head_length=0.17,
        length_includes_head=True, facecolor=colour, linewidth=0, zorder=6,
    )  # fmt: skip
    arrow.set(**settings)
    axes.add_patch(arrow)


def draw_wall(axes: Axes, right: float, y: float = 0.0) -> None:
    """Draw a wall's surface at height ``y`` from the left to ``right``."""
    hatch = Rectangle((LEFT, y - 0.14), right - LEFT, 0.14, facecolor="white", edgecolor=style.MUTED, zorder=1)
    hatch.set(hatch="/////", linewidth=0)
    axes.add_patch(hatch)
    axes.plot([LEFT, right], [y, y], color=LINE, linewidth=2, zorder=2, solid_capstyle="butt")


class Panel:
    """One drawing: liquid above the wall, wall particles below."""

    def __init__(self, axes: Axes, name: str, formula: str, words: str):
        self.axes = axes
        axes.set(xlim=(LEFT, RIGHT), ylim=(BOTTOM, TOP), aspect="equal", xticks=[], yticks=[])
        axes.set_title(name, fontsize=14, weight="bold", loc="left", family="DejaVu Sans Mono", pad=7)
        axes.add_patch(Rectangle((LEFT, BOTTOM), RIGHT - LEFT, -BOTTOM, facecolor="#f6f6f7", linewidth=0, zorder=0))
        draw_wall(axes, RIGHT)
        self.velocity((RIGHT - 0.65, 0.0), WALL_VELOCITY, LINE)
        self.label((RIGHT - 0.28, 0.23), "$u_W$")
        axes.text(0.0, -0.07, formula, transform=axes.transAxes, fontsize=14, va="top")
        axes.text(0.0, -0.185, words, transform=axes.transAxes, fontsize=10.5, va="top", linespacing=1.4)

    def particles(self, places, velocities, colour, strong=()):
        """Draw discs with their velocities, pale but for those whose index is in ``strong``."""
        for index, (place, velocity) in enumerate(zip(places, velocities, strict=True)):
            alpha = 1.0 if index in strong else 0.4
            self.axes.add_patch(Circle(place, RADIUS, facecolor=colour, linewidth=0, alpha=alpha, zorder=5))
            self.velocity(place, velocity, colour, alpha=alpha)

    def velocity(self, place, velocity, colour, **settings):
        """Draw a velocity as an arrow from ``place``."""
        draw_arrow(self.axes, place, velocity, colour, **settings)

    def label(self, place, text, offset=(0.0, 0.0)):
        """Write ``text`` at ``place``, moved by ``offset``."""
        self.axes.text(*np.add(place, offset), text, fontsize=12.5, ha="center", va="center", zorder=8)

    def line(self, *places, **settings):
        """Draw a construction line through ``places``."""
        settings = {"color": LINE, "linewidth": 1.1, "linestyle": (0, (4, 2.5)), "zorder": 4, **settings}
        self.axes.plot(*np.transpose(places), **settings)

    def height(self, x, y, text, side=1):
        """Mark the distance of a particle at (``x``, ``y``) from the wall; ``text`` at its right or, with -1, left."""
        self.axes.annotate(
            "", (x, 0.0), (x, y - np.copysign(RADIUS, y)), zorder=4,
            arrowprops={"arrowstyle": "<->", "mutation_scale": 8, "linewidth": 1.0, "shrinkA": 0, "shrinkB": 0},
        )  # fmt: skip
        self.label((x + 0.2 * side, 0.45 * y), text)


def fixed_image(axes: Axes) -> None:
    """Linear extrapolation from the nearest fluid particle."""
    panel = Panel(
        axes, "fixed_image", r"$u_I = u_F + (1 + d_I/d_F)\,(u_W - u_F)$",
        "Wall layers. F is the fluid particle nearest to I, seldom straight\n"
        "above it; $d_F$ is taken to be at least a quarter of the spacing.",
    )  # fmt: skip
    stretch = 1.0 - FIRST[1] / NEAREST[1]
    velocities = profile(LAYERS[:, 1])
    velocities[2] = profile(NEAREST[1]) + stretch * (WALL_VELOCITY - profile(NEAREST[1]))
    panel.particles(PARTICLES, profile(PARTICLES[:, 1]), FLUID, strong=[1])
    panel.particles(LAYERS, velocities, IMAGE, strong=[2])
    panel.line(NEAREST, FIRST)
    panel.height(*NEAREST, "$d_F$", side=-1)
    panel.height(*FIRST, "$d_I$")
    on_wall = NEAREST + (FIRST - NEAREST) * NEAREST[1] / (NEAREST[1] - FIRST[1])
    panel.axes.add_patch(Circle(on_wall, 0.06, facecolor=LINE, zorder=7))
    panel.label(on_wall, "W", (0.14, 0.2))
    panel.label(NEAREST, "F", (0.0, 0.3))
    panel.label(FIRST, "I", (0.05, -0.32))


def virtual_image(axes: Axes) -> None:
    """Reflection of the velocity fitted at the mirror point."""
    panel = Panel(
        axes, "virtual_image", r"$u_I = 2\,u_W - u_V$",
        "Wall layers. V is the mirror point of I, and $u_V$ a linear\nleast-squares fit to the fluid around it.",
    )  # fmt: skip
    virtual = FIRST * (1, -1)
    radius = 1.3
    used = [i for i, place in enumerate(PARTICLES) if np.hypot(*(place - virtual)) < radius]
    disc_above_wall(panel, virtual, radius)
    for i in used:
        panel.line(virtual, PARTICLES[i], linestyle="-", linewidth=0.9, color=FLUID)
    panel.particles(PARTICLES, profile(PARTICLES[:, 1]), FLUID, strong=used)
    panel.particles(LAYERS, profile(LAYERS[:, 1]), IMAGE, strong=[2])
    panel.axes.add_patch(Circle(virtual, RADIUS, facecolor="white", edgecolor=FLUID, linewidth=1.6, zorder=7))
    panel.velocity(np.add(virtual, (RADIUS, 0.0)), profile(virtual[1]), "white", edgecolor=FLUID, linewidth=1.2)
    panel.height(*virtual, "$d$")
    panel.height(*FIRST, "$d$")
    panel.label(virtual, "V", (0.22, 0.24))
    panel.label(FIRST, "I", (0.05, -0.32))


def comoving_image(axes: Axes) -> None:
    """Mirror images."""
    panel = Panel(
        axes, "comoving_image", r"$u_I = 2\,u_W - u_F, \qquad v_I = -v_F$",
        "Every fluid particle F near the wall has an image I, which\n"
        "mirrors it and moves along: the profile goes on straight.",
    )  # fmt: skip
    pair(panel, PARTICLES[7], profile)


def consistent_image(axes: Axes) -> None:
    """Mirror images with the curvature that the momentum equation demands."""
    panel = Panel(
        axes, "consistent_image", r"$u_I = 2\,u_W - u_F + d^{\,2}\,u_{yy}|_W$",
        "Mirror images on a curved profile; the momentum equation at\n"
        r"the wall gives $u_{yy}|_W = (\dot{u}_W - g - S_{xy,y}/\rho)\,/\,\nu_s$",
    )  # fmt: skip
    curvature = -0.15

    def curved(y):
        return profile(y, slope=-0.05, curvature=curvature)

    fluid = PARTICLES[7]
    straight = 2 * WALL_VELOCITY - curved(fluid[1])
    pair(panel, fluid, curved)
    image = fluid * (1, -1)
    panel.velocity(image, straight, "white", edgecolor=IMAGE, linewidth=1.0, linestyle=(0, (2, 1.5)), zorder=4)
    panel.line(np.add(fluid, (curved(fluid[1]), 0.0)), np.add(image, (straight, 0.0)), linewidth=0.9)
    tips = image[0] + np.array([curved(image[1]), straight])
    panel.axes.annotate(
        "", (tips[0], image[1] - 0.2), (tips[1], image[1] - 0.2),
        arrowprops={"arrowstyle": "->", "color": LINE, "shrinkA": 0, "shrinkB": 0},
    )  # fmt: skip
    panel.label((tips.mean() + 0.15, image[1] - 0.44), r"$d^{\,2}\,u_{yy}|_W$")


def adami(axes: Axes) -> None:
    """Kernel averages."""
    panel = Panel(
        axes, "adami", r"$u_I = 2\,u_W - \sum u_F W_{IF}\,/\,\sum W_{IF}$",
        "Wall layers. The average over the fluid in reach of the\nkernel W around I; nearer particles count more.",
    )  # fmt: skip
    radius = 2.45
    distances = np.hypot(*(PARTICLES - FIRST).T)
    used = np.flatnonzero(distances < radius)
    weights = (1 - distances / radius) ** 2
    disc_above_wall(panel, FIRST, radius)
    panel.axes.add_patch(Circle(FIRST, radius, fill=False, edgecolor=LINE, linewidth=1.0, linestyle=(0, (4, 2.5))))
    for i in used:
        panel.line(FIRST, PARTICLES[i], linestyle="-", linewidth=0.5 + 9 * weights[i], color=FLUID, alpha=0.6)
    mean = np.average(profile(PARTICLES[used, 1]), weights=weights[used])
    velocities = profile(LAYERS[:, 1])
    velocities[2] = 2 * WALL_VELOCITY - mean
    panel.particles(PARTICLES, profile(PARTICLES[:, 1]), FLUID, strong=used)
    panel.particles(LAYERS, velocities, IMAGE, strong=[2])
    panel.label(FIRST, "I", (0.05, -0.32))


def pair(panel: Panel, fluid, velocity) -> None:
    """Draw the liquid with its mirror images, and the construction of the image of particle ``fluid``."""
    chosen = [int(np.flatnonzero((fluid == PARTICLES).all(axis=1))[0])]
    images, image = PARTICLES * (1, -1), fluid * (1, -1)
    panel.particles(PARTICLES, velocity(PARTICLES[:, 1]), FLUID, strong=chosen)
    panel.particles(images, velocity(images[:, 1]), IMAGE, strong=chosen)
    heights = np.linspace(image[1], fluid[1], 60)
    panel.line(*zip(fluid[0] + velocity(heights), heights, strict=True), linestyle="-", linewidth=1.6, color=PROFILE)
    panel.velocity((fluid[0], 0.0), WALL_VELOCITY, LINE)
    panel.height(*fluid, "$d$", side=-1)
    panel.height(*image, "$d$", side=-1)
    panel.label(fluid, "F", (0.0, 0.3))
    panel.label(image, "I", (0.0, -0.3))


def disc_above_wall(panel: Panel, centre, radius) -> None:
    """Shade the part of a disc that lies in the liquid."""
    angles = np.linspace(0, 2 * np.pi, 400)
    x, y = centre[0] + radius * np.cos(angles), centre[1] + radius * np.sin(angles)
    panel.axes.add_patch(Polygon(np.stack([x[y > 0], y[y > 0]], 1), facecolor=SHADE, linewidth=0, zorder=1))


def key(axes: Axes) -> None:
    """Explain the signs that all drawings share."""
    axes.set(xlim=(LEFT, RIGHT), ylim=(BOTTOM, TOP), aspect="equal")
    axes.set_axis_off()
    heights = TOP - 0.25 - 0.52 * np.arange(5)
    for y, colour in zip(heights, (FLUID, IMAGE), strict=False):
        axes.add_patch(Circle((LEFT + 0.2, y), RADIUS, facecolor=colour, linewidth=0))
        draw_arrow(axes, (LEFT + 0.2, y), WALL_VELOCITY, colour)
    axes.add_patch(Circle((LEFT + 0.2, heights[2]), RADIUS, facecolor="white", edgecolor=FLUID, linewidth=1.6))
    draw_wall(axes, LEFT + 0.75, heights[3])
    axes.plot([LEFT, LEFT + 0.75], 2 * [heights[4]], color=PROFILE, linewidth=1.6)
    words = (
        "fluid particle F and its velocity",
        "wall particle, or image, I and its velocity",
        "virtual point: no particle is there",
        "wall, which moves at $u_W(t)$",
        "velocity profile, through the tips of arrows",
    )
    for y, text in zip(heights, words, strict=True):
        axes.text(LEFT + 1.05, y, text, va="center", fontsize=11)
    notes = (
        "$d$, $d_F$, $d_I$   distances from the wall\n"
        "$g$   body acceleration,   $\\rho$   density on the wall\n"
        "$\\nu_s$   viscosity of the solvent (all of it without polymer)\n"
        "$S_{xy}$   shear stress of the polymer (0 without)"
    )
    axes.text(LEFT + 0.05, heights[-1] - 0.5, notes, va="top", fontsize=11, linespacing=1.75)


TREATMENTS = (fixed_image, virtual_image, comoving_image, consistent_image, adami)


def draw(path: Path) -> None:
    """Write the picture to ``path``."""
    with style.plot_style():
        figure = Figure((15.0, 10.4), dpi=110)
        FigureCanvasAgg(figure)
        panels = figure.subplots(2, 3).ravel()
        figure.subplots_adjust(left=0.02, right=0.98, top=0.96, bottom=0.11, wspace=0.06, hspace=0.34)
        for function, axes in zip((*TREATMENTS, key), panels, strict=True):
            function(axes)
        figure.savefig(path, format="png")


if __name__ == "__main__":
    draw(Path(__file__).with_name("walls.png"))
