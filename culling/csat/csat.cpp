#include <volccd/culling/csat/csat.hpp>

#include <algorithm>
#include <limits>
#include <span>
#include <utility>

#include <volccd/culling/csat/csat_axes.hpp>
#include <volccd/culling/csat/csat_points.hpp>
#include <volccd/numerics/gjk_simplex.hpp>
#include <volccd/numerics/kdop.hpp>

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "volccd/culling/csat/csat.cpp"
#include <hwy/foreach_target.h>
#include <volccd/culling/csat/detail/csat_pair_search-inl.hpp>
#include <volccd/numerics/vector_lanes-inl.hpp>

HWY_BEFORE_NAMESPACE();
namespace volccd::detail::HWY_NAMESPACE {

using CsatTag = hn::CappedTag<double, 4>;  // CsatPoints are padded to multiples of 4
using CsatLanes = hn::Vec<CsatTag>;
using CsatLanes3 = LaneVector<CsatLanes>;

HWY_INLINE CsatLanes3 broadcast(const Vec3& a) {
  return {broadcast<CsatLanes>(a[0]), broadcast<CsatLanes>(a[1]), broadcast<CsatLanes>(a[2])};
}
HWY_INLINE CsatLanes infinite() { return broadcast<CsatLanes>(std::numeric_limits<double>::infinity()); }

HWY_INLINE CsatLanes project(const CsatPoints& points, int c, int i, const CsatLanes3& axis) {
  return dot(axis, load3(CsatTag(), points.row(c, 0) + i, static_cast<std::size_t>(points.stride)));
}

/// Smallest and greatest projection of the vertices at one control point.
HWY_INLINE std::pair<CsatLanes, CsatLanes> range(const CsatPoints& points, int c, const CsatLanes3& axis) {
  const CsatTag tag;
  CsatLanes low = project(points, c, 0, axis), high = low;
  for (int i = static_cast<int>(hn::Lanes(tag)); i < points.stride; i += static_cast<int>(hn::Lanes(tag))) {
    const CsatLanes p = project(points, c, i, axis);
    low = hn::Min(low, p);
    high = hn::Max(high, p);
  }
  return {hn::MinOfLanes(tag, low), hn::MaxOfLanes(tag, high)};
}

/// Replaces the control points by those of the motion over the interval of the step.
template <int kControlPoints>
void restrict_points(const StepInterval& interval, CsatPoints& points) {
  const CsatTag tag;
  const auto stride = static_cast<std::size_t>(points.stride);
  for (std::size_t i = 0; i < stride; i += hn::Lanes(tag)) {
    CsatLanes3 p[kControlPoints];
    for (int c = 0; c < kControlPoints; ++c) p[c] = load3(tag, points.row(c, 0) + i, stride);
    restrict_to(interval, p);
    for (int c = 0; c < kControlPoints; ++c) {
      double* x = points.rows + static_cast<std::size_t>(3 * c) * stride + i;
      hn::Store(p[c].x, tag, x);
      hn::Store(p[c].y, tag, x + stride);
      hn::Store(p[c].z, tag, x + 2 * stride);
    }
  }
  for (int k = 0; k < 3; ++k) {
    points.total[k] = 0;
    for (int c = 0; c < kControlPoints; ++c)
      for (int i = 0; i < points.count; ++i) points.total[k] += points.at(c, k, i);
  }
}

/// Two point sets, and the tests for axes that separate them.
class Separator {
 public:
  Separator(const CsatPoints& a, const CsatPoints& b, const CsatFrame& frame, double separation)
      : a_(a),
        b_(b),
        control_points_(frame.control_points),
        factor_(gap_error_factor(frame.interval.levels)),
        separation_(separation),
        extent_(trusted(max(broadcast(Vec3(a.extent)), broadcast(Vec3(b.extent))))) {}

