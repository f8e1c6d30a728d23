#include <volccd/culling/stars/detail/boundary_rings.hpp>

#include <algorithm>
#include <cmath>

#include <volccd/core/error.hpp>

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "volccd/culling/stars/detail/boundary_rings.cpp"
#include <hwy/foreach_target.h>
#include <volccd/numerics/vector_lanes-inl.hpp>
#include <volccd/query/vertex_records-inl.hpp>

HWY_BEFORE_NAMESPACE();
namespace volccd::detail::HWY_NAMESPACE {

HWY_INLINE void store_float(Lanes x, float* row) {
  const hn::Rebind<float, Tag> narrow;
  hn::Store(hn::DemoteTo(narrow, x), narrow, row);
}

/// Stores the coordinates in three rows of eight.
HWY_INLINE void store3(const Lanes3& a, float (*rows)[8], std::size_t lane) {
  store_float(a.x, rows[0] + lane);
  store_float(a.y, rows[1] + lane);
  store_float(a.z, rows[2] + lane);
}

HWY_INLINE Lanes3 unit(const Lanes3& a) {
  const Lanes square = dot(a, a), zero = hn::Zero(Tag());
  const Lanes factor = hn::IfThenElse(hn::Gt(square, zero), hn::Div(broadcast(1), hn::Sqrt(square)), zero);
  return scaled(a, factor);
}

/// Processes 8 faces.
template <int kControlPoints>
class Normals {
 public:
  /// At most 8 faces, and at least one.
  void gather(const Motion& motion, std::span<const std::array<Index, 3>> faces) {
    for (std::size_t v = 0; v < 3; ++v)
      gather_records<PointRows, kControlPoints>(
          motion, 8, [&](std::size_t i) HWY_ATTR { return faces[std::min(i, faces.size() - 1)][v]; }, points_[v][0]);
  }

  void compute(bool edges) {
    for (std::size_t lane = 0; lane < 8; lane += hn::Lanes(Tag())) {
      compute_lanes(lane);
      if (edges) find_longest_edges(lane);
    }
  }
  double longest_edge(std::size_t lane) const { return longest_edge_[lane]; }

  template <int kLanes>
  void store(std::size_t lane, FaceNormal<kLanes>& out) const {
    for (int axis = 0; axis < 3; ++axis) {
      for (int k = 0; k < kLanes; ++k) out.coefficients[axis][k] = normal_[k < kCoefficients ? k : 0][axis][lane];
      out.unit[axis] = unit_[axis][lane];
    }
    out.bound = bound_[lane];
  }

 private:
  static constexpr int kDegree = kControlPoints - 1, kCoefficients = 2 * kDegree + 1;
  struct PointRows {
    static constexpr std::size_t offset(int k) { return static_cast<std::size_t>(k) * 8; }
  };

  Lanes3 point(std::size_t vertex, int control_point, std::size_t lane) const {
    return load3(Tag(), points_[vertex][3 * control_point] + lane, 8);
  }

  void compute_lanes(std::size_t lane) {
    Lanes3 a[kControlPoints], b[kControlPoints], normal[kCoefficients];
    Lanes of_a = broadcast(kMinExtent), of_b = of_a, greatest = hn::Zero(Tag());
    for (int c = 0; c < kControlPoints; ++c) {
      const Lanes3 origin = point(0, c, lane);
      a[c] = sub(point(1, c, lane), origin);
      b[c] = sub(point(2, c, lane), origin);
      of_a = hn::Max(of_a, norm1(a[c]));
      of_b = hn::Max(of_b, norm1(b[c]));
    }
    for (int k = 0; k < kCoefficients; ++k) normal[k] = {hn::Zero(Tag()), hn::Zero(Tag()), hn::Zero(Tag())};
    for (int i = 0; i <= kDegree; ++i)
      for (int j = 0; j <= kDegree; ++j) {
        const double weight = (kDegree == 2 && i == 1 ? 2 : 1) * (kDegree == 2 && j == 1 ? 2 : 1);
        normal[i + j] = add(normal[i + j], scaled(cross(a[i], b[j]), broadcast(weight)));
      }
    for (const Lanes3& n : normal)
      greatest = hn::Max(greatest, hn::Max(hn::Abs(n.x), hn::Max(hn::Abs(n.y), hn::Abs(n.z))));
    const Lanes scale = hn::Div(broadcast(1), greatest);
    for (int k = 0; k < kCoefficients; ++k) store3(scaled(normal[k], scale), normal_[k], lane);
    // The weights of a coefficient sum to at most 6; a term has fewer than 16 rounding errors (docs/clear_stars.md).
    const Lanes product = hn::Mul(broadcast(6 * 32 * kUnitRoundoff), trusted(hn::Mul(trusted(of_a), trusted(of_b))));
    const Lanes bound = hn::Mul(hn::Add(product, broadcast(kDeterminantUnderflow)), scale);
    // For single precision, in which the bound itself is rounded as well.
    store_float(hn::Mul(hn::Add(bound, broadcast(0x1p-23)), broadcast(1 + 0x1p-20)), bound_ + lane);
    hn::Store(scale, Tag(), scale_ + lane);
    store3(add(unit(normal[0]), unit(normal[2 * kDegree])), unit_, lane);
  }

