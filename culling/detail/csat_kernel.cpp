#include <volccd/culling/detail/csat_kernel.hpp>

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include <volccd/culling/detail/csat_axes.hpp>
#include <volccd/culling/detail/csat_points.hpp>
#include <volccd/culling/detail/csat_simplex.hpp>
#include <volccd/mesh/kdop.hpp>

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "volccd/culling/detail/csat_kernel.cpp"
#include <hwy/foreach_target.h>
#include <hwy/highway.h>

HWY_BEFORE_NAMESPACE();
namespace volccd::detail::HWY_NAMESPACE {

namespace hn = hwy::HWY_NAMESPACE;
using Tag = hn::CappedTag<double, 4>;
using Lanes = hn::Vec<Tag>;

HWY_INLINE Lanes project(const CsatPoints& points, int c, int i, Lanes lx, Lanes ly, Lanes lz) {
  const Tag tag;
  const auto x = hn::Mul(lx, hn::Load(tag, points.row(c, 0) + i));
  const auto y = hn::Mul(ly, hn::Load(tag, points.row(c, 1) + i));
  const auto z = hn::Mul(lz, hn::Load(tag, points.row(c, 2) + i));
  return hn::Add(hn::Add(x, y), z);
}

/// Least and greatest projection of one control point's vertices.
HWY_INLINE std::pair<Lanes, Lanes> range(const CsatPoints& points, int c, Lanes lx, Lanes ly, Lanes lz) {
  const Tag tag;
  Lanes low = project(points, c, 0, lx, ly, lz), high = low;
  for (int i = static_cast<int>(hn::Lanes(tag)); i < points.stride; i += static_cast<int>(hn::Lanes(tag))) {
    const Lanes p = project(points, c, i, lx, ly, lz);
    low = hn::Min(low, p);
    high = hn::Max(high, p);
  }
  return {hn::MinOfLanes(tag, low), hn::MaxOfLanes(tag, high)};
}

/// Two point sets and the tests on them.
class Separator {
 public:
  Separator(const CsatPoints& a, const CsatPoints& b, const CsatFrame& frame, double separation)
      : a_(a), b_(b), control_points_(frame.control_points), levels_(frame.levels), separation_(separation) {
    for (int k = 0; k < 3; ++k) {
      extent_[k] = std::max(a.extent[k], b.extent[k]);
      if (!(extent_[k] < kGreatestMagnitude)) extent_[k] = std::numeric_limits<double>::infinity();
    }
  }

  int control_points() const { return control_points_; }
  const CsatPoints& a() const { return a_; }
  const CsatPoints& b() const { return b_; }

  /// Whether b lies beyond a along `axis`, or a beyond b, at every control point.
  bool separates(const Vec3& axis) const {
    const Tag tag;
    const Lanes lx = hn::Set(tag, axis[0]), ly = hn::Set(tag, axis[1]), lz = hn::Set(tag, axis[2]);
    Lanes ahead = hn::Set(tag, std::numeric_limits<double>::infinity()), behind = ahead;
    for (int c = 0; c < control_points_; ++c) {
      const auto [a_low, a_high] = range(a_, c, lx, ly, lz);
      const auto [b_low, b_high] = range(b_, c, lx, ly, lz);
      ahead = hn::Min(hn::Sub(b_low, a_high), ahead);
      behind = hn::Min(hn::Sub(a_low, b_high), behind);
    }
    const double bound = threshold(axis);
    return hn::GetLane(ahead) > bound || hn::GetLane(behind) > bound;
  }

  /// Searches an axis by Gilbert-Johnson-Keerthi steps, the first of them along the difference of centroids.
  bool search(int iterations) const {
    const double scale = 1 / std::max({extent_[0], extent_[1], extent_[2]});
    Vec3 axis = scale * csat_centroid_difference(a_, b_, control_points_), support;
    if (ahead(axis, support)) return true;
    CsatSimplex simplex;
    simplex.add(axis);
    for (int i = 1; i < iterations; ++i) {
      support *= scale;
      if (simplex.contains(support)) return false;  // no axis does better
      simplex.add(support);
      if (!simplex.nearest(axis)) return false;
      axis = csat_scaled(axis);
      if (ahead(axis, support)) return true;
    }
    return false;
  }

