#include <volccd/culling/detail/boundary_rings.hpp>

#include <cmath>

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "volccd/culling/detail/boundary_rings.cpp"
#include <hwy/foreach_target.h>
#include <volccd/query/vector_lanes-inl.hpp>

HWY_BEFORE_NAMESPACE();
namespace volccd::detail::HWY_NAMESPACE {

/// Sum of absolute values.
HWY_INLINE Lanes norm1(const Lanes3& a) {
  const Lanes3 m = abs(a);
  return add3(m.x, m.y, m.z);
}

HWY_INLINE void store3(const Lanes3& a, double* x, std::size_t distance) {
  const Tag tag;
  hn::StoreU(a.x, tag, x);
  hn::StoreU(a.y, tag, x + distance);
  hn::StoreU(a.z, tag, x + 2 * distance);
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
  void gather(const Step& step, const RingFace& face, std::size_t lane) {
    for (std::size_t v = 0; v < 3; ++v) {
      const double* const from = step.motion.at(face.triangle[v]);
      for (std::size_t k = 0; k < 3 * kControlPoints; ++k) points_[v][k][lane] = from[k];
    }
  }

  void store(std::size_t at, FaceNormals& out) const {
    for (std::size_t lane = 0; lane < 8; lane += hn::Lanes(Tag())) store_lanes(lane, at + lane, out);
  }

 private:
  static constexpr int kDegree = kControlPoints - 1;

  Lanes3 point(std::size_t vertex, int control_point, std::size_t lane) const {
    return load3(Tag(), points_[vertex][3 * control_point] + lane, 8);
  }

  void store_lanes(std::size_t lane, std::size_t at, FaceNormals& out) const {
    Lanes3 a[kControlPoints], b[kControlPoints], normal[2 * kDegree + 1];
    Lanes of_a = broadcast(kLeastExtent), of_b = of_a;
    for (int c = 0; c < kControlPoints; ++c) {
      const Lanes3 origin = point(0, c, lane);
      a[c] = sub(point(1, c, lane), origin);
      b[c] = sub(point(2, c, lane), origin);
      of_a = hn::Max(of_a, norm1(a[c]));
      of_b = hn::Max(of_b, norm1(b[c]));
    }
    for (int k = 0; k <= 2 * kDegree; ++k) normal[k] = {hn::Zero(Tag()), hn::Zero(Tag()), hn::Zero(Tag())};
    for (int i = 0; i <= kDegree; ++i)
      for (int j = 0; j <= kDegree; ++j) {
        const double weight = (kDegree == 2 && i == 1 ? 2 : 1) * (kDegree == 2 && j == 1 ? 2 : 1);
        normal[i + j] = add(normal[i + j], scaled(cross(a[i], b[j]), broadcast(weight)));
      }
    for (int k = 0; k <= 2 * kDegree; ++k)
      store3(normal[k], out.rows.data() + static_cast<std::size_t>(3 * k) * out.stride + at, out.stride);
    // The weights of a coefficient sum to at most 6; a term has fewer than 16 rounding errors (docs/boundary_flood.md).
    const Lanes bound = hn::Mul(broadcast(6 * 32 * kUnitRoundoff), trusted(hn::Mul(trusted(of_a), trusted(of_b))));
    hn::StoreU(hn::Add(bound, broadcast(kDeterminantUnderflow)), Tag(),
               out.rows.data() + static_cast<std::size_t>(3 * out.coefficients) * out.stride + at);
    store3(add(unit(normal[0]), unit(normal[2 * kDegree])), out.units.data() + at, out.stride);
  }

  alignas(64) double points_[3][3 * kControlPoints][8] = {};
};

template <int kControlPoints>
void normals_of(const Step& step, std::span<const RingFace> faces, std::size_t begin, std::size_t end,
                FaceNormals& out) {
  Normals<kControlPoints> normals;
  for (std::size_t first = begin; first < end; first += 8) {
    for (std::size_t lane = 0; lane < 8 && first + lane < end; ++lane) normals.gather(step, faces[first + lane], lane);
    normals.store(first, out);
  }
}

void normals_of_faces(const Step& step, std::span<const RingFace> faces, std::size_t begin, std::size_t end,
                      FaceNormals& out) {
  if (step.motion.control_points() == 2) return normals_of<2>(step, faces, begin, end, out);
  normals_of<3>(step, faces, begin, end, out);
}

}  // namespace volccd::detail::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace volccd::detail {