  /// Upper bounds. A length at any time is less than the greatest one at a control point.
  void find_longest_edges(std::size_t lane) {
    Lanes longest = hn::Zero(Tag());
    for (int c = 0; c < kControlPoints; ++c)
      for (std::size_t v = 0; v < 3; ++v)
        longest = hn::Max(longest, length(sub(point((v + 1) % 3, c, lane), point(v, c, lane))));
    const Lanes slack = hn::Mul(broadcast(kLengthSlack), hn::Load(Tag(), scale_ + lane));
    hn::Store(hn::Mul(longest, slack), Tag(), longest_edge_ + lane);
  }

  alignas(64) double points_[3][3 * kControlPoints][8] = {};
  alignas(64) float normal_[kCoefficients][3][8], unit_[3][8], bound_[8];
  alignas(64) double scale_[8], longest_edge_[8];  // scale_: by what the coefficients were multiplied
};

template <int kControlPoints, int kLanes>
void normals_of(const Step& step, std::span<const std::array<Index, 3>> faces, FaceNormal<kLanes>* out,
                double* longest_edges) {
  Normals<kControlPoints> normals;
  for (std::size_t first = 0; first < faces.size(); first += 8) {
    const std::size_t count = std::min<std::size_t>(8, faces.size() - first);
    normals.gather(step.motion, faces.subspan(first, count));
    normals.compute(longest_edges != nullptr);
    for (std::size_t lane = 0; lane < count; ++lane) normals.store(lane, out[first + lane]);
    if (!longest_edges) continue;
    for (std::size_t lane = 0; lane < count; ++lane) longest_edges[first + lane] = normals.longest_edge(lane);
  }
}

/// The binomials of the coefficients of a FaceNormal.
template <int kLanes>
HWY_INLINE const double* binomials() {
  alignas(64) static constexpr double linear[4] = {1, 2, 1, 1}, quadratic[8] = {1, 4, 6, 4, 1, 1, 1, 1};
  return kLanes == 4 ? linear : quadratic;
}

/// Whether a ring folds; sets `up` to the sum of the unit normals of its triangles. kApart: with a separation.
template <int kLanes, bool kApart>
HWY_INLINE bool folds_at(double separation, std::span<const RingCorner> corners, const FaceNormal<kLanes>* normals,
                         const double* longest_edges, Eigen::Vector3f& up) {
  const hn::CappedTag<double, kLanes> tag;
  Vec3 sum = Vec3::Zero();
  for (const RingCorner& c : corners) {
    if (!c.of_triangle) continue;
    const float* const unit = normals[c.face].unit;
    sum += Vec3(double{unit[0]}, double{unit[1]}, double{unit[2]});
  }
  up = sum.cast<float>();  // any direction would do
  const double x = double{up[0]}, y = double{up[1]}, z = double{up[2]};
  const double size = std::abs(x) + std::abs(y) + std::abs(z);
  const double gap = kApart ? separation_gap(separation, x, y, z) : 0;
  const LaneVector<hn::Vec<decltype(tag)>> direction{hn::Set(tag, x), hn::Set(tag, y), hn::Set(tag, z)};
  for (const RingCorner& c : corners) {
    if (!c.tested) continue;
    const FaceNormal<kLanes>& normal = normals[c.face];
    const auto rounding = hn::Set(tag, double{normal.bound} * size);
    const double area = kApart ? gap * longest_edges[c.face] : 0;
    for (int k = 0; k < kLanes; k += static_cast<int>(hn::Lanes(tag))) {
      auto bound = rounding;
      if (kApart) bound = hn::Add(bound, hn::Mul(hn::Set(tag, area), hn::Load(tag, binomials<kLanes>() + k)));
      const auto axis = [&](int i) HWY_ATTR {
        return hn::PromoteTo(tag, hn::Load(hn::Rebind<float, decltype(tag)>(), normal.coefficients[i] + k));
      };
      if (!hn::AllTrue(tag, hn::Gt(dot(direction, {axis(0), axis(1), axis(2)}), bound))) return true;
    }
  }
  return false;
}

template <int kControlPoints, int kLanes>
void folds_of(const Step& step, const RingGroup& group, FaceNormal<kLanes>* normals) {
  double* const longest_edges = group.normals.longest_edges;
  normals_of<kControlPoints>(step, group.triangles, normals, longest_edges);
  for (Index v = group.begin; v < group.end; ++v) {
    const std::span<const RingCorner> corners(group.corners + group.begins[v], group.corners + group.begins[v + 1]);
    const bool folds =
        step.separation > 0
            ? folds_at<kLanes, true>(step.separation, corners, normals, longest_edges, group.ups[v])
            : folds_at<kLanes, false>(0, corners, normals, nullptr, group.ups[v]);
    group.folds[v] = folds ? 1 : 0;
  }
}

void find_group_folds(const Step& step, const RingGroup& group) {
  step.motion.control_points() == 2 ? folds_of<2>(step, group, group.normals.linear)
                                    : folds_of<3>(step, group, group.normals.quadratic);
}

}  // namespace volccd::detail::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace volccd::detail {

