#include <volccd/experiments/scenes/geometry/hexahedral_solids.hpp>

#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <numbers>
#include <utility>

#include <volccd/core/error.hpp>

namespace volccd {

namespace {

constexpr double kCoreShare = 0.5;  // half the width of the core, as a fraction of the radius

struct Section {
  std::vector<std::array<double, 2>> points;  // in the unit disc
  std::vector<std::array<Index, 4>> cells;    // counter-clockwise
};

/// The core and the rings meet in the outline of the core: a square whose sides bulge halfway to the circle through
/// their midpoints.
class SectionBuilder {
 public:
  explicit SectionBuilder(const BulletShape& bullet) : core_(bullet.core), rings_(bullet.rings) {
    for (int j = 0; j < core_; ++j)
      for (int i = 0; i < core_; ++i)
        section_.cells.push_back(
            {core_point(i, j), core_point(i + 1, j), core_point(i + 1, j + 1), core_point(i, j + 1)});
    for (int ring = 0; ring < rings_; ++ring)
      for (int k = 0; k < 4 * core_; ++k)
        section_.cells.push_back(
            {ring_point(ring, k), ring_point(ring + 1, k), ring_point(ring + 1, k + 1), ring_point(ring, k + 1)});
  }

  Section build() { return std::move(section_); }

 private:
  Index add(std::pair<int, int> key, double x, double y) {
    const auto [found, is_new] = index_.try_emplace(key, static_cast<Index>(section_.points.size()));
    if (is_new) section_.points.push_back({x, y});
    return found->second;
  }
  Index core_point(int i, int j) {
    const double u = 2.0 * i / core_ - 1, v = 2.0 * j / core_ - 1;
    const double bulge = 0.12;  // outlines between a square and a circle: angles at its corners stay below 180 degrees
    return add({i, j}, kCoreShare * u * (1 - bulge * v * v), kCoreShare * v * (1 - bulge * u * u));
  }
  /// Point k of the core's outline, counter-clockwise from its lower right corner.
  std::pair<int, int> outline(int k) const {
    const int side = k / core_ % 4, step = k % core_;
    switch (side) {
      case 0: return {core_, step};
      case 1: return {core_ - step, core_};
      case 2: return {0, core_ - step};
      default: return {step, 0};
    }
  }
  Index ring_point(int ring, int k) {
    const auto [i, j] = outline(k);
    const std::array<double, 2> inner = section_.points[core_point(i, j)];
    if (ring == 0) return core_point(i, j);
    const double angle = std::numbers::pi * (2.0 * (k % (4 * core_)) / (4 * core_) - 0.25);
    const double t = static_cast<double>(ring) / rings_;
    return add({-ring, k % (4 * core_)}, (1 - t) * inner[0] + t * std::cos(angle),
               (1 - t) * inner[1] + t * std::sin(angle));
  }

  int core_, rings_;
  Section section_;
  std::map<std::pair<int, int>, Index> index_;
};

void add_hexahedron(Shape& shape, const std::array<Index, 4>& low, const std::array<Index, 4>& high) {
  ElementSpec element{.type = ElementType::hexahedron,
                      .vertices = {low.begin(), low.end()},
                      .id = static_cast<std::int64_t>(shape.elements.size())};
  element.vertices.insert(element.vertices.end(), high.begin(), high.end());
  shape.elements.push_back(std::move(element));
}

/// The lines of a plate along x or y: `cells` cells, symmetric.
std::vector<double> graded_lines(double side, double fine, int cells) {
  const int outer = std::max(1, cells / 6);  // cells on either side of the fine part
  const double width = fine / (cells - 2 * outer), reach = (side - fine) / 2;
  double low = 1, high = 100;  // bounds of the ratio of neighbouring cell sizes
  for (int i = 0; i < 100; ++i) {
    const double ratio = (low + high) / 2;
    double sum = 0, cell = width;
    for (int k = 0; k < outer; ++k) sum += (cell *= ratio);
    (sum < reach ? low : high) = ratio;
  }
  std::vector<double> lines(static_cast<std::size_t>(cells) + 1);
  for (int i = 0; i <= cells; ++i) {
    const int beyond = std::max(outer - i, i - (cells - outer));
    double at = std::clamp(i - outer, 0, cells - 2 * outer) * width - fine / 2, cell = width;
    for (int k = 0; k < beyond; ++k) at += (i < outer ? -1 : 1) * (cell *= low);
    lines[static_cast<std::size_t>(i)] = i == 0 ? -side / 2 : i == cells ? side / 2 : at;
  }
  return lines;
}

}  // namespace

Shape round_nosed_bullet(const BulletShape& bullet) {
  if (!(bullet.diameter > 0) || !(bullet.nose > 0) || !(bullet.length > bullet.nose) || bullet.core < 1 ||
      bullet.rings < 1 || bullet.layers < 2)
    throw ConfigError("bullet: a size or number is out of range");
  const Section section = SectionBuilder(bullet).build();
  const auto points = static_cast<Index>(section.points.size());
  Shape shape;
  for (int layer = 0; layer <= bullet.layers; ++layer) {
    const double s = bullet.length * layer / bullet.layers;  // from the tip
    const double t = std::max(0.0, 1 - s / bullet.nose);     // 1 at the tip, 0 where the nose ends
    const double radius =
        // the tip is blunt, because the outermost ring needs a positive radius
        bullet.diameter / 2 * std::sqrt(1 - 0.72 * t * t);
    for (const auto& [x, y] : section.points) {
      const double dome = 0.06 * bullet.diameter * t * (x * x + y * y);
      shape.positions.emplace_back(radius * x, radius * y, s + dome);
    }
  }
  for (Index layer = 0; layer < static_cast<Index>(bullet.layers); ++layer)
    for (std::array<Index, 4> low : section.cells) {
      std::array<Index, 4> high{};
      for (std::size_t k = 0; k < 4; ++k) {
        low[k] += layer * points;
        high[k] = low[k] + points;
      }
      add_hexahedron(shape, low, high);
    }
  return shape;
}

Shape graded_plate(const PlateShape& plate) {
  if (!(plate.fine > 0) || !(plate.side > plate.fine) || !(plate.thickness > 0) || plate.cells[0] < 4 ||
      plate.cells[1] < 4 || plate.cells[2] < 1)
    throw ConfigError("plate: a size or number is out of range");
  const std::vector<double> xs = graded_lines(plate.side, plate.fine, plate.cells[0]);
  const std::vector<double> ys = graded_lines(plate.side, plate.fine, plate.cells[1]);
  Shape shape;
  for (int k = 0; k <= plate.cells[2]; ++k)
    for (const double y : ys)
      for (const double x : xs)
        shape.positions.emplace_back(x, y, plate.thickness * (k - plate.cells[2]) / plate.cells[2]);
  const auto row = static_cast<Index>(xs.size()), sheet = static_cast<Index>(xs.size() * ys.size());
  for (Index k = 0; k < static_cast<Index>(plate.cells[2]); ++k)
    for (Index j = 0; j + 1 < ys.size(); ++j)
      for (Index i = 0; i + 1 < xs.size(); ++i) {
        const Index a = k * sheet + j * row + i;
        const std::array<Index, 4> low{a, a + 1, a + row + 1, a + row};
        add_hexahedron(shape, low, {low[0] + sheet, low[1] + sheet, low[2] + sheet, low[3] + sheet});
      }
  return shape;
}

}  // namespace volccd
