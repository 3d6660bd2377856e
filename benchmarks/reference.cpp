// A tuned loop with the arithmetic of `operators: standard`, to compare the throughput of tisph with.
//
// Particles, pairs and steps are those of tisph/schemes/wcsph.py with tisph/operators/standard.py, Wendland C2 and
// mirror images; lists are renewed by the rule of tisph/neighbours/verlet.py with a linear reference profile. One pass
// over the neighbours gives pressure, viscosity and continuity. Rows of the table are padded to whole vectors with a
// point far away, particles are sorted by cells, and only those near the ends of the period wrap distances.
//
//     c++ -std=c++17 -O3 -march=native -ffast-math -fopenmp reference.cpp -o reference
//     ./reference precision=f64 threads=2 rows=50 columns=100 state=start.bin ...    (all words: Case and run)
//
// `state` is a file of x, y, u, v of each particle, as doubles; `out` receives the same in the same order at the end.
// Prints a line of JSON, as `tisph bench throughput` wants it.

#include <omp.h>

#include <algorithm>
#include <array>
#include <chrono>
#include <cmath>
#include <cstdint>
#include <cstdio>
#include <exception>
#include <fstream>
#include <map>
#include <stdexcept>
#include <string>
#include <utility>
#include <vector>

constexpr double pi = 3.14159265358979323846;
constexpr double skin = 0.15;  // reach of the lists beyond the kernel, in spacings
constexpr double room = 1.6;  // capacity of a row over its mean length

using Words = std::map<std::string, std::string>;
using Indices = std::vector<std::int32_t>;

struct Case {
    explicit Case(const Words& words) : words(words) {}
    double number(const char* key) const { return std::stod(words.at(key)); }

    const Words words;
    const int rows = number("rows"), columns = number("columns");  // particles across and along the channel
    const double gap = number("gap"), length = number("length"), bottom = number("bottom"), top = number("top");
    const double viscosity = number("viscosity"), sound_speed = number("sound_speed");
    const double smoothing_ratio = number("smoothing_ratio"), time_step = number("time_step");
};

template <typename Real>
struct State {  // of a fluid particle at the end of a step, s = density / reference density - 1, and in the next middle
    Real x, y, u, v, s, middle_s;
    std::int32_t identity;
};

template <typename Real>
struct Point {  // what neighbours read, in the middle of a step
    Real x, y, u, v, p;
};

template <typename Real>
class Channel {
public:
    Channel(const Case& given, const std::vector<double>& values) : given(given) {
        for (int i = 0; i < fluid; ++i) {
            const double* own = &values[4 * std::size_t(i)];
            const Real x = own[0], y = own[1], u = own[2], v = own[3];
            ends[i] = {x, y, u, v, 0, 0, i};
            now[i] = {x, y, u, v, 0};
        }
        rebuild();
        step(0);
    }

    void advance() {
        const double tilt = std::abs(given.top - given.bottom) / given.gap * elapsed;
        const double stretch = 0.5 * (tilt + std::sqrt(tilt * tilt + 4));
        if (!(stretch * (cutoff + 2 * std::sqrt(drift_squared)) <= reach)) rebuild();
        step(given.time_step);
    }

    void rebuild() {
        sort();
#pragma omp parallel for schedule(static)
        for (int k = 0; k < fluid; ++k) {
            next[k] = now[order[k]];
            others[k] = ends[order[k]];
        }
        std::swap(now, next);
        std::swap(ends, others);
        lay_out_images();
        list();
        built = now;
        elapsed = 0;
        ++rebuilds;
    }

    void copy_to(std::vector<double>& values) const {
        for (const State<Real>& end : ends) {
            const double own[] = {end.x, end.y, end.u, end.v};
            std::copy_n(own, 4, &values[4 * std::size_t(end.identity)]);
        }
    }

    int rebuilds = 0;

private:
    static constexpr int lanes = 32 / sizeof(Real);  // of a vector of 256 bits
    static int padded(int number) { return (number + lanes - 1) / lanes * lanes; }

    template <bool periodic>
    std::array<Real, 5> sums(int i) const {
        const Point<Real> own = now[i], *points = now.data();
        const Real length = given.length, half = 0.5 * given.length;
        const Real per_cutoff = 1 / cutoff, softening = 0.01 * smoothing * smoothing;
        const std::int32_t* row = &table[std::size_t(i) * capacity];
        const int number = count[i];
        Real pressure_x = 0, pressure_y = 0, viscous_x = 0, viscous_y = 0, divergence = 0;
#pragma omp simd reduction(+ : pressure_x, pressure_y, viscous_x, viscous_y, divergence)
        for (int k = 0; k < number; ++k) {
            const Point<Real>& other = points[row[k]];
            Real dx = other.x - own.x;
            const Real dy = other.y - own.y, du = other.u - own.u, dv = other.v - own.v;
            if (periodic) dx += dx > half ? -length : (dx < -half ? length : Real(0));
            const Real squared = dx * dx + dy * dy;
            const Real rest = std::max(Real(0), 1 - std::sqrt(squared) * per_cutoff);
            const Real weight = rest * rest * rest;
            const Real pressure = weight * (own.p + other.p), viscous = weight * squared / (squared + softening);
            pressure_x += pressure * dx;
            pressure_y += pressure * dy;
            viscous_x += viscous * du;
            viscous_y += viscous * dv;
            divergence += weight * (du * dx + dv * dy);
        }
        return {pressure_x, pressure_y, viscous_x, viscous_y, divergence};
    }

