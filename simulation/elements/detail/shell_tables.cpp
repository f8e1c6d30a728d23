#include <volccd/simulation/elements/detail/shell_tables.hpp>

#include <algorithm>
#include <cmath>
#include <tuple>

#include <Eigen/Geometry>

#include <volccd/core/error.hpp>
#include <volccd/simulation/detail/portable_math.hpp>

namespace volccd::simulation::detail {
namespace {

std::uint64_t spread_bits(std::uint64_t x) {
  x &= 0x1fffff;
  x = (x | x << 32) & 0x1f00000000ffff;
  x = (x | x << 16) & 0x1f0000ff0000ff;
  x = (x | x << 8) & 0x100f00f00f00f00f;
  x = (x | x << 4) & 0x10c30c30c30c30c3;
  return (x | x << 2) & 0x1249249249249249;
}

/// Sorts the elements: deformable ones first, then by body, then along a space-filling curve. Removes those without
/// area.
void sort_elements(std::vector<ShellElement>& elements, const std::vector<ShellLaw>& laws) {
  std::erase_if(elements, [](const ShellElement& e) { return RestFrame(e.corners).area == 0; });
  Vec3 low = Vec3::Constant(kNever), high = -low;
  for (const ShellElement& e : elements) {
    const Vec3 sum = e.corners[0] + e.corners[1] + e.corners[2];
    low = low.cwiseMin(sum);
    high = high.cwiseMax(sum);
  }
  const double scale = 0x1fffff / std::max((high - low).maxCoeff(), 1e-300);
  using Key = std::tuple<bool, std::int32_t, std::uint64_t, Index, Index>;
  std::vector<Key> keys;
  keys.reserve(elements.size());
  for (Index i = 0; i < elements.size(); ++i) {
    const ShellElement& e = elements[i];
    const Vec3 at = (e.corners[0] + e.corners[1] + e.corners[2] - low) * scale;
    std::uint64_t code = 0;
    for (int k = 0; k < 3; ++k) code |= spread_bits(static_cast<std::uint64_t>(at[k])) << k;
    keys.emplace_back(laws[static_cast<std::size_t>(e.object)].rigid, e.object, code, e.slot, i);
  }
  std::sort(keys.begin(), keys.end());
  std::vector<ShellElement> sorted;
  sorted.reserve(elements.size());
  for (const Key& key : keys) sorted.push_back(elements[std::get<4>(key)]);
  elements = std::move(sorted);
}

/// A hinge before its index is known. `first` is the triangle with the smaller slot; the edge has the direction that it
/// has in `first`.
struct HingeDraft {
  std::size_t block;
  Index first, second;                       ///< elements
  std::uint8_t corner_first, corner_second;  ///< the ones opposite to the edge
  bool opposed;
  double share;      ///< of the stiffness that the two would have by themselves
  double stiffness;  ///< so much already shared
};

struct EdgeUse {
  Index low, high, element;
  std::uint8_t corner;
  auto key() const { return std::tuple(low, high, element); }
};

std::vector<EdgeUse> edges_of(const std::vector<ShellElement>& elements) {
  std::vector<EdgeUse> uses;
  uses.reserve(elements.size() * 3);
  for (Index i = 0; i < elements.size(); ++i) {
    for (std::uint8_t k = 0; k < 3; ++k) {
      const Index a = elements[i].vertices[(k + 1) % 3], b = elements[i].vertices[(k + 2) % 3];
      uses.push_back({std::min(a, b), std::max(a, b), i, k});
    }
  }
  std::sort(uses.begin(), uses.end(), [](const EdgeUse& a, const EdgeUse& b) { return a.key() < b.key(); });
  return uses;
}

/// Rotational stiffness of one side of an edge; a hinge is the series connection of two sides.
double side_stiffness(const ShellElement& e, std::uint8_t corner, const std::vector<ShellLaw>& laws) {
  const ShellLaw& law = laws[static_cast<std::size_t>(e.object)];
  const double length2 = (e.corners[(corner + 1) % 3] - e.corners[(corner + 2) % 3]).squaredNorm();
  return law.bending * length2 / RestFrame(e.corners).area;
}

/// Hinges of one edge. A star of n sides becomes the mesh of pairs with the same behaviour (star-mesh transform), so
/// that an edge of many triangles is a rigid joint, and an edge of two has the stiffness of their series connection.
void draft_edge(std::span<const EdgeUse> uses, const std::vector<ShellElement>& elements,
                const std::vector<ShellLaw>& laws, std::size_t deformable, std::vector<HingeDraft>& drafts,
                std::vector<double>& side) {
  side.clear();
  double sum = 0, greatest = 0;
  for (const EdgeUse& use : uses) {
    side.push_back(use.element < deformable ? side_stiffness(elements[use.element], use.corner, laws) : 0);
    greatest = std::max(greatest, side.back());
  }
  for (std::size_t i = 0; i < uses.size(); ++i) {
    if (uses[i].element >= deformable) side[i] = 1e6 * greatest;
    sum += side[i];
  }
  for (std::size_t i = 0; i < uses.size(); ++i) {
    for (std::size_t j = i + 1; j < uses.size(); ++j) {
      EdgeUse a = uses[i], b = uses[j];
      if (a.element >= deformable && b.element >= deformable) continue;
      if (elements[b.element].slot < elements[a.element].slot) std::swap(a, b);
      const ShellElement &ea = elements[a.element], &eb = elements[b.element];
      if (ea.vertices[a.corner] == eb.vertices[b.corner]) continue;  // the same triangle twice
      const bool opposed = ea.vertices[(a.corner + 1) % 3] == eb.vertices[(b.corner + 2) % 3];
      const double stiffness = side[i] * side[j] / sum;
      const Index owner = a.element < deformable ? a.element : b.element;
      drafts.push_back(
          {owner, a.element, b.element, a.corner, b.corner, opposed, (side[i] + side[j]) / sum, stiffness});
    }
  }
}

std::vector<HingeDraft> draft_hinges(const std::vector<ShellElement>& elements, const std::vector<ShellLaw>& laws,
                                     std::size_t deformable, const std::vector<std::size_t>& block_of) {
  const std::vector<EdgeUse> uses = edges_of(elements);
  std::vector<HingeDraft> drafts;
  std::vector<double> side;
  for (std::size_t i = 0, end = 0; i < uses.size(); i = end) {
    end = i + 1;
    while (end < uses.size() && uses[end].low == uses[i].low && uses[end].high == uses[i].high) ++end;
    if (end - i > 1) draft_edge({uses.data() + i, end - i}, elements, laws, deformable, drafts, side);
  }
  for (HingeDraft& h : drafts) h.block = block_of[h.block];
  std::sort(drafts.begin(), drafts.end(), [](const HingeDraft& a, const HingeDraft& b) {
    return std::tie(a.block, a.first, a.second, a.corner_first) < std::tie(b.block, b.first, b.second, b.corner_first);
  });
  return drafts;
}

class Builder {
 public:
  explicit Builder(ShellTables& tables) : t_(tables), place_(tables.mesh_vertices, kNone) {}

