// The moving vertices of eight elements as rows of lanes. Included once for each instruction set by foreach_target.h of
// Highway.
#include <cstddef>
#include <span>

#include <volccd/culling/stars/detail/cone_faces.hpp>
#include <volccd/numerics/vector_lanes-inl.hpp>
#include <volccd/query/motion.hpp>

#if defined(VOLCCD_ELEMENT_LANES_INL) == defined(HWY_TARGET_TOGGLE)
#ifdef VOLCCD_ELEMENT_LANES_INL
#undef VOLCCD_ELEMENT_LANES_INL
#else
#define VOLCCD_ELEMENT_LANES_INL
#endif

HWY_BEFORE_NAMESPACE();
namespace volccd::detail::HWY_NAMESPACE {

/// Eight elements of one type.
template <int kControlPoints>
class ElementLanes {
 public:
  using Path = Lanes3[kControlPoints];

  void gather(const Motion& motion, std::span<const Index> vertices, const ConeFaces& faces, std::size_t lane) {
    for (std::size_t v = 0; v < faces.vertices; ++v) {
      const double* const from = motion.at(vertices[v]);
      for (std::size_t k = 0; k < 3 * kControlPoints; ++k) points_[v][k][lane] = from[k];
    }
    for (std::size_t f = 0; f < faces.count; ++f) {
      const ConeFace& face = faces.faces[f];
      if (face.size < 4) continue;
      // The diagonal contains the vertex of smallest slot (mesh/features.hpp).
      std::size_t min = 0;
      for (std::size_t i = 1; i < 4; ++i)
        if (vertices[face.vertices[i]] < vertices[face.vertices[min]]) min = i;
      turned_[f][lane] = min % 2 == 0 ? 0 : 1;
    }
  }

  /// Copies an element from another block.
  void copy_element(const ElementLanes& from, std::size_t lane, std::size_t to) {
    for (std::size_t v = 0; v < 8; ++v)
      for (std::size_t k = 0; k < 3 * kControlPoints; ++k) points_[v][k][to] = from.points_[v][k][lane];
    for (std::size_t f = 0; f < 6; ++f) turned_[f][to] = from.turned_[f][lane];
  }

  HWY_INLINE void load(std::size_t v, std::size_t lane, Path& path) const {
    for (int c = 0; c < kControlPoints; ++c) path[c] = load3(Tag(), points_[v][3 * c] + lane, 8);
  }
  /// For which elements the diagonal of face f does not contain the first vertex of the face.
  HWY_INLINE LaneMask turned(std::size_t f, std::size_t lane) const {
    return hn::Gt(hn::Load(Tag(), turned_[f] + lane), hn::Zero(Tag()));
  }
  /// Loads vertex i of a face, counted from one end of its diagonal.
  HWY_INLINE void load_turned(const ConeFace& face, std::size_t f, std::size_t i, std::size_t lane, Path& path) const {
    load(face.vertices[i], lane, path);
    if (face.size < 4) return;
    const LaneMask other = turned(f, lane);
    Path next;
    load(face.vertices[(i + 1) % 4], lane, next);
    for (int c = 0; c < kControlPoints; ++c) path[c] = select(other, next[c], path[c]);
  }

 private:
  alignas(64) double points_[8][3 * kControlPoints][8] = {};
  alignas(64) double turned_[6][8] = {};
};

}  // namespace volccd::detail::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#endif
