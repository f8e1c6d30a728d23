#include <volccd/culling/stars/detail/cone_signs.hpp>

#include <algorithm>
#include <array>
#include <bit>
#include <cstddef>
#include <span>

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "volccd/culling/stars/detail/cone_signs.cpp"
#include <hwy/foreach_target.h>
#include <volccd/culling/detail/determinant-inl.hpp>
#include <volccd/culling/stars/detail/middle_shape-inl.hpp>
#include <volccd/culling/stars/detail/tetrahedron_signs-inl.hpp>

HWY_BEFORE_NAMESPACE();
namespace volccd::detail::HWY_NAMESPACE {

/// The polynomials of all cones of eight elements of one type.
template <int kControlPoints>
class Cones {
 public:
  explicit Cones(const ElementLanes<kControlPoints>& elements) : elements_(elements) {}

  void signs(const ConeFaces& faces, double separation, ConeSigns (&out)[8]) const {
    for (ConeSigns& s : out) s = {0xff, 0xff};
    for (std::size_t lane = 0; lane < 8; lane += hn::Lanes(Tag()))
      for (std::size_t f = 0; f < faces.count; ++f) over_face(faces, f, separation, lane, out + lane);
  }

 private:
  static constexpr int kDegree = kControlPoints - 1;
  using Path = typename ElementLanes<kControlPoints>::Path;
  using Normal = Lanes3[2 * kDegree + 1];
  /// Sum of the weights of a coefficient, at most.
  static constexpr double kWeights = kControlPoints == 2 ? 3 : 20;
  static constexpr double weight(int i) { return kDegree == 2 && i == 1 ? 2 : 1; }

  static HWY_INLINE Lanes subtract(const Path& from, Path& path) {
    Lanes size = broadcast(kMinExtent);
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

  /// Clears the bits of volumes that are not proven to have the sign. A coefficient has to exceed `rounding` by
  /// `allowance` times its binomial.
  static HWY_INLINE void judge(const Path& way, const Normal& normal, Lanes rounding, Lanes allowance,
                               LaneMask& positive, LaneMask& negative) {
    for (int k = 0; k <= 3 * kDegree; ++k) {
      Lanes sum = hn::Zero(Tag());
      for (int i = std::max(0, k - 2 * kDegree); i <= std::min(k, kDegree); ++i)
        sum = hn::Add(sum, hn::Mul(dot(way[i], normal[k - i]), broadcast(weight(i))));
      const Lanes bound = hn::Add(rounding, hn::Mul(allowance, broadcast(binomial(3 * kDegree, k))));
      positive = hn::And(positive, hn::Gt(sum, bound));
      negative = hn::And(negative, hn::Lt(sum, hn::Neg(bound)));
    }
  }

  static HWY_INLINE Lanes longest(const Path& path) {
    Lanes square = hn::Zero(Tag());
    for (int c = 0; c < kControlPoints; ++c) square = hn::Max(square, dot(path[c], path[c]));
    // The square of a short vector may have lost digits by underflow.
    return hn::Sqrt(hn::Max(square, broadcast(kMinSquare)));
  }
  /// A face as a fan of triangles: edges from one end of its diagonal, and bounds on them.
  struct Fan {
    std::size_t triangles;
    Path from, edge[3];
    Normal normal[2];
    Lanes area[2];    ///< products of 1-norms
    Lanes length[3];  ///< of the edges; with a separation only
  };

  /// Which volumes between the fan and `way` have a sign that no separation d changes (cone_signs()): if they exceed
  /// d times greatest_area(), or if not kExactly, the sum of the products of lengths of three edges.
  template <bool kExactly>
  static HWY_INLINE void judge_apart(const Fan& fan, const Path& way, Lanes extent, double separation,
                                     LaneMask& positive, LaneMask& negative) {
    const Lanes d = broadcast(separation * kAreaSlack * kAreaSlack);
    const Lanes to_corner = longest(way);
    for (std::size_t i = 0; i < fan.triangles; ++i) {
      const Lanes& a = fan.length[i];
      const Lanes& b = fan.length[i + 1];
      const Lanes area = kExactly ? greatest_area(way, fan.edge[i], fan.edge[i + 1])
                                  : hn::Add(hn::Mul(a, b), hn::Mul(to_corner, hn::Add(a, b)));
      judge(way, fan.normal[i], error(extent, fan.area[i]), hn::Mul(d, area), positive, negative);
    }
  }

  HWY_INLINE void load_fan(const ConeFace& face, std::size_t f, double separation, std::size_t lane, Fan& fan) const {
    Lanes size[3];
    elements_.load_turned(face, f, 0, lane, fan.from);
    fan.triangles = face.size - std::size_t{2};
    for (std::size_t i = 0; i <= fan.triangles; ++i) {
      elements_.load_turned(face, f, i + 1, lane, fan.edge[i]);
      size[i] = subtract(fan.from, fan.edge[i]);
      if (separation > 0) fan.length[i] = longest(fan.edge[i]);
    }
    for (std::size_t i = 0; i < fan.triangles; ++i) {
      inward_normal(fan.edge[i], fan.edge[i + 1], fan.normal[i]);
      fan.area[i] = trusted(hn::Mul(trusted(size[i]), trusted(size[i + 1])));
    }
  }

  void over_face(const ConeFaces& faces, std::size_t f, double separation, std::size_t lane, ConeSigns* out) const {
    const ConeFace& face = faces.faces[f];
    Fan fan;
    load_fan(face, f, separation, lane, fan);
    for (std::size_t j = 0; j < face.corner_count; ++j) {
      Path way;
      elements_.load(face.corners[j], lane, way);
      const Lanes extent = subtract(fan.from, way);
      const LaneMask all = hn::Ge(extent, hn::Zero(Tag()));
      LaneMask positive = all, negative = all;
      if (separation > 0) {
        judge_apart<false>(fan, way, extent, separation, positive, negative);
        if (!hn::AllTrue(Tag(), hn::Or(positive, negative))) {
          positive = negative = all;
          judge_apart<true>(fan, way, extent, separation, positive, negative);
        }
      } else {
        for (std::size_t i = 0; i < fan.triangles; ++i)
          judge(way, fan.normal[i], error(extent, fan.area[i]), hn::Zero(Tag()), positive, negative);
      }
      note(positive, negative, 1u << face.corners[j], out);
    }
  }

  static HWY_INLINE void note(LaneMask positive, LaneMask negative, unsigned bits, ConeSigns* out) {
    const std::uint32_t is_positive = mask_bits(Tag(), positive), is_negative = mask_bits(Tag(), negative);
    for (std::size_t i = 0; i < hn::Lanes(Tag()); ++i) {
      if ((is_positive >> i & 1) == 0) out[i].positive &= static_cast<std::uint8_t>(~bits);
      if ((is_negative >> i & 1) == 0) out[i].negative &= static_cast<std::uint8_t>(~bits);
    }
  }

  const ElementLanes<kControlPoints>& elements_;
};

/// Elements of one type that are collected until there are eight, which are then tested together.
template <int kControlPoints>
struct WaitingElements {
  struct Block {
    std::size_t count = 0;
    Index slots[8] = {};
    ElementLanes<kControlPoints> elements;
  };
  const ConeFaces* faces = nullptr;
  Block fresh, open;  ///< before and after the quick test