  /// Tests the axes that depend on the points alone.
  bool separated(const Csat::Config& config) const {
    switch (config.axis) {
      case CsatAxis::velocity: return separates(csat_velocity_axis(a_, b_, control_points_));
      case CsatAxis::centroid: return separates(csat_scaled(csat_centroid_difference(a_, b_, control_points_)));
      case CsatAxis::optimal: return search(config.iterations);
      default: break;
    }
    for (const auto& axis : kdop_axes<26>())
      if (separates(Vec3(axis[0], axis[1], axis[2]))) return true;
    return false;
  }

  /// Whether at every control point b is beyond a along `axis`, or at every control point a is beyond b.
  bool separates(const Vec3& axis) const {
    const CsatLanes3 l = broadcast(axis);
    CsatLanes ahead = infinite(), behind = ahead;
    for (int c = 0; c < control_points_; ++c) {
      const auto [a_low, a_high] = range(a_, c, l);
      const auto [b_low, b_high] = range(b_, c, l);
      ahead = hn::Min(hn::Sub(b_low, a_high), ahead);
      behind = hn::Min(hn::Sub(a_low, b_high), behind);
    }
    return lane_bits(ahead, behind, threshold(l)) != 0;
  }

  /// Bits of the vertices of a that are beyond b along `axis` at every control point, or before b at every control
  /// point.
  std::uint32_t separate_vertices(const Vec3& axis) const {
    const CsatLanes3 l = broadcast(axis);
    std::pair<CsatLanes, CsatLanes> others[kCsatControlPoints];
    for (int c = 0; c < control_points_; ++c) others[c] = range(b_, c, l);
    const CsatLanes bound = threshold(l);
    std::uint32_t bits = 0;
    for (int i = 0; i < a_.stride; i += static_cast<int>(hn::Lanes(CsatTag()))) {
      CsatLanes ahead = infinite(), behind = ahead;
      for (int c = 0; c < control_points_; ++c) {
        const CsatLanes own = project(a_, c, i, l);
        ahead = hn::Min(hn::Sub(others[c].first, own), ahead);
        behind = hn::Min(hn::Sub(own, others[c].second), behind);
      }
      bits |= lane_bits(ahead, behind, bound) << i;
    }
    return a_.count == 32 ? bits : bits & ((std::uint32_t{1} << a_.count) - 1);
  }

  /// Bits of the edges of a that are separated from b along an axis, which is the cross product of the direction of the
  /// edge and `other`.
  std::uint64_t separate_edges(const CsatEdges& edges, const Vec3& other) const {
    const CsatTag tag;
    std::uint64_t bits = 0;
    for (int i = 0; i < edges.count; i += static_cast<int>(hn::Lanes(tag))) {
      CsatLanes3 l = cross(load3(tag, edges.direction[0] + i, CsatEdges::kMax), broadcast(other));
      l = scaled(l, hn::Div(broadcast<CsatLanes>(1), greatest_coordinate(abs(l))));
      bits |= std::uint64_t{edges_apart(edges, i, l)} << i;
    }
    return edges.count == 64 ? bits : bits & ((std::uint64_t{1} << edges.count) - 1);
  }

  /// Searches for a separating axis with the Gilbert-Johnson-Keerthi algorithm, starting with the difference of the
  /// centroids.
  bool search(int iterations) const {
    const double scale = 1 / hn::GetLane(greatest_coordinate(extent_));
    Vec3 axis = scale * csat_centroid_difference(a_, b_, control_points_), support;
    if (ahead(axis, support)) return true;
    GjkSimplex simplex;
    simplex.add(axis);
    for (int i = 1; i < iterations; ++i) {
      support *= scale;
      if (simplex.contains(support)) return false;  // no axis has a larger gap
      simplex.add(support);
      if (!simplex.reduce(axis)) return false;
      axis = csat_scaled(axis);
      if (ahead(axis, support)) return true;
    }
    return false;
  }

 private:
  /// Bit l is set if lane l of `ahead` or of `behind` exceeds its bound; never for NaN.
  static std::uint32_t lane_bits(CsatLanes ahead, CsatLanes behind, CsatLanes bound) {
    return mask_bits(CsatTag(), hn::Or(hn::Gt(ahead, bound), hn::Gt(behind, bound)));
  }