HWY_EXPORT(normals_of_faces);

void face_normals(const Step& step, std::span<const RingFace> faces, std::size_t begin, std::size_t end,
                  FaceNormals& out) {
  HWY_DYNAMIC_DISPATCH(normals_of_faces)(step, faces, begin, end, out);
}

namespace {
constexpr std::size_t kFaceGrain = 512;  // a multiple of 8
constexpr std::size_t kRingGrain = 256;
}  // namespace

void BoundaryRings::set_faces(const Mesh& mesh, std::vector<RingFace> faces) {
  faces_ = std::move(faces);
  ups_.resize(mesh.vertex_count());
  begins_.assign(mesh.vertex_count() + std::size_t{1}, 0);
  const auto visit_corners = [&](auto&& visit) {
    for (std::size_t f = 0; f < faces_.size(); ++f)
      for (unsigned i = 0; i < 4; ++i)
        if (i < 3 || faces_[f].fourth != kNone)
          visit(faces_[f].vertex(i), Corner{static_cast<Index>(f), i < 3, (faces_[f].tested >> i & 1) != 0});
  };
  visit_corners([&](Index v, const Corner&) { ++begins_[v]; });
  Index end = 0;
  for (Index& begin : begins_) begin = end += begin;  // the ends; filling moves them to the beginnings
  corners_.resize(end);
  visit_corners([&](Index v, const Corner& corner) { corners_[--begins_[v]] = corner; });
}

bool BoundaryRings::folds_at(Index v) {
  const std::span<const Corner> corners = std::span(corners_).subspan(begins_[v], begins_[v + 1] - begins_[v]);
  Vec3 up = Vec3::Zero();
  for (const Corner& c : corners)
    if (c.of_triangle)
      for (int axis = 0; axis < 3; ++axis)
        up[axis] += normals_.units[static_cast<std::size_t>(axis) * normals_.stride + c.face];
  ups_[v] = up;
  const double size = std::abs(up[0]) + std::abs(up[1]) + std::abs(up[2]);
  for (const Corner& c : corners) {
    if (!c.tested) continue;
    const double bound = normals_.bounds()[c.face] * size;
    for (int k = 0; k < normals_.coefficients; ++k)
      if (!(up[0] * normals_.row(k, 0)[c.face] + up[1] * normals_.row(k, 1)[c.face] + up[2] * normals_.row(k, 2)[c.face] >
            bound))
        return true;
  }
  return false;
}

void BoundaryRings::find_folds(const Step& step, Executor& executor, std::vector<std::uint8_t>& folds) {
  normals_.coefficients = 2 * step.motion.control_points() - 1;
  normals_.stride = (faces_.size() + 7) / 8 * 8 + 8;
  normals_.rows.resize(static_cast<std::size_t>(3 * normals_.coefficients + 1) * normals_.stride);
  normals_.units.resize(3 * normals_.stride);
  executor.parallel_for(
      (faces_.size() + kFaceGrain - 1) / kFaceGrain, 1, [&](std::size_t begin, std::size_t end, unsigned) {
        face_normals(step, faces_, begin * kFaceGrain, std::min(end * kFaceGrain, faces_.size()), normals_);
      });
  folds.resize(ups_.size());
  executor.parallel_for(folds.size(), kRingGrain, [&](std::size_t begin, std::size_t end, unsigned) {
    for (std::size_t v = begin; v < end; ++v) folds[v] = folds_at(static_cast<Index>(v)) ? 1 : 0;
  });
}

std::size_t BoundaryRings::bytes() const {
  return faces_.capacity() * sizeof(faces_[0]) +
         (normals_.rows.capacity() + normals_.units.capacity()) * sizeof(double) + ups_.capacity() * sizeof(Vec3) +
         begins_.capacity() * sizeof(Index) + corners_.capacity() * sizeof(Corner);
}

}  // namespace volccd::detail
#endif
