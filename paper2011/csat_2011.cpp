#include <volccd/paper2011/csat_2011.hpp>

#include <volccd/culling/csat/csat_axes.hpp>
#include <volccd/paper2011/csat_reference.hpp>
#include <volccd/paper2011/reference_vectors.hpp>

namespace volccd {
namespace {

using reference::Vector3;
using Point = reference::MovingPoint<double>;
using Edge = std::array<Point, 2>;
using Triangle = std::array<Point, 3>;

constexpr std::size_t kMaxVertices = 32, kMaxEdges = 64;  // number of bits in FeatureMask

/// Whether the step is of the kind that the 2011 implementation supported.
bool handled(const Step& step) { return step.motion.control_points() == 2 && step.separation == 0; }

template <std::size_t N>
std::array<Point, N> points_of(const Motion& motion, const std::array<Index, N>& vertices) {
  std::array<Point, N> points;
  for (std::size_t i = 0; i < N; ++i) points[i] = reference::moving_point(motion, vertices[i]);
  return points;
}

/// The vertices and features of an element, gathered once for all of its tests with another element.
struct Element {
  Index slot = kNone;
  std::size_t count = 0;
  std::array<Point, kMaxVertices> points;

  void gather(const Step& step, Index o) {
    if (o == slot) return;
    slot = o;
    count = 0;
    for (const Index v : step.mesh().vertices(o)) points[count++] = reference::moving_point(step.motion, v);
  }
  std::span<const Point> all() const { return {points.data(), count}; }
};

constexpr std::uint64_t bits(std::size_t count) {
  return count == 64 ? ~std::uint64_t{0} : (std::uint64_t{1} << count) - 1;
}

/// Corollary 2: adds the bits of the vertices of `own` that are separated from `other`. Returns whether all bits are
/// set afterwards.
bool mask_vertices(const Step& step, const Element& own, const Element& other, std::uint32_t& mask) {
  const auto faces = step.features().element_triangles(other.slot);
  const Index face = faces[detail::csat_pick(step, own.slot, other.slot, 0) % faces.size()];
  const Vector3<double> axis = reference::start_normal(points_of(step.motion, step.features().triangle(face)));
  for (std::size_t i = 0; i < own.count; ++i)
    if ((mask >> i & 1) == 0 && reference::apart_along(axis, {&own.points[i], 1}, other.all()))
      mask |= std::uint32_t{1} << i;
  return mask == bits(own.count);
}

/// Corollary 4: adds the bits of the edges of `own` that are separated from `other`. Returns whether all bits are set
/// afterwards.
bool mask_edges(const Step& step, const Element& own, const Element& other, std::uint64_t& mask) {
  const auto edges = step.features().element_edges(own.slot), others = step.features().element_edges(other.slot);
  const Index picked = others[detail::csat_pick(step, own.slot, other.slot, 1) % others.size()];
  const Edge other_edge = points_of(step.motion, step.features().edge(picked));
  for (std::size_t i = 0; i < edges.size(); ++i) {
    if (mask >> i & 1) continue;
    const Edge edge = points_of(step.motion, step.features().edge(edges[i]));
    if (reference::apart_along(reference::start_cross(edge, other_edge), std::span<const Point>(edge), other.all()))
      mask |= std::uint64_t{1} << i;
  }
  return mask == bits(edges.size());
}

bool fits(const Step& step, Index o) {
  return step.mesh().vertices(o).size() <= kMaxVertices && step.features().element_edges(o).size() <= kMaxEdges;
}

}  // namespace

void Csat2011::run(const Step& step, StageState&, unsigned, PairBatch& batch) const {
  if (!handled(step)) return;
  Element a, b;
  batch.cull([&](ElementPair pair, FeatureMask& mask) {
    if (pair.a == pair.b || !fits(step, pair.a) || !fits(step, pair.b)) return PairVerdict::keep;
    a.gather(step, pair.a);
    b.gather(step, pair.b);
    const bool no_vertex_of_a = mask_vertices(step, a, b, mask.vertices_a);
    const bool no_vertex_of_b = mask_vertices(step, b, a, mask.vertices_b);
    const bool no_edge = mask_edges(step, a, b, mask.edges_a);
    return no_vertex_of_a && no_vertex_of_b && no_edge ? PairVerdict::contact_free : PairVerdict::keep;
  });
}

void CsatFilter2011::run(const Step& step, StageState&, unsigned, const TestBlock& block,
                         std::span<std::uint8_t> keep) const {
  if (!handled(step)) return;
  for (std::size_t i = 0; i < block.size(); ++i) {
    if (!keep[i]) continue;
    const std::array<Point, 4> p = points_of(step.motion, block.vertices(i));
    if (block.kind() == FeatureKind::vf) {
      const Triangle f = {p[1], p[2], p[3]};
      keep[i] = !reference::vertex_apart(p[0], f, reference::start_normal(f));
    } else {
      const Edge e = {p[0], p[1]}, g = {p[2], p[3]};
      keep[i] = !reference::edges_apart(e, g, reference::start_cross(e, g));
    }
  }
}

StageDescriptor<ElementCulling> describe_csat_2011() {
  return describe_stage<ElementCulling, Csat2011>(
      "csat-2011", "CSAT as printed: Algorithm 2, scalar, without rounding bounds", Guarantee::approximate);
}

StageDescriptor<FeatureFilter> describe_csat_filter_2011() {
  return describe_stage<FeatureFilter, CsatFilter2011>(
      "feature-csat-2011", "CSAT as printed: Corollaries 1 and 3, scalar, without rounding bounds",
      Guarantee::approximate);
}

}  // namespace volccd