  void run() {
    std::vector<std::size_t> block_of(t_.elements.size(), 0);
    cut_blocks(block_of);
    const std::vector<HingeDraft> drafts = draft_hinges(t_.elements, t_.laws, t_.deformable, block_of);
    std::vector<std::uint32_t> hinges_at(t_.elements.size(), 0);
    for (const HingeDraft& h : drafts) {
      ++hinges_at[h.first];
      ++hinges_at[h.second];
    }
    t_.hinge_count = drafts.size();
    std::size_t next = 0;
    for (std::size_t b = 0; b < t_.blocks.size(); ++b) {
      ShellBlock& block = t_.blocks[b];
      add_triangles(block);
      block.hinges_begin = t_.hinges.rest.size();
      for (; next < drafts.size() && drafts[next].block == b; ++next) add_hinge(drafts[next], hinges_at);
      if (t_.hinges.rest.size() > block.hinges_begin) {
        while (t_.hinges.rest.size() % kShellPadding != 0) pad_hinge();
      }
      block.hinges_end = t_.hinges.rest.size();
      close_copy(block);
    }
    list_places();
  }

 private:
  /// Ranges of elements, which add_triangles() replaces by padded ranges.
  void cut_blocks(std::vector<std::size_t>& block_of) {
    for (std::size_t i = 0, end = 0; i < t_.deformable; i = end) {
      for (end = i; end < t_.deformable && end - i < kShellBlock && t_.elements[end].object == t_.elements[i].object;
           ++end)
        block_of[end] = t_.blocks.size();
      t_.blocks.push_back({i, end, 0, 0, 0, 0, t_.elements[i].object});
    }
  }

