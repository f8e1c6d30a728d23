#include <volccd/mesh/shells.hpp>

#include <algorithm>
#include <atomic>
#include <cassert>
#include <cmath>
#include <limits>
#include <numeric>

#include <fmt/format.h>
#include <Eigen/Geometry>

#include <volccd/core/error.hpp>

namespace volccd {

namespace {

/// If a mean normal is shorter than this fraction of the area of the shells, it consists of rounding errors.
constexpr double kCancelled = 1e-9;
/// Number of shells or vertices in a chunk of parallel work.
constexpr std::size_t kGrain = 4096;

/// Sets of shells that are connected by edges, each with its orientation relative to the first shell of its set.
class Sheets {
 public:
  explicit Sheets(std::size_t n) : parent_(n), flip_(n) { std::iota(parent_.begin(), parent_.end(), Index{0}); }

  struct Place {
    Index first;
    bool flip;
  };
  Place find(Index i) {
    bool flip = false;
    for (; parent_[i] != i; i = parent_[i]) {
      flip_[i] = flip_[i] != flip_[parent_[i]];  // the first shell of a set is not flipped
      parent_[i] = parent_[parent_[i]];
      flip ^= flip_[i];
    }
    return {i, flip};
  }

  /// Joins the sheets of i and j, which have the same or the opposite orientation. Does nothing if they are already
  /// joined.
  void join(Index i, Index j, bool opposite) {
    const Place a = find(i), b = find(j);
    if (a.first == b.first) return;
    parent_[std::max(a.first, b.first)] = std::min(a.first, b.first);
    flip_[std::max(a.first, b.first)] = a.flip ^ b.flip ^ opposite;
  }

