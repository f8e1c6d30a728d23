#include <volccd/culling/detail/cone_signs.hpp>

#include <algorithm>
#include <array>
#include <bit>
#include <cstddef>
#include <span>

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "volccd/culling/detail/cone_signs.cpp"
#include <hwy/foreach_target.h>
#include <volccd/query/vector_lanes-inl.hpp>

#ifndef VOLCCD_CONE_SIGNS_FACES
#define VOLCCD_CONE_SIGNS_FACES
namespace volccd::detail {

/// A face, and the corners of the element that are not on it, as local vertex numbers.
struct ConeFace {
  std::uint8_t size = 0, corner_count = 0;
  std::array<std::uint8_t, 4> vertices{}, corners{};
};
struct ConeFaces {
  std::uint8_t vertices = 0, count = 0;
  std::array<ConeFace, 6> faces{};
};

inline ConeFaces make_cone_faces(ElementType type) {
  ConeFaces found;
  found.vertices = static_cast<std::uint8_t>(vertex_count(type));
  volccd::visit_faces(face_stream(type), [&](std::span<const std::uint8_t> vertices) {
    ConeFace& face = found.faces[found.count++];
    face.size = static_cast<std::uint8_t>(vertices.size());
    std::copy(vertices.begin(), vertices.end(), face.vertices.begin());
    for (std::uint8_t v = 0; v < found.vertices; ++v)
      if (std::find(vertices.begin(), vertices.end(), v) == vertices.end()) face.corners[face.corner_count++] = v;
  });
  return found;
}

/// Null for types without cones. All cones of a tetrahedron are the tetrahedron, so that one of its faces is enough.
inline const ConeFaces* cone_faces(ElementType type) {
  static const ConeFaces hexahedron = make_cone_faces(ElementType::hexahedron),
                         wedge = make_cone_faces(ElementType::wedge), pyramid = make_cone_faces(ElementType::pyramid),
                         tetrahedron = [] {
                           ConeFaces faces = make_cone_faces(ElementType::tetrahedron);
                           faces.count = 1;
                           return faces;
                         }();
  switch (type) {
    case ElementType::hexahedron: return &hexahedron;
    case ElementType::wedge: return &wedge;
    case ElementType::pyramid: return &pyramid;
    case ElementType::tetrahedron: return &tetrahedron;
    default: return nullptr;
  }
}

}  // namespace volccd::detail
#endif

HWY_BEFORE_NAMESPACE();
namespace volccd::detail::HWY_NAMESPACE {

/// Processes 8 elements of one type.
template <int kControlPoints>
class Cones {
 public:
  void gather(const Motion& motion, std::span<const Index> vertices, const ConeFaces& faces, std::size_t lane) {
    for (std::size_t v = 0; v < faces.vertices; ++v) {
      const double* const from = motion.at(vertices[v]);
      for (std::size_t k = 0; k < 3 * kControlPoints; ++k) points_[v][k][lane] = from[k];
    }
    for (std::size_t f = 0; f < faces.count; ++f) {
      const ConeFace& face = faces.faces[f];
      if (face.size < 4) continue;
      // The diagonal contains the vertex of smallest slot (mesh/features.hpp).
      std::size_t least = 0;
      for (std::size_t i = 1; i < 4; ++i)
        if (vertices[face.vertices[i]] < vertices[face.vertices[least]]) least = i;
      turned_[f][lane] = least % 2 == 0 ? 0 : 1;
    }
  }

  void signs(const ConeFaces& faces, ConeSigns (&out)[8]) const {
    for (ConeSigns& s : out) s = {0xff, 0xff};
    for (std::size_t lane = 0; lane < 8; lane += hn::Lanes(Tag()))
      for (std::size_t f = 0; f < faces.count; ++f) over_face(faces, f, lane, out + lane);
  }

 private:
  static constexpr int kDegree = kControlPoints - 1;
  using Path = Lanes3[kControlPoints];
  using Normal = Lanes3[2 * kDegree + 1];
  /// Sum of the weights of a coefficient, at most.
  static constexpr double kWeights = kControlPoints == 2 ? 3 : 20;
  static constexpr double weight(int i) { return kDegree == 2 && i == 1 ? 2 : 1; }

  HWY_INLINE void load(std::size_t v, std::size_t lane, Path& path) const {
    for (int c = 0; c < kControlPoints; ++c) path[c] = load3(Tag(), points_[v][3 * c] + lane, 8);
  }
  static HWY_INLINE Lanes subtract(const Path& from, Path& path) {
    Lanes size = broadcast(kLeastExtent);
    for (int c = 0; c < kControlPoints; ++c) {
      path[c] = sub(path[c], from[c]);
      size = hn::Max(size, norm1(path[c]));
    }
    return size;
  }
  /// Coefficients, times their binomials, of the cross product; inward if a and b follow each other as the face does.
  static HWY_INLINE void inward_normal(const Path& a, const Path& b, Normal& normal) {
    for (int k = 0; k <= 2 * kDegree; ++k) normal[k] = {hn::Zero(Tag()), hn::Zero(Tag()), hn::Zero(Tag())};
    for (int i = 0; i <= kDegree; ++i)
      for (int j = 0; j <= kDegree; ++j)
        normal[i + j] = add(normal[i + j], scaled(cross(b[i], a[j]), broadcast(weight(i) * weight(j))));
  }

  /// A term of a coefficient is a product of three differences with fewer than 16 roundings in all.
  static HWY_INLINE Lanes error(Lanes extent, Lanes area) {
    const Lanes size = trusted(hn::Mul(trusted(extent), area));
    return hn::Add(hn::Mul(broadcast(kWeights * 32 * kUnitRoundoff), size),
                   hn::Mul(broadcast(kDeterminantUnderflow), hn::Add(broadcast(1), extent)));
  }