 private:
  double threshold(const Vec3& axis) const {
    const double x = axis[0], y = axis[1], z = axis[2];
    const double sum = std::abs(x) * extent_[0] + std::abs(y) * extent_[1] + std::abs(z) * extent_[2];
    if (!(sum < kGreatestMagnitude)) return std::numeric_limits<double>::infinity();
    return gap_error_factor(levels_) * sum + kGapUnderflow + separation_gap(separation_, x, y, z);
  }

  /// Whether b lies beyond a along `axis`; if not, the point of conv{b - a} that is least far along it.
  bool ahead(const Vec3& axis, Vec3& support) const {
    const Tag tag;
    const Lanes lx = hn::Set(tag, axis[0]), ly = hn::Set(tag, axis[1]), lz = hn::Set(tag, axis[2]);
    double least = std::numeric_limits<double>::infinity();
    int at = 0;
    for (int c = 0; c < control_points_; ++c) {
      const double gap = hn::GetLane(hn::Sub(range(b_, c, lx, ly, lz).first, range(a_, c, lx, ly, lz).second));
      if (gap < least) {
        least = gap;
        at = c;
      }
    }
    if (least > threshold(axis)) return true;
    const int i = extreme(a_, at, -axis), j = extreme(b_, at, axis);
    for (int k = 0; k < 3; ++k) support[k] = b_.at(at, k, j) - a_.at(at, k, i);
    return false;
  }

  /// Vertex of least projection; the first of them.
  static int extreme(const CsatPoints& points, int c, const Vec3& axis) {
    int best = 0;
    double least = std::numeric_limits<double>::infinity();
    for (int i = 0; i < points.count; ++i) {
      const double p = axis[0] * points.at(c, 0, i) + axis[1] * points.at(c, 1, i) + axis[2] * points.at(c, 2, i);
      if (p < least) {
        least = p;
        best = i;
      }
    }
    return best;
  }

  const CsatPoints &a_, &b_;
  int control_points_, levels_;
  double separation_;
  double extent_[3];
};

/// One batch. Keeps the points of the last first element: broad phases emit runs of pairs with the same one.
class Culler {
 public:
  Culler(const Csat::Config& config, const Step& step) : config_(config), step_(step), frame_(step.motion, step.t_max) {}

  void cull(PairBatch& batch) {
    if (frame_.control_points > kCsatControlPoints) return;
    std::size_t kept = 0;
    for (std::size_t i = 0; i < batch.size(); ++i) {
      const ElementPair pair = batch.pairs[i];
      FeatureMask mask = batch.masks[i];
      if (drops(pair, mask)) continue;
      batch.pairs[kept] = pair;
      batch.masks[kept++] = mask;
    }
    batch.pairs.resize(kept);
    batch.masks.resize(kept);
  }

 private:
  bool drops(ElementPair pair, FeatureMask& mask) {
    const auto vertices_a = step_.mesh().vertices(pair.a), vertices_b = step_.mesh().vertices(pair.b);
    if (pair.a == pair.b || vertices_a.size() > kCsatVertices || vertices_b.size() > kCsatVertices) return false;
    if (pair.a != gathered_) {
      std::copy_n(step_.motion.at(vertices_a[0]), 3 * frame_.control_points, frame_.reference);
      a_.gather(frame_, step_.motion, vertices_a);
      gathered_ = pair.a;
    }
    b_.gather(frame_, step_.motion, vertices_b);
    if (config_.mode != CsatMode::features && separated(pair)) return true;
    if (config_.mode == CsatMode::pair) return false;
    mask_features(pair, mask);
    return nothing_left(pair, mask);
  }

  /// The whole elements.
  bool separated(ElementPair pair) const {
    const Separator separator(a_, b_, frame_, step_.separation);
    if (config_.axis != CsatAxis::face) return separated(separator);
    const std::uint64_t hash = pick(pair.a, pair.b, 0);
    return separator.separates(csat_face_normal(step_, pair.a, hash)) ||
           separator.separates(csat_face_normal(step_, pair.b, hash >> 32));
  }