HWY_EXPORT(find_group_folds);

namespace {
/// Vertices of a group. The normals of its faces are in the second-level cache.
constexpr Index kGroup = 2048;
}  // namespace

FaceNormals BoundaryRings::Normals::resize(std::size_t triangles, const Step& step) {
  if (step.motion.control_points() == 2)
    linear.resize(std::max(linear.size(), triangles));
  else
    quadratic.resize(std::max(quadratic.size(), triangles));
  if (step.separation > 0) longest_edges.resize(std::max(longest_edges.size(), triangles));
  return {linear.data(), quadratic.data(), step.separation > 0 ? longest_edges.data() : nullptr};
}

void BoundaryRings::set_faces(const Mesh& mesh, std::span<const RingFace> faces) {
  if (faces.size() > RingCorner::kMaxFaces) throw Error("a mesh with more than 2^30 boundary triangles");
  ups_.resize(mesh.vertex_count());
  begins_.assign(mesh.vertex_count() + std::size_t{1}, 0);
  const auto visit_corners = [&](auto&& visit) {
    for (std::size_t f = 0; f < faces.size(); ++f)
      for (unsigned i = 0; i < 4; ++i)
        if (i < 3 || faces[f].fourth != kNone)
          visit(faces[f].vertex(i), RingCorner{static_cast<Index>(f) & (RingCorner::kMaxFaces - 1), i < 3,
                                               (faces[f].tested >> i & 1) != 0});
  };
  visit_corners([&](Index v, const RingCorner&) { ++begins_[v]; });
  Index end = 0;
  for (Index& begin : begins_) begin = end += begin;  // the ends; filling moves them to the beginnings
  corners_.resize(end);
  visit_corners([&](Index v, const RingCorner& corner) { corners_[--begins_[v]] = corner; });
  group_triangles(faces);
}

/// Lists the triangles of the groups, and makes the faces of corners places among those of their group.
void BoundaryRings::group_triangles(std::span<const RingFace> faces) {
  std::vector<std::size_t> places(faces.size(), 0);  // 1 + that in triangles_ where the face is last
  triangles_.clear();
  triangles_.reserve(faces.size());
  groups_.assign(1, 0);
  const auto vertices = static_cast<Index>(ups_.size());
  for (Index begin = 0; begin < vertices; begin += kGroup) {
    const std::size_t first = triangles_.size();
    for (Index i = begins_[begin]; i < begins_[std::min(begin + kGroup, vertices)]; ++i) {
      std::size_t& place = places[corners_[i].face];
      if (place <= first) {
        triangles_.push_back(faces[corners_[i].face].triangle);
        place = triangles_.size();
      }
      corners_[i].face = static_cast<Index>(place - 1 - first) & (RingCorner::kMaxFaces - 1);
    }
    groups_.push_back(triangles_.size());
  }
  triangles_.shrink_to_fit();
}

void BoundaryRings::find_folds(const Step& step, Executor& executor, std::vector<std::uint8_t>& folds) {
  const auto vertices = static_cast<Index>(ups_.size());
  folds.resize(vertices);
  normals_.resize(std::max<std::size_t>(normals_.size(), executor.workers()));
  executor.parallel_for(groups_.size() - 1, 1, [&](std::size_t begin, std::size_t end, unsigned w) {
    for (std::size_t g = begin; g < end; ++g) {
      const std::span triangles(triangles_.data() + groups_[g], groups_[g + 1] - groups_[g]);
      const Index first = static_cast<Index>(g) * kGroup;
      const RingGroup group{.begin = first,
                            .end = std::min(first + kGroup, vertices),
                            .triangles = triangles,
                            .corners = corners_.data(),
                            .begins = begins_.data(),
                            .ups = ups_.data(),
                            .folds = folds.data(),
                            .normals = normals_[w].resize(triangles.size(), step)};
      HWY_DYNAMIC_DISPATCH(find_group_folds)(step, group);
    }
  });
}

}  // namespace volccd::detail
#endif