  std::int32_t place(Index vertex) {
    if (place_[vertex] == kNone) {
      place_[vertex] = static_cast<Index>(t_.block_vertices.size() - copy_begin_);
      t_.block_vertices.push_back(vertex);
    }
    return static_cast<std::int32_t>(place_[vertex] * kCopyStride);
  }

  void close_copy(ShellBlock& block) {
    block.vertices_begin = copy_begin_;
    block.vertices_end = copy_begin_ = t_.block_vertices.size();
    for (std::size_t i = block.vertices_begin; i < block.vertices_end; ++i) place_[t_.block_vertices[i]] = kNone;
    t_.greatest_copy = std::max(t_.greatest_copy, block.vertices_end - block.vertices_begin);
  }

  void add_triangles(ShellBlock& block) {
    ShellTriangles& out = t_.triangles;
    const std::size_t begin = block.triangles_begin, end = block.triangles_end;
    const std::size_t padded = (end - begin + kShellPadding - 1) / kShellPadding * kShellPadding;
    block.triangles_begin = out.volume.size();
    for (std::size_t i = 0; i < padded; ++i) {
      const bool real = begin + i < end;
      const std::size_t index = real ? begin + i : end - 1;
      const ShellElement& e = t_.elements[index];
      const ShellLaw& law = t_.laws[static_cast<std::size_t>(e.object)];
      const RestFrame frame(e.corners);
      const std::array<double, 4> shape = inverse2(frame.edges);
      for (std::size_t k = 0; k < 3; ++k) out.vertices[k].push_back(place(e.vertices[k]));
      for (std::size_t k = 0; k < 4; ++k) out.shape[k].push_back(shape[k]);
      out.strain.push_back(0);
      out.volume.push_back(real ? frame.area * law.thickness : 0);
      out.edges.push_back(frame.edges);
      out.element.push_back(real ? static_cast<Index>(index) : kNone);
    }
    block.triangles_end = out.volume.size();
  }

  double vertex_mass(Index element, std::uint32_t hinges) const {
    const ShellElement& e = t_.elements[element];
    const ShellLaw& law = t_.laws[static_cast<std::size_t>(e.object)];
    return law.density * law.thickness * RestFrame(e.corners).area / (3.0 * hinges);
  }