 private:
  std::vector<Index> parent_;
  std::vector<bool> flip_;
};

/// Normal multiplied by the area.
Vec3 area_vector(std::span<const Vec3> x, const std::array<Index, 4>& v) {
  return (x[v[2]] - x[v[0]]).cross(x[v[3]] - x[v[1]]) / 2;
}

}  // namespace

std::vector<std::int64_t> solid_vertex_ids(std::span<const std::int64_t> ids) {
  constexpr std::int64_t kMax = std::numeric_limits<std::int64_t>::max() / 3 - 1;
  std::vector<std::int64_t> result;
  result.reserve(3 * ids.size());
  for (std::size_t i = 0; i < ids.size(); ++i) {
    if (ids[i] > kMax || ids[i] < -kMax)
      throw InputError("shells", "vertex ids", static_cast<std::int64_t>(i),
                       fmt::format("id {} is too large to be tripled", ids[i]));
    for (std::int64_t k = 0; k < 3; ++k) result.push_back(3 * ids[i] + k);
  }
  return result;
}

void solid_middle_points(std::span<const Vec3> x0, std::span<const Vec3> xm, std::span<const Vec3> x1,
                         std::span<const Vec3> solid0, std::span<const Vec3> solid1, std::vector<Vec3>& out) {
  out.resize(solid0.size());
  for (Index v = 0; v < x0.size(); ++v) {
    const Vec3 bend = xm[v] - (0.5 * x0[v] + 0.5 * x1[v]);
    out[solid_middle(v)] = xm[v];
    for (const Index s : {solid_below(v), solid_above(v)}) out[s] = (0.5 * solid0[s] + 0.5 * solid1[s]) + bend;
  }
}

ShellThickener::ShellThickener(const Mesh& mesh) : vertices_(mesh.vertex_count()), slots_(mesh.element_slots()) {
  if (vertices_ >= kNone / 3) throw InputError("shells", "vertex ids", "more than 2^32 - 2 vertices, once tripled");
  for (Index o = 0; o < slots_; ++o) {
    if (!is_shell(mesh.type(o))) continue;
    const std::span<const Index> v = mesh.vertices(o);
    shells_.push_back({o, {v[0], v[1], v[2], v.back()}, false});
  }
  std::sort(shells_.begin(), shells_.end(),
            [&](const Shell& a, const Shell& b) { return mesh.element_id(a.slot) < mesh.element_id(b.slot); });
  orient();
  for (Index s = 0; s < shells_.size(); ++s) {
    for (Index v : mesh.vertices(shells_[s].slot)) corners_.push_back({v, s});
    if (shells_[s].flipped) flipped_.push_back(shells_[s].slot);
  }
  std::stable_sort(corners_.begin(), corners_.end(),
                   [](const Corner& a, const Corner& b) { return a.vertex < b.vertex; });
  for (std::size_t i = 0; i < corners_.size(); ++i)
    if (i == 0 || corners_[i].vertex != corners_[i - 1].vertex) runs_.push_back(static_cast<Index>(i));
  runs_.push_back(static_cast<Index>(corners_.size()));
  std::sort(flipped_.begin(), flipped_.end());
}

void ShellThickener::orient() {
  struct Side {
    std::array<Index, 2> edge;
    Index shell;
    bool upward;  // whether the side leads from the smaller slot to the larger
  };
  std::vector<Side> sides;
  for (Index s = 0; s < shells_.size(); ++s) {
    const auto& v = shells_[s].vertices;
    const std::size_t n = v[2] == v[3] ? 3 : 4;
    for (std::size_t i = 0; i < n; ++i) {
      const Index a = v[i], b = v[(i + 1) % n];
      sides.push_back({{std::min(a, b), std::max(a, b)}, s, a < b});
    }
  }
  std::stable_sort(sides.begin(), sides.end(), [](const Side& a, const Side& b) { return a.edge < b.edge; });
  Sheets sheets(shells_.size());
  for (std::size_t i = 0, first = 0; i < sides.size(); ++i) {
    if (sides[i].edge != sides[first].edge) first = i;
    // Neighbours with the same orientation traverse their common edge in opposite directions.
    if (i != first) sheets.join(sides[first].shell, sides[i].shell, sides[first].upward == sides[i].upward);
  }
  // The first shell is that of smallest id.
  for (Index s = 0; s < shells_.size(); ++s) shells_[s].flipped = sheets.find(s).flip;
}

ElementSpec ShellThickener::solid_element(const Mesh& mesh, Index o) const {
  assert(mesh.element_slots() == slots_ && mesh.is_live(o));
  ElementSpec solid = mesh.spec(o);
  if (!is_shell(solid.type)) {
    solid.renumber(solid_middle);
    return solid;
  }
  // In VTK's node order, a wedge begins with the triangle whose normal points outward, a hexahedron with the quad whose
  // normal points inward.
  const bool triangle = solid.type == ElementType::triangle;
  const bool above_first = triangle != std::binary_search(flipped_.begin(), flipped_.end(), o);
  solid.type = triangle ? ElementType::wedge : ElementType::hexahedron;
  solid.vertices.clear();
  for (const auto side : {above_first ? solid_above : solid_below, above_first ? solid_below : solid_above})
    for (const Index v : mesh.vertices(o)) solid.vertices.push_back(side(v));
  return solid;
}

Mesh ShellThickener::solid_mesh(const Mesh& mesh) const {
  Mesh solid;
  solid.add_vertices(solid_vertex_ids(mesh.vertex_ids()));
  for (Index o = 0; o < slots_; ++o)
    if (mesh.is_live(o)) solid.add_element(solid_element(mesh, o));
  return solid;
}

/// The last entry of `runs` is the end of the last run. Returns the number of vertices without a mean normal.
Index ShellThickener::split_vertices(std::span<const Vec3> x, std::span<const double> thickness,
                                     std::span<const Sheet> sheets, std::span<const Index> runs,
                                     std::span<Vec3> out) const {
  Index without_normal = 0;
  for (std::size_t run = 0; run + 1 < runs.size(); ++run) {
    Vec3 sum = Vec3::Zero(), fallback = Vec3::Zero();
    double area = 0, weighted = 0, plain = 0;
    for (Index i = runs[run]; i < runs[run + 1]; ++i) {
      const double h = thickness[shells_[corners_[i].shell].slot];
      const auto& [normal, size] = sheets[corners_[i].shell];
      sum += normal;
      area += size;
      weighted += size * h;
      plain += h;
      if (fallback.isZero(0) && size > 0 && std::isfinite(size)) fallback = normal / size;
    }
    double length = sum.norm();
    // Negated, so that NaN from overflowing areas counts as no normal.
    if (!(length > kCancelled * area) || !std::isfinite(length)) {
      ++without_normal;
      sum = fallback.isZero(0) ? Vec3::UnitZ() : fallback;
      length = 1;
    }
    const bool has_area = area > 0 && std::isfinite(weighted);
    const double h = has_area ? weighted / area : plain / static_cast<double>(runs[run + 1] - runs[run]);
    const Vec3 offset = sum / length * (h / 2);
    const std::size_t v = corners_[runs[run]].vertex;
    out[3 * v + 1] = x[v] - offset;
    out[3 * v + 2] = x[v] + offset;
  }
  return without_normal;
}

void ShellThickener::check_thickness(std::span<const double> thickness) const {
  if (thickness.size() != slots_)
    throw InputError("shells", "thickness", fmt::format("{} for {} elements", thickness.size(), slots_));
  for (const Shell& shell : shells_)
    if (!std::isfinite(thickness[shell.slot]) || thickness[shell.slot] < 0)
      throw InputError("shells", "thickness", shell.slot, "not a finite number >= 0");
}

Index ShellThickener::positions(std::span<const Vec3> x, std::span<const double> thickness, std::vector<Vec3>& out,
                                Scratch& scratch, Executor& executor) const {
  if (x.size() != vertices_)
    throw InputError("shells", "positions", fmt::format("{} for {} vertices", x.size(), vertices_));
  check_thickness(thickness);
  scratch.sheets_.resize(shells_.size());
  const std::span<Sheet> sheets = scratch.sheets_;
  executor.parallel_for(shells_.size(), kGrain, [&](std::size_t begin, std::size_t end, unsigned) {
    for (std::size_t s = begin; s < end; ++s) {
      const Vec3 normal = (shells_[s].flipped ? -1 : 1) * area_vector(x, shells_[s].vertices);
      sheets[s] = {normal, normal.norm()};
    }
  });
  out.resize(3 * x.size());
  executor.parallel_for(x.size(), kGrain, [&](std::size_t begin, std::size_t end, unsigned) {
    for (std::size_t v = begin; v < end; ++v) out[3 * v] = out[3 * v + 1] = out[3 * v + 2] = x[v];
  });
  std::atomic<Index> without_normal = 0;
  executor.parallel_for(runs_.size() - 1, kGrain, [&](std::size_t begin, std::size_t end, unsigned) {
    without_normal += split_vertices(x, thickness, sheets, std::span(runs_).subspan(begin, end - begin + 1), out);
  });
  return without_normal;
}

Index ShellThickener::positions(std::span<const Vec3> x, std::span<const double> thickness,
                                std::vector<Vec3>& out) const {
  Scratch scratch;
  return positions(x, thickness, out, scratch, serial_executor());
}

}  // namespace volccd
