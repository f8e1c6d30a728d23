#include <volccd/query/object_filter.hpp>

#include <algorithm>

namespace volccd {

bool ObjectFilter::drops(const Topology& topology, ElementPair pair) const {
  if (trivial()) return false;
  const Mesh& mesh = topology.mesh();
  if (allows(mesh.object(pair.a), mesh.object(pair.b))) return false;
  const auto pure = [&](Index o) {  // no vertex belongs to an element of another object
    return std::ranges::none_of(mesh.vertices(o), [&](Index v) { return topology.is_shared(v); });
  };
  return !topology.objects_share_vertices() || (pure(pair.a) && pure(pair.b));
}

bool ObjectFilter::asks_for(const Topology& topology, FeatureKind kind, FeaturePair pair) const {
  if (trivial()) return true;
  const Mesh& mesh = topology.mesh();
  const Features& features = topology.features();
  const bool vf = kind == FeatureKind::vf;
  const auto inc_a = vf ? features.vertex_elements(pair.a) : features.edge_elements(pair.a);
  const auto inc_b = vf ? features.triangle_elements(pair.b) : features.edge_elements(pair.b);
  if (!topology.objects_share_vertices())
    return !inc_a.empty() && !inc_b.empty() && allows(mesh.object(inc_a.front()), mesh.object(inc_b.front()));
  for (const Index oi : inc_a)
    for (const Index oj : inc_b)
      if (allows(mesh.object(oi), mesh.object(oj))) return true;
  return false;
}

}  // namespace volccd