    // Finish the pending step with the rates in its middle, and predict the middle of the next one.
    void step(double pending) {
        const Real length = pending, half = 0.5 * given.time_step;
        const Real norm = 35 / (4 * pi) * spacing * spacing / std::pow(smoothing, 4);  // V (-W'(r)/r) at r = 0
        const Real viscosity = 2 * given.viscosity * norm;
        elapsed += 0.5 * (pending + given.time_step);
        const Real shift = given.bottom * elapsed, shear = (given.top - given.bottom) / given.gap * elapsed;
        Real farthest = 0;
#pragma omp parallel for schedule(static) reduction(max : farthest)
        for (int i = 0; i < fluid; ++i) {
            const auto [pressure_x, pressure_y, viscous_x, viscous_y, divergence] =
                crosses[i] ? sums<true>(i) : sums<false>(i);
            State<Real>& end = ends[i];
            const Real per_density = norm / (1 + end.middle_s);
            const Real du = viscosity * viscous_x - per_density * pressure_x;
            const Real dv = viscosity * viscous_y - per_density * pressure_y;
            const Real ds = -norm * divergence;
            end.x += length * now[i].u;
            end.y += length * now[i].v;
            end.u += length * du;
            end.v += length * dv;
            end.s += length * ds;
            end.middle_s = end.s + half * ds;
            next[i] = {end.x + half * end.u, end.y + half * end.v, end.u + half * du, end.v + half * dv,
                       pressure(end.middle_s)};
            mirror(next, i);
            const Real drift_x = next[i].x - built[i].x - shift - shear * built[i].y, drift_y = next[i].y - built[i].y;
            farthest = std::max(farthest, drift_x * drift_x + drift_y * drift_y);
        }
        drift_squared = farthest;
        std::swap(now, next);
    }

    Real pressure(Real compression) const {  // Tait, gamma = 7, over the density
        Real series = Real(1) / 7;
        for (Real coefficient : {1, 3, 5, 5, 3, 1}) series = series * compression + coefficient;
        return Real(given.sound_speed * given.sound_speed) * series * compression;
    }

    void mirror(std::vector<Point<Real>>& points, int i) const {  // write the images of particle i
        const Real below = 2 * given.bottom, above = 2 * given.gap, top = 2 * given.top;
        const Point<Real> own = points[i];
        if (i < first_inside) points[fluid + i] = {own.x, -own.y, below - own.u, -own.v, own.p};
        if (i >= first_top)
            points[fluid + first_inside + i - first_top] = {own.x, above - own.y, top - own.u, -own.v, own.p};
    }

    int column_of(Real x) const { return std::clamp(int(x / given.length * cell_columns), 0, cell_columns - 1); }
    int row_of(Real y) const { return std::clamp(int(y / given.gap * cell_rows), 0, cell_rows - 1) + 1; }
    std::int32_t& first(int row, int column) { return start[row * (cell_columns + 1) + column]; }

    void sort() {  // counting sort; a cell that stays empty ends each row
        const int cells = (cell_rows + 2) * (cell_columns + 1);
        const Real length = given.length;
        std::fill_n(start.data(), cells, 0);
        for (int i = 0; i < fluid; ++i) {
            const Real shift = std::floor(now[i].x / length) * length;
            now[i].x -= shift;
            ends[i].x -= shift;
            cell[i] = row_of(now[i].y) * (cell_columns + 1) + column_of(now[i].x);
            ++start[cell[i]];
        }
        int total = 0;
        for (int k = 0; k < cells; ++k) total += std::exchange(start[k], total);
        for (int i = 0; i < fluid; ++i) order[start[cell[i]]++] = i;
        std::copy_backward(start.data(), start.data() + cells - 1, start.data() + cells);
        start[0] = 0;
    }

    void lay_out_images() {  // in the order of their sources, the first and the last row of cells
        first_inside = first(1, cell_columns);
        first_top = first(cell_rows, 0);
        const int above = fluid + first_inside - first_top;
        if (above + fluid > slots) throw std::runtime_error("no room for images");
        for (int column = 0; column <= cell_columns; ++column) {
            first(0, column) = fluid + first(1, column);
            first(cell_rows + 1, column) = above + first(cell_rows, column);
        }
        for (int i = 0; i < first_inside; ++i) mirror(now, i);
        for (int i = first_top; i < fluid; ++i) mirror(now, i);
    }