  void add_hinge(const HingeDraft& draft, const std::vector<std::uint32_t>& hinges_at) {
    ShellHinges& out = t_.hinges;
    const ShellElement &a = t_.elements[draft.first], &b = t_.elements[draft.second];
    const std::size_t p = (draft.corner_first + 1u) % 3, q = (draft.corner_first + 2u) % 3;
    const Vec3 &x0 = a.corners[p], &x1 = a.corners[q], &x2 = a.corners[draft.corner_first];
    const Vec3& x3 = b.corners[draft.corner_second];
    const Index vertices[4] = {a.vertices[p], a.vertices[q], a.vertices[draft.corner_first],
                               b.vertices[draft.corner_second]};
    for (std::size_t k = 0; k < 4; ++k) out.vertices[k].push_back(place(vertices[k]));
    const double area_a = RestFrame(a.corners).area, area_b = RestFrame(b.corners).area, length = (x1 - x0).norm();
    const double angle = hinge_angle(x0, x1, x2, x3), k = draft.stiffness;
    out.stiffness.push_back(k);
    out.rest.push_back(angle);
    out.last.push_back(angle);
    out.reference.push_back(angle);
    constexpr double min = kMinStretch * kMinStretch;
    out.min[0].push_back(4 * min * area_a * area_a);
    out.min[1].push_back(4 * min * area_b * area_b);
    const double mass_a = vertex_mass(draft.first, hinges_at[draft.first]);
    const double mass_b = vertex_mass(draft.second, hinges_at[draft.second]);
    out.mobility[0].push_back(k / (mass_a + mass_b));
    out.mobility[1].push_back(k / mass_a);
    out.mobility[2].push_back(k / mass_b);
    // The angle changes by at most 1 / h_a + 1 / h_b for a unit displacement of a vertex of the edge.
    const double slope_a = length / (2 * area_a), slope_b = length / (2 * area_b);
    const double frequency2 = 2 * out.mobility[0].back() * (slope_a + slope_b) * (slope_a + slope_b) +
                              out.mobility[1].back() * slope_a * slope_a + out.mobility[2].back() * slope_b * slope_b;
    out.viscosity.push_back(2 * kShellDamping / std::sqrt(frequency2));
    add_yield(draft, length, area_a + area_b);
    out.elements.push_back({draft.first, draft.second});
    out.opposed.push_back(draft.opposed);
  }

  void add_yield(const HingeDraft& draft, double length, double areas) {
    ShellHinges& out = t_.hinges;
    std::int32_t weaker = -1;
    const auto moment = [&](std::int32_t object) {
      const ShellLaw& law = t_.laws[static_cast<std::size_t>(object)];
      return law.yield_stress * law.thickness * law.thickness / 4;
    };
    for (const Index i : {draft.first, draft.second}) {
      const std::int32_t object = t_.elements[i].object;
      if (i < t_.deformable && (weaker < 0 || moment(object) < moment(weaker))) weaker = object;
    }
    const ShellLaw& law = t_.laws[static_cast<std::size_t>(weaker)];
    const double strain = law.thickness / 4 * length / areas, h = law.thickness;
    out.virgin.push_back(moment(weaker) * length * draft.share);
    out.capacity.push_back(out.virgin.back());
    out.slope.push_back(law.hardening_modulus * strain * h * h / 4 * length * draft.share);
    out.strain.push_back(strain);
    out.object.push_back(weaker);
  }

  /// Appends a copy of the last hinge, without stiffness.
  void pad_hinge() {
    ShellHinges& out = t_.hinges;
    const auto repeat = [](auto& values) {
      const auto last = values.back();
      values.push_back(last);
    };
    for (auto& v : out.vertices) repeat(v);
    for (auto* v : {&out.rest, &out.last, &out.capacity, &out.min[0], &out.min[1], &out.viscosity, &out.reference,
                    &out.virgin, &out.slope, &out.strain})
      repeat(*v);
    out.stiffness.push_back(0);
    for (auto& v : out.mobility) v.push_back(0);
    out.elements.push_back({kNone, kNone});
    repeat(out.object);
    repeat(out.opposed);
  }

  void list_places() {
    std::vector<Index> count(t_.mesh_vertices, 0);
    for (const Index v : t_.block_vertices) ++count[v];
    t_.offsets.push_back(0);
    std::vector<Index> cursor(t_.mesh_vertices, 0);
    for (Index v = 0; v < t_.mesh_vertices; ++v) {
      if (count[v] == 0) continue;
      cursor[v] = t_.offsets.back();
      t_.used.push_back(v);
      t_.offsets.push_back(t_.offsets.back() + count[v]);
    }
    t_.places.resize(t_.block_vertices.size());
    for (Index i = 0; i < t_.block_vertices.size(); ++i) t_.places[cursor[t_.block_vertices[i]]++] = i;
  }

