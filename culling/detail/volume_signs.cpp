#include <volccd/culling/detail/volume_signs.hpp>

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "volccd/culling/detail/volume_signs.cpp"
#include <hwy/foreach_target.h>
#include <volccd/culling/detail/determinant-inl.hpp>

HWY_BEFORE_NAMESPACE();
namespace volccd::detail::HWY_NAMESPACE {

/// Processes 8 elements; the rows are as in TestBlock, 8 doubles apart.
template <int kControlPoints>
struct Volumes {
  alignas(64) double rows[12 * kControlPoints * 8] = {};

  void gather(const Step& step, Index element, std::size_t lane) {
    const std::span<const Index> vertices = step.topology.adjacency().vertices(element);
    for (std::size_t v = 0; v < 4; ++v) {
      const double* const from = step.motion.at(vertices[v]);
      for (std::size_t c = 0; c < kControlPoints; ++c)
        for (std::size_t axis = 0; axis < 3; ++axis) rows[((c * 4 + v) * 3 + axis) * 8 + lane] = from[3 * c + axis];
    }
  }

  void signs(std::uint8_t& positive, std::uint8_t& negative) const {
    const Tag tag;
    positive = negative = 0;
    for (std::size_t lane = 0; lane < 8; lane += hn::Lanes(tag)) {
      const Differences<kControlPoints> e(Columns<8>{rows + lane}, StepPart(1, kControlPoints));
      const DeterminantSigns found(Determinant<kControlPoints>(e.at),
                                   DeterminantError(e.extent, determinant_error_factor(kControlPoints, 0)));
      std::uint8_t bits[8] = {};
      hn::StoreMaskBits(tag, found.positive, bits);
      positive |= static_cast<std::uint8_t>(bits[0] << lane);
      bits[0] = 0;
      hn::StoreMaskBits(tag, found.negative, bits);
      negative |= static_cast<std::uint8_t>(bits[0] << lane);
    }
  }
};

template <int kControlPoints>
void signs_of(const Step& step, Index begin, Index end, std::int8_t* signs) {
  Volumes<kControlPoints> volumes;
  const Mesh& mesh = step.mesh();
  for (Index first = begin; first < end; first += 8) {
    const Index count = std::min<Index>(8, end - first);
    for (Index k = 0; k < count; ++k)
      if (mesh.type(first + k) == ElementType::tetrahedron) volumes.gather(step, first + k, k);
    std::uint8_t positive, negative;
    volumes.signs(positive, negative);
    for (Index k = 0; k < count; ++k)
      signs[first + k] = mesh.type(first + k) != ElementType::tetrahedron
                             ? std::int8_t{1}
                             : static_cast<std::int8_t>((positive >> k & 1) - (negative >> k & 1));
  }
}

void signs_of_volumes(const Step& step, Index begin, Index end, std::int8_t* signs) {
  if (step.motion.control_points() == 2) return signs_of<2>(step, begin, end, signs);
  signs_of<3>(step, begin, end, signs);
}

}  // namespace volccd::detail::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace volccd::detail {

HWY_EXPORT(signs_of_volumes);

void volume_signs(const Step& step, Index begin, Index end, std::int8_t* signs) {
  HWY_DYNAMIC_DISPATCH(signs_of_volumes)(step, begin, end, signs);
}

}  // namespace volccd::detail
#endif
