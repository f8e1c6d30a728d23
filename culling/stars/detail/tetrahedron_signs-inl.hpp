// Signs of the volumes of eight tetrahedra throughout a step. Included once for each instruction set by
// foreach_target.h of Highway.
#include <array>
#include <cstdint>
#include <span>

#include <volccd/culling/detail/determinant-inl.hpp>
#include <volccd/query/vertex_records-inl.hpp>

#if defined(VOLCCD_TETRAHEDRON_SIGNS_INL) == defined(HWY_TARGET_TOGGLE)
#ifdef VOLCCD_TETRAHEDRON_SIGNS_INL
#undef VOLCCD_TETRAHEDRON_SIGNS_INL
#else
#define VOLCCD_TETRAHEDRON_SIGNS_INL
#endif

HWY_BEFORE_NAMESPACE();
namespace volccd::detail::HWY_NAMESPACE {

/// Eight tetrahedra; the rows are as in TestBlock, 8 doubles apart.
template <int kControlPoints>
class TetrahedronSigns {
 public:
  /// Bit k of `positive` or `negative` is set if the volume det(v1 - v0, v2 - v0, v3 - v0) of tetrahedron k is proven
  /// to have this sign at all t in [0, 1], with a separation for displaced vertices, too.
  void find(const Motion& motion, std::span<const std::array<Index, 4>, 8> tetrahedra, double separation) {
    gather_tests<8, kControlPoints>(motion, tetrahedra, rows_);
    positive = negative = 0;
    for (std::size_t lane = 0; lane < 8; lane += hn::Lanes(Tag())) {
      const DeterminantSigns found = signs_at(lane, separation);
      positive |= mask_bits(Tag(), found.positive) << lane;
      negative |= mask_bits(Tag(), found.negative) << lane;
    }
  }

  std::uint32_t positive = 0, negative = 0;

 private:
  HWY_INLINE DeterminantSigns signs_at(std::size_t lane, double separation) const {
    const Differences<kControlPoints> e(Columns<8>{rows_ + lane}, StepInterval(1, kControlPoints));
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

  alignas(64) double rows_[12 * kControlPoints * 8] = {};
};

}  // namespace volccd::detail::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#endif
