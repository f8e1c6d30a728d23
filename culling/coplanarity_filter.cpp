#include <volccd/culling/coplanarity_filter.hpp>

#include <limits>

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "volccd/culling/coplanarity_filter.cpp"
#include <hwy/foreach_target.h>
#include <volccd/culling/detail/filter_lanes-inl.hpp>

HWY_BEFORE_NAMESPACE();
namespace volccd::detail::HWY_NAMESPACE {

constexpr double binomial(int n, int k) { return k == 0 ? 1 : binomial(n - 1, k - 1) * n / k; }

/// Bernstein coefficients of det(e0, e1, e2)(t), each times binomial(degree, k).
template <int kControlPoints>
struct Determinant {
  static constexpr int kDegree = 3 * (kControlPoints - 1);
  Lanes coefficients[kDegree + 1];

  HWY_INLINE explicit Determinant(const Lanes3 (&e)[3][kControlPoints]) {
    constexpr int n = kControlPoints - 1;
    Lanes3 normal[2 * n + 1];
    bool begun[kDegree + 1] = {};
    for (int i = 0; i <= n; ++i)
      for (int j = 0; j <= n; ++j) {
        const Lanes3 part = weighted(cross(e[1][i], e[2][j]), binomial(n, i) * binomial(n, j));
        normal[i + j] = i == 0 || j == n ? part : add(normal[i + j], part);
      }
    for (int i = 0; i <= n; ++i)
      for (int k = 0; k <= 2 * n; ++k) {
        const Lanes part = dot(weighted(e[0][i], binomial(n, i)), normal[k]);
        coefficients[i + k] = begun[i + k] ? hn::Add(coefficients[i + k], part) : part;
        begun[i + k] = true;
      }
  }

 private:
  static HWY_INLINE Lanes3 weighted(const Lanes3& a, double weight) {
    return weight == 1 ? a : scaled(a, broadcast(weight));
  }
};

/// Bound, over the whole step, of the area that turns a distance into a determinant: the product of the lengths of two
/// sides of the triangle (VF), of both edges (EE).
template <int kControlPoints>
HWY_INLINE Lanes greatest_area(bool vf, BlockColumns tests) {
  Lanes first = hn::Zero(Tag()), second = first;
  for (int c = 0; c < kControlPoints; ++c) {
    first = hn::Max(first, length(sub(load(tests, c, vf ? 2 : 1), load(tests, c, vf ? 1 : 0))));
    second = hn::Max(second, length(sub(load(tests, c, 3), load(tests, c, vf ? 1 : 2))));
  }
  // An infinite length times one of zero would be NaN, which a maximum may lose.
  const Lanes least = broadcast(kLeastExtent);
  return hn::Max(hn::Mul(hn::Max(first, least), hn::Max(second, least)), broadcast(kLeastSquare));
}

/// Bound of the determinant's error, or infinity where it could overflow; the parts without and with a binomial factor.
struct ErrorBound {
  Lanes fixed, scaled;

  HWY_INLINE ErrorBound(const Lanes3 (&extent)[3], double factor) {
    const Lanes3 a = trusted(extent[0]), b = trusted(extent[1]), c = trusted(extent[2]);
    const Lanes x = hn::Add(hn::Mul(b.y, c.z), hn::Mul(b.z, c.y)), y = hn::Add(hn::Mul(b.z, c.x), hn::Mul(b.x, c.z)),
                z = hn::Add(hn::Mul(b.x, c.y), hn::Mul(b.y, c.x));
    const Lanes permanent = add3(hn::Mul(a.x, x), hn::Mul(a.y, y), hn::Mul(a.z, z));
    // The areas count, too: their sums may overflow where a small `a` keeps the permanent in range.
    const auto in_range = hn::Lt(add3(x, y, z), broadcast(kGreatestMagnitude));
    const Lanes infinite = broadcast(std::numeric_limits<double>::infinity());
    scaled = hn::Mul(hn::IfThenElse(in_range, trusted(permanent), infinite), broadcast(factor));
    fixed = hn::Mul(broadcast(kDeterminantUnderflow), hn::Add(broadcast(1), add3(a.x, a.y, a.z)));
  }
};

template <int kControlPoints>
HWY_INLINE LaneMask never_coplanar(bool vf, BlockColumns tests, double separation, const StepPart& part) {
  using Polynomial = Determinant<kControlPoints>;
  const Differences<kControlPoints> e(tests, part);
  ErrorBound error(e.extent, determinant_error_factor(kControlPoints, part.levels));
  if (separation > 0) {
    const Lanes area = greatest_area<kControlPoints>(vf, tests);
    error.scaled = hn::Add(error.scaled, hn::Mul(broadcast(separation * kAreaSlack), area));
  }
  const Polynomial det(e.at);
  LaneMask above = hn::Gt(det.coefficients[0], hn::Add(error.scaled, error.fixed));
  LaneMask below = hn::Lt(det.coefficients[0], hn::Neg(hn::Add(error.scaled, error.fixed)));
  for (int k = 1; k <= Polynomial::kDegree; ++k) {
    const Lanes bound = hn::Add(hn::Mul(error.scaled, broadcast(binomial(Polynomial::kDegree, k))), error.fixed);
    above = hn::And(above, hn::Gt(det.coefficients[k], bound));
    below = hn::And(below, hn::Lt(det.coefficients[k], hn::Neg(bound)));
  }
  return hn::Or(above, below);
}

template <int kControlPoints>
void filter_block(const TestBlock& block, double separation, const StepPart& part, std::span<std::uint8_t> keep) {
  drop_tests(block, keep, [&](auto tests) HWY_ATTR {
    return never_coplanar<kControlPoints>(block.kind() == FeatureKind::vf, tests, separation, part);
  });
}

void coplanarity(const TestBlock& block, double separation, double t_max, std::span<std::uint8_t> keep) {
  const StepPart part(t_max, block.control_points());
  if (block.control_points() == 2) filter_block<2>(block, separation, part, keep);
  if (block.control_points() == 3) filter_block<3>(block, separation, part, keep);
}

}  // namespace volccd::detail::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace volccd {
namespace detail {
HWY_EXPORT(coplanarity);
}

const Options<CoplanarityFilter::Config>& CoplanarityFilter::options() {
  static const Options<Config> options;
  return options;
}

void CoplanarityFilter::run(const Step& step, StageState&, unsigned, const TestBlock& block,
                            std::span<std::uint8_t> keep) const {
  using namespace detail;
  HWY_DYNAMIC_DISPATCH(coplanarity)(block, step.separation, step.t_max, keep);
}

StageDescriptor<FeatureFilter> describe_coplanarity_filter() {
  return describe_stage<FeatureFilter, CoplanarityFilter>(
      "coplanarity", "four points that are never coplanar (Tang et al. 2010)", Guarantee::conservative);
}

}  // namespace volccd
#endif