  /// Tests the edges i, i + 1, .. in lanes, each with its own axis.
  std::uint32_t edges_apart(const CsatEdges& edges, int i, const CsatLanes3& l) const {
    constexpr int kMax = 4;  // lanes
    const CsatTag tag;
    CsatLanes ahead = infinite(), behind = ahead;
    for (int c = 0; c < control_points_; ++c) {
      alignas(32) double ends[2][3][kMax];
      for (std::size_t lane = 0; lane < hn::Lanes(tag); ++lane)
        for (int k = 0; k < 3; ++k) {
          ends[0][k][lane] = a_.at(c, k, edges.ends[0][static_cast<std::size_t>(i) + lane]);
          ends[1][k][lane] = a_.at(c, k, edges.ends[1][static_cast<std::size_t>(i) + lane]);
        }
      const CsatLanes p = dot(l, load3(tag, ends[0][0], kMax)), q = dot(l, load3(tag, ends[1][0], kMax));
      const auto point = [&](int j) HWY_ATTR {
        return dot(l, broadcast(Vec3(b_.at(c, 0, j), b_.at(c, 1, j), b_.at(c, 2, j))));
      };
      CsatLanes low = point(0), high = low;
      for (int j = 1; j < b_.count; ++j) {
        const CsatLanes projection = point(j);
        low = hn::Min(low, projection);
        high = hn::Max(high, projection);
      }
      ahead = hn::Min(hn::Sub(low, hn::Max(p, q)), ahead);
      behind = hn::Min(hn::Sub(hn::Min(p, q), high), behind);
    }
    return lane_bits(ahead, behind, threshold(l));
  }

  CsatLanes threshold(const CsatLanes3& axis) const { return gap_threshold(axis, extent_, factor_, separation_); }

  /// Whether b is beyond a along `axis`. If not, `support` is the point of conv{b - a} with the smallest component
  /// along it.
  bool ahead(const Vec3& axis, Vec3& support) const {
    const CsatLanes3 l = broadcast(axis);
    double min = std::numeric_limits<double>::infinity();
    int at = 0;
    for (int c = 0; c < control_points_; ++c) {
      const double gap = hn::GetLane(hn::Sub(range(b_, c, l).first, range(a_, c, l).second));
      if (gap < min) {
        min = gap;
        at = c;
      }
    }
    if (min > hn::GetLane(threshold(l))) return true;
    const int i = extreme(a_, at, -axis), j = extreme(b_, at, axis);
    for (int k = 0; k < 3; ++k) support[k] = b_.at(at, k, j) - a_.at(at, k, i);
    return false;
  }

  /// The first vertex with the smallest projection.
  static int extreme(const CsatPoints& points, int c, const Vec3& axis) {
    int best = 0;
    double min = std::numeric_limits<double>::infinity();
    for (int i = 0; i < points.count; ++i) {
      const double p = axis[0] * points.at(c, 0, i) + axis[1] * points.at(c, 1, i) + axis[2] * points.at(c, 2, i);
      if (p < min) {
        min = p;
        best = i;
      }
    }
    return best;
  }

  const CsatPoints &a_, &b_;
  int control_points_;
  double factor_, separation_;
  CsatLanes3 extent_;
};

/// Processes one batch. Keeps the points of the last first element, because consecutive pairs often have the same one
/// (1.0 to 1.6 pairs on average).
class Culler {
 public:
  Culler(const Csat::Config& config, const Step& step)
      : config_(config), step_(step), frame_(step.motion, step.t_max) {}

  void cull(PairBatch& batch) {
    if (frame_.control_points > kCsatControlPoints) return;
    if (config_.mode != CsatMode::features && (config_.axis == CsatAxis::centroid || config_.axis == CsatAxis::optimal))
      return frame_.control_points == 2 ? cull_in_lanes<2>(batch) : cull_in_lanes<3>(batch);
    batch.cull([this](ElementPair pair, FeatureMask& mask) { return judge(pair, mask, PairFinding::open); });
  }