  static HWY_INLINE void judge(const Path& way, const Normal& normal, Lanes bound, LaneMask& positive,
                               LaneMask& negative) {
    for (int k = 0; k <= 3 * kDegree; ++k) {
      Lanes sum = hn::Zero(Tag());
      for (int i = std::max(0, k - 2 * kDegree); i <= std::min(k, kDegree); ++i)
        sum = hn::Add(sum, hn::Mul(dot(way[i], normal[k - i]), broadcast(weight(i))));
      positive = hn::And(positive, hn::Gt(sum, bound));
      negative = hn::And(negative, hn::Lt(sum, hn::Neg(bound)));
    }
  }

  /// Loads vertex i of a face, counted from one end of its diagonal.
  HWY_INLINE void load_turned(const ConeFace& face, std::size_t f, std::size_t i, std::size_t lane, Path& path) const {
    load(face.vertices[i], lane, path);
    if (face.size < 4) return;
    const LaneMask turned = hn::Gt(hn::Load(Tag(), turned_[f] + lane), hn::Zero(Tag()));
    Path next;
    load(face.vertices[(i + 1) % 4], lane, next);
    for (int c = 0; c < kControlPoints; ++c)
      path[c] = {hn::IfThenElse(turned, next[c].x, path[c].x), hn::IfThenElse(turned, next[c].y, path[c].y),
                 hn::IfThenElse(turned, next[c].z, path[c].z)};
  }

  void over_face(const ConeFaces& faces, std::size_t f, std::size_t lane, ConeSigns* out) const {
    const ConeFace& face = faces.faces[f];
    Path from, edge[3];
    Normal normal[2];
    Lanes area[2], size[3];
    load_turned(face, f, 0, lane, from);
    const std::size_t triangles = face.size - std::size_t{2};
    for (std::size_t i = 0; i <= triangles; ++i) {
      load_turned(face, f, i + 1, lane, edge[i]);
      size[i] = subtract(from, edge[i]);
    }
    for (std::size_t i = 0; i < triangles; ++i) {
      inward_normal(edge[i], edge[i + 1], normal[i]);
      area[i] = trusted(hn::Mul(trusted(size[i]), trusted(size[i + 1])));
    }
    for (std::size_t j = 0; j < face.corner_count; ++j) {
      Path way;
      load(face.corners[j], lane, way);
      const Lanes extent = subtract(from, way);
      LaneMask positive = hn::Ge(extent, hn::Zero(Tag())), negative = positive;
      for (std::size_t i = 0; i < triangles; ++i) judge(way, normal[i], error(extent, area[i]), positive, negative);
      note(positive, negative, faces.vertices == 4 ? 0xf : 1u << face.corners[j], out);
    }
  }

  static HWY_INLINE void note(LaneMask positive, LaneMask negative, unsigned bits, ConeSigns* out) {
    std::uint8_t is_positive[8] = {}, is_negative[8] = {};
    hn::StoreMaskBits(Tag(), positive, is_positive);
    hn::StoreMaskBits(Tag(), negative, is_negative);
    for (std::size_t i = 0; i < hn::Lanes(Tag()); ++i) {
      if ((is_positive[0] >> i & 1) == 0) out[i].positive &= static_cast<std::uint8_t>(~bits);
      if ((is_negative[0] >> i & 1) == 0) out[i].negative &= static_cast<std::uint8_t>(~bits);
    }
  }

  alignas(64) double points_[8][3 * kControlPoints][8] = {};
  alignas(64) double turned_[6][8] = {};
};

/// Elements of one type that are collected until there are eight, which are then tested together.
template <int kControlPoints>
struct WaitingElements {
  const ConeFaces* faces = nullptr;
  std::size_t count = 0;
  Index slots[8] = {};
  Cones<kControlPoints> cones;

  void add(const Step& step, Index o, ConeSigns* signs) {
    cones.gather(step.motion, step.mesh().vertices(o), *faces, count);
    slots[count++] = o;
    if (count == 8) finish(signs);
  }
  void finish(ConeSigns* signs) {
    if (count == 0) return;
    ConeSigns found[8];
    cones.signs(*faces, found);
    const auto bits = static_cast<std::uint8_t>((1u << faces->vertices) - 1);
    for (std::size_t i = 0; i < count; ++i)
      signs[slots[i]] = {static_cast<std::uint8_t>(found[i].positive & bits),
                         static_cast<std::uint8_t>(found[i].negative & bits)};
    count = 0;
  }
};

template <int kControlPoints>
void signs_of_cones(const Step& step, Index begin, Index end, ConeSigns* signs) {
  WaitingElements<kControlPoints> waiting[4];
  for (Index o = begin; o < end; ++o) {
    signs[o] = {};
    const ConeFaces* const faces = cone_faces(step.mesh().type(o));
    if (!faces) continue;
    auto* list = waiting;
    while (list->faces && list->faces != faces) ++list;
    list->faces = faces;
    list->add(step, o, signs);
  }
  for (auto& list : waiting) list.finish(signs);
}

void signs_of_all_cones(const Step& step, Index begin, Index end, ConeSigns* signs) {
  if (step.motion.control_points() == 2) return signs_of_cones<2>(step, begin, end, signs);
  signs_of_cones<3>(step, begin, end, signs);
}

}  // namespace volccd::detail::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace volccd::detail {

HWY_EXPORT(signs_of_all_cones);

void cone_signs(const Step& step, Index begin, Index end, ConeSigns* signs) {
  HWY_DYNAMIC_DISPATCH(signs_of_all_cones)(step, begin, end, signs);
}

}  // namespace volccd::detail
#endif