  ShellTables& t_;
  std::vector<Index> place_;  ///< of a mesh vertex in the block at hand
  std::size_t copy_begin_ = 0;
};

void same_size(std::size_t a, std::size_t b) {
  if (a != b) throw InputError("checkpoint", "shells", "does not belong to this mesh");
}

/// Writes or reads the state in the existing tables.
template <typename T>
void state(Archive& archive, std::vector<T>& values) {
  const std::size_t size = values.size();
  archive(values);
  same_size(size, values.size());
}

}  // namespace

RestFrame::RestFrame(const std::array<Vec3, 3>& corners) {
  const Vec3 a = corners[1] - corners[0], b = corners[2] - corners[0], normal = a.cross(b);
  const double length = a.norm(), twice = normal.norm();
  // Below this, the inverse of the edges consists of rounding errors only.
  area = twice > 1e-12 * (a.squaredNorm() + b.squaredNorm()) ? twice / 2 : 0;
  if (area == 0) {
    axes[0] = axes[1] = Vec3::Zero();
    edges = {};
    return;
  }
  axes[0] = a / length;
  axes[1] = normal.cross(a) / (twice * length);
  edges = {length, axes[0].dot(b), 0, axes[1].dot(b)};
}

std::array<double, 4> inverse2(const std::array<double, 4>& m) {
  const double d = m[0] * m[3] - m[1] * m[2];
  return {m[3] / d, -m[1] / d, -m[2] / d, m[0] / d};
}

std::array<double, 4> product2(const std::array<double, 4>& a, const std::array<double, 4>& b) {
  return {a[0] * b[0] + a[1] * b[2], a[0] * b[1] + a[1] * b[3], a[2] * b[0] + a[3] * b[2], a[2] * b[1] + a[3] * b[3]};
}

double hinge_angle(const Vec3& x0, const Vec3& x1, const Vec3& x2, const Vec3& x3) {
  const Vec3 edge = x1 - x0, a = (x2 - x0).cross(x2 - x1), b = (x3 - x1).cross(x3 - x0);
  return portable_atan2(a.cross(b).dot(edge), a.dot(b) * edge.norm());
}

void ShellTables::build(std::vector<ShellElement> all, Index vertex_count) {
  elements = std::move(all);
  mesh_vertices = vertex_count;
  sort_elements(elements, laws);
  deformable = static_cast<std::size_t>(
      std::find_if(elements.begin(), elements.end(),
                   [&](const ShellElement& e) { return laws[static_cast<std::size_t>(e.object)].rigid; }) -
      elements.begin());
  blocks.clear();
  triangles = {};
  hinges = {};
  pending.clear();
  block_vertices.clear();
  used.clear();
  offsets.clear();
  greatest_copy = 0;
  Builder(*this).run();
  block_forces.resize(block_vertices.size());
  sums.assign(blocks.size(), {});
  scratch.clear();
}

void ShellTables::archive(Archive& archive) {
  std::vector<ShellElement> all = elements;
  Index vertices = mesh_vertices;
  archive(vertices);
  same_size(vertices, mesh_vertices);
  archive(all);
  if (archive.reading()) {
    for (const ShellElement& e : all) {
      const bool known = e.object >= 0 && static_cast<std::size_t>(e.object) < laws.size() &&
                         std::all_of(e.vertices.begin(), e.vertices.end(), [&](Index v) { return v < mesh_vertices; });
      same_size(known, true);
    }
    build(std::move(all), mesh_vertices);
  }
  for (auto& v : triangles.shape) state(archive, v);
  state(archive, triangles.strain);
  for (auto* v : {&hinges.rest, &hinges.last, &hinges.capacity, &hinges.reference}) state(archive, *v);
  archive(pending);
  for (const Index h : pending) same_size(h < hinges.rest.size(), true);
  archive(positions);
  archive(elastic);
  archive(plastic);
  archive(numerical);
  archive(greatest);
}

}  // namespace volccd::simulation::detail
