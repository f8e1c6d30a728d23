#include <volccd/culling/detail/volume_signs.hpp>

#include <algorithm>
#include <array>

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "volccd/culling/detail/volume_signs.cpp"
#include <hwy/foreach_target.h>
#include <volccd/culling/detail/determinant-inl.hpp>
#include <volccd/query/vertex_records-inl.hpp>

HWY_BEFORE_NAMESPACE();
namespace volccd::detail::HWY_NAMESPACE {

/// Processes 8 elements; the rows are as in TestBlock, 8 doubles apart.
template <int kControlPoints>
struct Volumes {
  alignas(64) double rows[12 * kControlPoints * 8] = {};

  void signs(double separation, std::uint32_t& positive, std::uint32_t& negative) const {
    positive = negative = 0;
    for (std::size_t lane = 0; lane < 8; lane += hn::Lanes(Tag())) {
      const DeterminantSigns found = signs_at(lane, separation);
      positive |= mask_bits(Tag(), found.positive) << lane;
      negative |= mask_bits(Tag(), found.negative) << lane;
    }
  }

 private:
  HWY_INLINE DeterminantSigns signs_at(std::size_t lane, double separation) const {
    const Differences<kControlPoints> e(Columns<8>{rows + lane}, StepPart(1, kControlPoints));
    const Determinant<kControlPoints> det(e.at);
    const DeterminantError rounding(e.extent, determinant_error_factor(kControlPoints, 0));
    if (separation == 0) return {det, rounding};
    // First with an upper bound of greatest_area(), which is sufficient for most tetrahedra.
    const Lanes d = broadcast(separation * kAreaSlack * kAreaSlack);
    const Lanes a = length(e.extent[0]), b = length(e.extent[1]), c = length(e.extent[2]);
    DeterminantError error = rounding;
    error.scaled = hn::Add(error.scaled, hn::Mul(d, add3(hn::Mul(a, b), hn::Mul(b, c), hn::Mul(c, a))));
    const DeterminantSigns found(det, error);
    if (hn::AllTrue(Tag(), hn::Or(found.positive, found.negative))) return found;
    error.scaled = hn::Add(rounding.scaled, hn::Mul(d, greatest_area(e.at[0], e.at[1], e.at[2])));
    return {det, error};
  }
};

template <int kControlPoints>
void signs_of(const Step& step, std::size_t begin, std::size_t end, std::int8_t* signs) {
  Volumes<kControlPoints> volumes;
  for (std::size_t first = begin; first < end; first += 8) {
    const std::size_t count = std::min<std::size_t>(8, end - first);
    std::uint32_t given = 0, positive, negative;
    std::array<std::array<Index, 4>, 8> tetrahedra{};
    for (std::size_t k = 0; k < count; ++k) {
      const Index o = static_cast<Index>(first + k);
      if (step.mesh().type(o) != ElementType::tetrahedron) continue;
      std::copy_n(step.topology.adjacency().vertices(o).begin(), 4, tetrahedra[k].begin());
      given |= 1u << k;
    }
    if (given == 0) {
      std::fill_n(signs + first, count, std::int8_t{1});
      continue;
    }
    gather_tests<8, kControlPoints>(step.motion, tetrahedra, volumes.rows);
    volumes.signs(step.separation, positive, negative);
    for (std::size_t k = 0; k < count; ++k)
      signs[first + k] =
          (given >> k & 1) == 0 ? std::int8_t{1} : static_cast<std::int8_t>((positive >> k & 1) - (negative >> k & 1));
  }
}

void signs_of_elements(const Step& step, Index begin, Index end, std::int8_t* signs) {
  (step.motion.control_points() == 2 ? signs_of<2> : signs_of<3>)(step, begin, end, signs);
}

}  // namespace volccd::detail::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace volccd::detail {

HWY_EXPORT(signs_of_elements);

void volume_signs(const Step& step, Index begin, Index end, std::int8_t* signs) {
  HWY_DYNAMIC_DISPATCH(signs_of_elements)(step, begin, end, signs);
}

}  // namespace volccd::detail
#endif
