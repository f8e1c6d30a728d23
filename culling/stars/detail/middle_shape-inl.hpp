// Elements in the middle of a step, and how far they move from there, which proves for most elements that their volumes
// keep their signs.
// Included once for each instruction set by foreach_target.h of Highway.
#include <cstddef>
#include <limits>

#include <volccd/culling/stars/detail/element_lanes-inl.hpp>

#if defined(VOLCCD_MIDDLE_SHAPE_INL) == defined(HWY_TARGET_TOGGLE)
#ifdef VOLCCD_MIDDLE_SHAPE_INL
#undef VOLCCD_MIDDLE_SHAPE_INL
#else
#define VOLCCD_MIDDLE_SHAPE_INL
#endif

HWY_BEFORE_NAMESPACE();
namespace volccd::detail::HWY_NAMESPACE {

/// Elements in the middle of the step, and how far their vertices move from there if the translation of the whole
/// element is left out. One element in each lane from `lane` on.
template <int kControlPoints>
class MiddleShape {
  using Elements = ElementLanes<kControlPoints>;
  using Path = typename Elements::Path;

 public:
  HWY_INLINE MiddleShape(const Elements& elements, const ConeFaces& faces, std::size_t lane)
      : elements_(elements), faces_(faces), lane_(lane) {
    const Lanes share = broadcast(1.0 / faces.vertices), half = broadcast(0.5);
    Path base, shift;
    elements.load(0, lane, base);
    for (Lanes3& s : shift) s = {hn::Zero(Tag()), hn::Zero(Tag()), hn::Zero(Tag())};
    for (std::size_t v = 0; v < faces.vertices; ++v) {
      Path path;
      load_from(base, v, path);
      at_[v] = scaled(add(path[0], path[kControlPoints - 1]), half);
      for (int c = 0; c < kControlPoints; ++c) shift[c] = add(shift[c], scaled(sub(path[c], at_[v]), share));
    }
    Lanes away = hn::Zero(Tag()), sum = away;
    const Lanes infinity = broadcast(std::numeric_limits<double>::infinity()), minus = hn::Neg(infinity);
    Lanes3 low{infinity, infinity, infinity}, high{minus, minus, minus};
    for (std::size_t v = 0; v < faces.vertices; ++v) {
      Path path;
      load_from(base, v, path);
      low = {hn::Min(low.x, at_[v].x), hn::Min(low.y, at_[v].y), hn::Min(low.z, at_[v].z)};
      high = max(high, at_[v]);
      for (int c = 0; c < kControlPoints; ++c) {
        const Lanes3 moved = sub(sub(path[c], at_[v]), shift[c]);
        const Lanes square = dot(moved, moved);
        away = hn::Max(away, square);
        sum = hn::Add(sum, square);
      }
    }
    // The maximum may discard NaN, which a difference of infinite coordinates is. The sum does not.
    away = hn::IfThenElse(hn::Lt(sum, infinity), away, infinity);
    away_ = hn::Mul(broadcast(kAreaSlack), hn::Sqrt(hn::Add(away, broadcast(kMinSquare))));
    const Lanes3 box = sub(high, low);
    const Lanes3 areas{hn::Mul(box.y, box.z), hn::Mul(box.z, box.x), hn::Mul(box.x, box.y)};
    size_ = hn::Mul(broadcast(kAreaSlack), hn::Sqrt(hn::Add(dot(box, box), broadcast(kMinSquare))));
    three_areas_ = hn::Mul(broadcast(3 * kAreaSlack), hn::Sqrt(hn::Add(dot(areas, areas), broadcast(kMinSquare))));
  }

  /// Whether all tetrahedra of all cones are proven to have a positive volume at all t in [0, 1], with a separation
  /// also for displaced vertices (cone_signs()). False if an overflow is possible.
  ///
  /// If vertices are displaced by at most d each, a volume changes by at most d times the sum of the areas of its four
  /// faces, plus 12 d^2 size + 8 d^3 (docs/clear_stars.md). No area of a triangle is greater than that in the box.
  HWY_INLINE LaneMask stays_positive(double separation) const {
    const Lanes d = hn::Add(away_, broadcast(separation / 2)), whole = hn::Add(size_, d);
    const Lanes more = hn::Mul(hn::Mul(d, d), hn::Add(hn::Mul(broadcast(12), size_), hn::Mul(broadcast(8), d)));
    const Lanes rounding = hn::Mul(broadcast(0x1p-40), hn::Mul(whole, hn::Mul(whole, whole)));
    const Lanes rest = add3(more, rounding, broadcast(kDeterminantUnderflow));
    LaneMask all = hn::Lt(rest, broadcast(kGreatestMagnitude));
    for (std::size_t f = 0; f < faces_.count; ++f) {
      const ConeFace& face = faces_.faces[f];
      Lanes3 edge[3], normal[2];
      Lanes bound[2];
      const Lanes3 from = corner(face, f, 0);
      const std::size_t triangles = face.size - std::size_t{2};
      for (std::size_t i = 0; i <= triangles; ++i) edge[i] = sub(corner(face, f, i + 1), from);
      for (std::size_t i = 0; i < triangles; ++i) {
        normal[i] = cross(edge[i + 1], edge[i]);
        const Lanes area = hn::Sqrt(dot(normal[i], normal[i]));
        bound[i] = hn::Add(hn::Mul(d, hn::Add(area, three_areas_)), rest);
      }
      for (std::size_t j = 0; j < face.corner_count; ++j) {
        const Lanes3 way = sub(at_[face.corners[j]], from);
        for (std::size_t i = 0; i < triangles; ++i) all = hn::And(all, hn::Gt(dot(way, normal[i]), bound[i]));
      }
    }
    return all;
  }

 private:
  HWY_INLINE void load_from(const Path& base, std::size_t v, Path& path) const {
    elements_.load(v, lane_, path);
    for (int c = 0; c < kControlPoints; ++c) path[c] = sub(path[c], base[c]);
  }
  /// Vertex i of a face, counted from one end of its diagonal.
  HWY_INLINE Lanes3 corner(const ConeFace& face, std::size_t f, std::size_t i) const {
    const Lanes3& here = at_[face.vertices[i]];
    if (face.size < 4) return here;
    return select(elements_.turned(f, lane_), at_[face.vertices[(i + 1) % 4]], here);
  }

  const Elements& elements_;
  const ConeFaces& faces_;
  const std::size_t lane_;
  Lanes3 at_[8];
  Lanes size_, three_areas_, away_;
};

}  // namespace volccd::detail::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#endif
