#include <volccd/query/pairs.hpp>

namespace volccd {

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
