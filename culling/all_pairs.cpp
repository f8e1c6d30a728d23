#include <volccd/culling/all_pairs.hpp>

#include <algorithm>

#include <volccd/culling/detail/assignment_pairs.hpp>
#include <volccd/culling/detail/assignment_state.hpp>

namespace volccd {

namespace {

constexpr auto kAny = [](std::span<const Index>) { return true; };

bool contains(std::span<const Index> values, Index value) {
  return std::find(values.begin(), values.end(), value) != values.end();
}

/// A pair of features that both belong to both elements comes twice; the second time is left out. Both times the masks
/// apply: either says that the features do not touch.
void adjacent_tests(const Step& step, ElementPair pair, const FeatureMask& mask, detail::TestWriter& out) {
  const Features& features = step.features();
  const std::span<const Index> vertices_b = step.mesh().vertices(pair.b), vertices_a = step.mesh().vertices(pair.a);
  const auto both_have = [&](Index v, Index f) {
    return contains(vertices_a, v) && contains(vertices_b, v) && contains(features.element_triangles(pair.a), f) &&
           contains(features.element_triangles(pair.b), f);
  };
  const auto both_have_edge = [&](Index e) {
    return contains(features.element_edges(pair.a), e) && contains(features.element_edges(pair.b), e);
  };
  FeatureMask rest = mask;
  const auto ee = [&](Index e1, Index e2) {
    if (e1 > e2 && both_have_edge(e1) && both_have_edge(e2)) return;
    out.ee_if_apart(e1, e2);
  };
  rest.vertices_b = ~0u;
  detail::for_each_feature_pair(step, pair, rest, kAny, kAny, [&](Index v, Index f) { out.vf_if_apart(v, f); }, ee);
  (void)both_have;
}

}  // namespace

}  // namespace volccd