    void list() {
        int longest = 0;
#pragma omp parallel for schedule(static) reduction(max : longest)
        for (int i = 0; i < fluid; ++i) {
            const int column = column_of(now[i].x), row = row_of(now[i].y), last = cell_columns;
            int found = 0, across = 0;
            for (int near = row - 1; near <= row + 1; ++near) {
                const int begin = first(near, std::max(column - 1, 0)), end = first(near, std::min(column + 2, last));
                found = append<false>(i, begin, end, found);
                if (column == 0 || column == last - 1) {
                    const int other = column == 0 ? last - 1 : 0, before = found;
                    found = append<true>(i, first(near, other), first(near, other + 1), found);
                    across += found - before;
                }
            }
            longest = std::max(longest, found);
            crosses[i] = across;
            count[i] = padded(found = std::min(found, capacity));
            std::fill_n(&table[std::size_t(i) * capacity] + found, count[i] - found, slots);
        }
        if (longest >= capacity) throw std::runtime_error("no room for neighbours");
    }

    template <bool periodic>
    int append(int i, int begin, int end, int found) {  // without a branch
        const Real x = now[i].x, y = now[i].y, length = given.length, half = 0.5 * given.length, limit = reach * reach;
        std::int32_t* row = &table[std::size_t(i) * capacity];
        for (int j = begin; j < end; ++j) {
            Real dx = now[j].x - x;
            const Real dy = now[j].y - y;
            if (periodic) dx += dx > half ? -length : (dx < -half ? length : Real(0));
            row[std::min(found, capacity - 1)] = j;
            found += (dx * dx + dy * dy < limit) & (j != i);
        }
        return found;
    }

    const Case given;
    const int fluid = given.rows * given.columns;
    const double spacing = given.gap / given.rows, smoothing = given.smoothing_ratio * spacing;
    const double cutoff = 2 * smoothing, reach = cutoff + skin * spacing;
    const int cell_rows = given.rows / (reach / spacing), cell_columns = given.columns / (reach / spacing);
    const int slots = fluid + 3 * given.columns * (given.rows / cell_rows + 2);  // the last one is far away
    const int capacity = padded(room * pi * reach * reach / (spacing * spacing) + lanes);
    std::vector<State<Real>> ends = std::vector<State<Real>>(fluid), others = ends;
    std::vector<Point<Real>> now = std::vector<Point<Real>>(slots + 1, {1e3, 1e3, 0, 0, 0}), next = now, built = now;
    Indices table = Indices(std::size_t(fluid) * capacity), start = Indices((cell_rows + 2) * (cell_columns + 1));
    Indices count = Indices(fluid), crosses = count, cell = count, order = count;
    int first_inside = 0, first_top = 0;  // particles before and from these on have images in a wall
    double elapsed = 0, drift_squared = 0;  // since the lists were built
};

double seconds_since(std::chrono::steady_clock::time_point began) {
    return std::chrono::duration<double>(std::chrono::steady_clock::now() - began).count();
}

template <typename Real>
void run(const Case& given) {
    std::vector<double> state(4 * std::size_t(given.rows) * given.columns);
    const std::streamsize bytes = state.size() * sizeof(double);
    std::ifstream file(given.words.at("state"), std::ios::binary);
    if (!file.read(reinterpret_cast<char*>(state.data()), bytes)) throw std::runtime_error("state: cannot be read");
    Channel<Real> channel(given, state);
    for (int k = given.number("warm_up"); k > 0; --k) channel.advance();

    const int steps = given.number("steps"), before = channel.rebuilds;
    auto began = std::chrono::steady_clock::now();
    for (int k = 0; k < steps; ++k) channel.advance();
    const double loop = seconds_since(began);
    const int rebuilds = channel.rebuilds - before;
    if (given.words.count("out")) {
        channel.copy_to(state);
        std::ofstream(given.words.at("out"), std::ios::binary).write(reinterpret_cast<char*>(state.data()), bytes);
    }
    began = std::chrono::steady_clock::now();
    channel.rebuild();
    std::printf("{\"steps\": %d, \"loop_seconds\": %.9g, \"rebuilds\": %d, \"rebuild_seconds\": %.9g}\n", steps, loop,
                rebuilds, seconds_since(began));
}

int main(int count, char** arguments) {
    Words words;
    try {
        for (const std::string& word : std::vector<std::string>(arguments + 1, arguments + count))
            words[word.substr(0, word.find('='))] = word.substr(word.find('=') + 1);
        const Case given(words);
        omp_set_num_threads(given.number("threads"));
        words.at("precision") == "f64" ? run<double>(given) : run<float>(given);
    } catch (const std::exception& error) {
        std::fprintf(stderr, "reference: %s\n", error.what());
        return 1;
    }
}