 private:
  /// Many pairs are first processed together in single precision, the remaining ones one by one in double precision.
  template <int kControlPoints>
  void cull_in_lanes(PairBatch& batch) {
    PairSearch<kControlPoints> search(config_, frame_, step_);
    const std::size_t size = batch.size();
    std::size_t i = 0;
    batch.cull([&](ElementPair pair, FeatureMask& mask) {
      constexpr std::size_t block = PairSearch<kControlPoints>::kBlock;
      if (i % block == 0) search.judge(std::span(batch.pairs).subspan(i, std::min(block, size - i)));
      const PairFinding finding = search.finding(i++ % block);
      return finding == PairFinding::disjoint ? PairVerdict::disjoint : judge(pair, mask, finding);
    });
  }

  PairVerdict judge(ElementPair pair, FeatureMask& mask, PairFinding finding) {
    if (finding == PairFinding::kept && config_.mode == CsatMode::pair) return PairVerdict::keep;
    const auto vertices_a = vertices(pair.a), vertices_b = vertices(pair.b);
    if (pair.a == pair.b || vertices_a.size() > kCsatVertices || vertices_b.size() > kCsatVertices)
      return PairVerdict::keep;
    if (pair.a != gathered_) {
      std::copy_n(step_.motion.at(vertices_a[0]), 3 * frame_.control_points, frame_.reference);
      gather(a_, vertices_a);
      gathered_ = pair.a;
    }
    gather(b_, vertices_b);
    if (config_.mode != CsatMode::features && finding == PairFinding::open && separated(pair))
      return PairVerdict::disjoint;
    if (config_.mode == CsatMode::pair) return PairVerdict::keep;
    mask_features(pair, mask);
    return nothing_left(pair, mask) ? PairVerdict::contact_free : PairVerdict::keep;
  }

  std::span<const Index> vertices(Index o) const { return step_.mesh().vertices(o); }

  template <int kControlPoints>
  void gather(CsatPoints& points, std::span<const Index> vertices) const {
    points.gather<kControlPoints>(frame_, step_.motion, vertices);
    if (frame_.interval.levels != 0) restrict_points<kControlPoints>(frame_.interval, points);
  }
  void gather(CsatPoints& points, std::span<const Index> vertices) const {
    frame_.control_points == 2 ? gather<2>(points, vertices) : gather<3>(points, vertices);
  }

  /// Tests the two elements as a whole.
  bool separated(ElementPair pair) const {
    const Separator separator(a_, b_, frame_, step_.separation);
    if (config_.axis != CsatAxis::face) return separator.separated(config_);
    const std::uint64_t hash = csat_pick(step_, pair.a, pair.b, 0);
    return separator.separates(csat_face_normal(step_, pair.a, hash)) ||
           separator.separates(csat_face_normal(step_, pair.b, hash >> 32));
  }

  /// Algorithm 2.
  void mask_features(ElementPair pair, FeatureMask& mask) {
    mask.vertices_a |= separate_vertices(a_, b_, pair.a, pair.b, mask.vertices_a);
    mask.vertices_b |= separate_vertices(b_, a_, pair.b, pair.a, mask.vertices_b);
    if (pair.a != edges_gathered_) {
      edges_a_.gather(step_, pair.a);
      edges_gathered_ = pair.a;
    }
    mask.edges_a |= separate_edges(a_, edges_a_, b_, pair.a, pair.b, mask.edges_a);
    if (!config_.edges_of_b) return;
    edges_b_.gather(step_, pair.b);
    mask.edges_b |= separate_edges(b_, edges_b_, a_, pair.b, pair.a, mask.edges_b);
  }

