#include <volccd/query/pairs.hpp>

namespace volccd {

std::array<Index, 4> test_vertices(const Features& features, FeatureKind kind, FeaturePair pair) {
  if (kind == FeatureKind::vf) {
    const std::array<Index, 3>& f = features.triangle(pair.b);
    return {pair.a, f[0], f[1], f[2]};
  }
  const std::array<Index, 2>& a = features.edge(pair.a);
  const std::array<Index, 2>& b = features.edge(pair.b);
  return a < b ? std::array{a[0], a[1], b[0], b[1]} : std::array{b[0], b[1], a[0], a[1]};
}

bool is_test(const Features& features, FeatureKind kind, FeaturePair pair) {
  if (kind == FeatureKind::vf) {
    const std::array<Index, 3>& f = features.triangle(pair.b);
    return pair.a != f[0] && pair.a != f[1] && pair.a != f[2];
  }
  const std::array<Index, 2>& a = features.edge(pair.a);
  const std::array<Index, 2>& b = features.edge(pair.b);
  return a[0] != b[0] && a[0] != b[1] && a[1] != b[0] && a[1] != b[1];
}

}  // namespace volccd