  void add(const Step& step, Index o, ConeSigns* signs) {
    fresh.elements.gather(step.motion, step.mesh().vertices(o), *faces, fresh.count);
    fresh.slots[fresh.count++] = o;
    if (fresh.count == 8) decide_quickly(step.separation, signs);
  }
  void decide_quickly(double separation, ConeSigns* signs) {
    std::uint32_t positive = 0;  // bit i: proven for all cones of element i by its shape in the middle of the step
    for (std::size_t lane = 0; lane < 8; lane += hn::Lanes(Tag())) {
      const MiddleShape<kControlPoints> shape(fresh.elements, *faces, lane);
      positive |= mask_bits(Tag(), shape.stays_positive(separation)) << lane;
    }
    for (std::size_t i = 0; i < fresh.count; ++i) {
      if ((positive >> i & 1) != 0) {
        signs[fresh.slots[i]] = {bits(), 0};
        continue;
      }
      open.elements.copy_element(fresh.elements, i, open.count);
      open.slots[open.count++] = fresh.slots[i];
      if (open.count == 8) decide(separation, signs);
    }
    fresh.count = 0;
  }
  void decide(double separation, ConeSigns* signs) {
    ConeSigns found[8];
    Cones<kControlPoints>(open.elements).signs(*faces, separation, found);
    for (std::size_t i = 0; i < open.count; ++i)
      signs[open.slots[i]] = {static_cast<std::uint8_t>(found[i].positive & bits()),
                              static_cast<std::uint8_t>(found[i].negative & bits())};
    open.count = 0;
  }
  void finish(double separation, ConeSigns* signs) {
    if (fresh.count > 0) decide_quickly(separation, signs);
    if (open.count > 0) decide(separation, signs);
  }
  std::uint8_t bits() const { return static_cast<std::uint8_t>((1u << faces->vertices) - 1); }
};

/// Sets the signs of the tetrahedra among the elements at [begin, end), at most eight. Returns their bits.
template <int kControlPoints>
std::uint32_t signs_of_tetrahedra(const Step& step, Index begin, Index end, TetrahedronSigns<kControlPoints>& found,
                                  ConeSigns* signs) {
  std::array<std::array<Index, 4>, 8> tetrahedra{};
  std::uint32_t given = 0;
  for (Index k = 0; k < end - begin; ++k) {
    if (step.mesh().type(begin + k) != ElementType::tetrahedron) continue;
    std::copy_n(step.topology.adjacency().vertices(begin + k).begin(), 4, tetrahedra[k].begin());
    given |= 1u << k;
  }
  if (given == 0) return given;
  found.find(step.motion, tetrahedra, step.separation);
  const auto all_bits = [](std::uint32_t found_bits, Index k) {
    return static_cast<std::uint8_t>((found_bits >> k & 1) * 0xf);
  };
  for (Index k = 0; k < end - begin; ++k) signs[begin + k] = {all_bits(found.positive, k), all_bits(found.negative, k)};
  return given;
}

template <int kControlPoints>
void signs_of_cones(const Step& step, Index begin, Index end, ConeSigns* signs) {
  TetrahedronSigns<kControlPoints> tetrahedra;
  WaitingElements<kControlPoints> waiting[3];
  std::uint32_t done = 0;  // bit k: element k of the present eight is a tetrahedron
  for (Index o = begin; o < end; ++o, done >>= 1) {
    if ((o - begin) % 8 == 0) {
      done = signs_of_tetrahedra(step, o, std::min(o + 8, end), tetrahedra, signs);
      if (done == 0xff) {
        o += 7;
        continue;
      }
    }
    if ((done & 1) != 0) continue;
    const ElementType type = step.mesh().type(o);
    const auto all = static_cast<std::uint8_t>((1u << vertex_count(type)) - 1);
    signs[o] = is_shell(type) ? ConeSigns{all, all} : ConeSigns{};
    const ConeFaces* const faces = cone_faces(type);
    if (!faces) continue;
    auto* list = waiting;
    while (list->faces && list->faces != faces) ++list;
    list->faces = faces;
    list->add(step, o, signs);
  }
  for (auto& list : waiting) list.finish(step.separation, signs);
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