  /// The axes that depend on the points alone.
  bool separated(const Separator& s) const {
    switch (config_.axis) {
      case CsatAxis::velocity: return s.separates(csat_velocity_axis(s.a(), s.b(), s.control_points()));
      case CsatAxis::centroid:
        return s.separates(csat_scaled(csat_centroid_difference(s.a(), s.b(), s.control_points())));
      case CsatAxis::optimal: return s.search(config_.iterations);
      default: break;
    }
    for (const auto& axis : kdop_axes<26>())
      if (s.separates(Vec3(axis[0], axis[1], axis[2]))) return true;
    return false;
  }

  /// Algorithm 2.
  void mask_features(ElementPair pair, FeatureMask& mask) {
    mask.vertices_a |= separate_vertices(a_, b_, pair.a, pair.b, mask.vertices_a);
    mask.vertices_b |= separate_vertices(b_, a_, pair.b, pair.a, mask.vertices_b);
    mask.edges_a |= separate_edges(a_, b_, pair.a, pair.b, mask.edges_a);
    if (config_.edges_of_b) mask.edges_b |= separate_edges(b_, a_, pair.b, pair.a, mask.edges_b);
  }

  /// Corollary 2: bits of the vertices of element o that touch nothing of `other`, but for those in `known`.
  std::uint32_t separate_vertices(const CsatPoints& own, const CsatPoints& others, Index o, Index other,
                                  std::uint32_t known) {
    std::uint32_t bits = 0;
    for (int i = 0; i < own.count; ++i) {
      if (known >> i & 1u) continue;
      feature_.take(own, frame_.control_points, i, i);
      const Separator separator(feature_, others, frame_, step_.separation);
      const bool apart = config_.axis == CsatAxis::face
                             ? separator.separates(csat_face_normal(step_, other, pick(o, other, i)))
                             : separated(separator);
      bits |= std::uint32_t{apart} << i;
    }
    return bits;
  }

  /// Corollary 4.
  std::uint64_t separate_edges(const CsatPoints& own, const CsatPoints& others, Index o, Index other,
                               std::uint64_t known) {
    const auto edges = step_.features().element_edges(o);
    const int count = static_cast<int>(std::min<std::size_t>(edges.size(), 64));
    std::uint64_t bits = 0;
    for (int i = 0; i < count; ++i) {
      if (known >> i & 1u) continue;
      const Index e = edges[static_cast<std::size_t>(i)];
      const auto& ends = step_.features().edge(e);
      feature_.take(own, frame_.control_points, local(o, ends[0]), local(o, ends[1]));
      const Separator separator(feature_, others, frame_, step_.separation);
      const bool apart = config_.axis == CsatAxis::face
                             ? separator.separates(csat_scaled(csat_edge_direction(step_, e).cross(
                                   csat_picked_edge(step_, other, pick(o, other, kCsatVertices + i)))))
                             : separated(separator);
      bits |= std::uint64_t{apart} << i;
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

  int local(Index o, Index vertex) const {
    const auto vertices = step_.mesh().vertices(o);
    return static_cast<int>(std::find(vertices.begin(), vertices.end(), vertex) - vertices.begin());
  }

  std::uint64_t pick(Index o, Index other, int feature) const {
    return csat_hash(static_cast<std::uint64_t>(step_.mesh().element_id(o)),
                     static_cast<std::uint64_t>(step_.mesh().element_id(other)), static_cast<std::uint64_t>(feature));
  }

  const Csat::Config& config_;
  const Step& step_;
  CsatFrame frame_;
  Index gathered_ = kNone;
  CsatPoints a_, b_, feature_;
};

void cull(const Csat::Config& config, const Step& step, PairBatch& batch) { Culler(config, step).cull(batch); }

}  // namespace volccd::detail::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace volccd::detail {

HWY_EXPORT(cull);

void csat_cull(const Csat::Config& config, const Step& step, PairBatch& batch) {
  HWY_DYNAMIC_DISPATCH(cull)(config, step, batch);
}

}  // namespace volccd::detail
#endif