  /// Corollary 2: bits of the vertices of element o that are separated from `other`. Axis `face`: one picked face of
  /// the other element for all vertices, so that each point is projected once. Other axes: a separate axis for each
  /// vertex.
  std::uint32_t separate_vertices(const CsatPoints& own, const CsatPoints& others, Index o, Index other,
                                  std::uint32_t known) {
    if (config_.axis == CsatAxis::face)
      return known | Separator(own, others, frame_, step_.separation)
                         .separate_vertices(csat_face_normal(step_, other, csat_pick(step_, o, other, 0)));
    std::uint32_t bits = 0;
    for (int i = 0; i < own.count; ++i) {
      if (known >> i & 1u) continue;
      feature_.copy_vertices(own, frame_.control_points, i, i);
      bits |= std::uint32_t{Separator(feature_, others, frame_, step_.separation).separated(config_)} << i;
    }
    return bits;
  }

  /// Corollary 4. Axis `face`: the cross products of all edges and one picked edge of the other element.
  std::uint64_t separate_edges(const CsatPoints& own, const CsatEdges& own_edges, const CsatPoints& others, Index o,
                               Index other, std::uint64_t known) {
    if (config_.axis == CsatAxis::face)
      return known | Separator(own, others, frame_, step_.separation)
                         .separate_edges(own_edges, csat_picked_edge(step_, other, csat_pick(step_, o, other, 1)));
    std::uint64_t bits = 0;
    for (int i = 0; i < own_edges.count; ++i) {
      if (known >> i & 1u) continue;
      feature_.copy_vertices(own, frame_.control_points, own_edges.ends[0][i], own_edges.ends[1][i]);
      bits |= std::uint64_t{Separator(feature_, others, frame_, step_.separation).separated(config_)} << i;
    }
    return bits;
  }

  bool nothing_left(ElementPair pair, const FeatureMask& mask) const {
    const auto all = [](std::uint64_t bits, std::size_t count) {
      return count <= 64 && bits == (count == 64 ? ~std::uint64_t{0} : (std::uint64_t{1} << count) - 1);
    };
    return all(mask.vertices_a, static_cast<std::size_t>(a_.count)) &&
           all(mask.vertices_b, static_cast<std::size_t>(b_.count)) &&
           (all(mask.edges_a, step_.features().element_edges(pair.a).size()) ||
            all(mask.edges_b, step_.features().element_edges(pair.b).size()));
  }

  const Csat::Config& config_;
  const Step& step_;
  CsatFrame frame_;
  Index gathered_ = kNone, edges_gathered_ = kNone;
  CsatPoints a_, b_, feature_;
  CsatEdges edges_a_, edges_b_;
};

void cull(const Csat::Config& config, const Step& step, PairBatch& batch) { Culler(config, step).cull(batch); }

}  // namespace volccd::detail::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace volccd {
namespace detail {
HWY_EXPORT(cull);
}

const Options<Csat::Config>& Csat::options() {
  static const Options<Config> options =
      Options<Config>()
          .add("axis", &Config::axis,
               {{"face", CsatAxis::face},
                {"predetermined", CsatAxis::predetermined},
                {"velocity", CsatAxis::velocity},
                {"centroid", CsatAxis::centroid},
                {"optimal", CsatAxis::optimal}},
               "where the separating axis comes from; face is the paper's")
          .add("mode", &Config::mode,
               {{"features", CsatMode::features}, {"pair", CsatMode::pair}, {"both", CsatMode::both}},
               "Algorithm 2 (features), one axis for the whole pair, or both in turn")
          .add("iterations", &Config::iterations, 1, 64, "most axes that optimal tries")
          .add("edges_of_b", &Config::edges_of_b, "features mode tests the edges of the second element, too");
  return options;
}

void Csat::run(const Step& step, StageState&, unsigned, PairBatch& batch) const {
  using namespace detail;
  HWY_DYNAMIC_DISPATCH(cull)(config_, step, batch);
}

StageDescriptor<ElementCulling> describe_csat() {
  return describe_stage<ElementCulling, Csat>("csat", "continuous separating axis test of element pairs (Section 4)",
                                              Guarantee::conservative);
}

}  // namespace volccd
#endif
