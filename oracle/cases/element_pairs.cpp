#include <volccd/oracle/cases/element_pairs.hpp>

#include <algorithm>
#include <cmath>

namespace volccd::cases {

namespace {

Mesh make_mesh(ElementType type, Index elements) {
  const Index n = static_cast<Index>(vertex_count(type));
  Mesh mesh;
  mesh.add_vertices(elements * n);
  for (Index o = 0; o < elements; ++o) {
    ElementSpec spec;
    spec.type = type;
    spec.id = o;
    for (Index i = 0; i < n; ++i) spec.vertices.push_back(o * n + i);
    mesh.add_element(spec);
  }
  return mesh;
}

}  // namespace

ElementGenerator nearly_degenerate_elements(Separation separation) {
  return [separation](Choices& choices, FeatureKind kind, int control_points, std::size_t count) {
    return near_degenerate(choices, kind, control_points, count, count, separation);
  };
}

ElementGenerator attacking_elements(std::span<const Attack> attacks) {
  return [attacks](Choices& choices, FeatureKind kind, int control_points, std::size_t count) {
    return any_attack_elements(choices, attacks, kind, control_points, count);
  };
}

Case nested_elements(Choices& choices, FeatureKind kind, int control_points, std::size_t count) {
  Case made;
  made.kind = kind;
  made.control_points = control_points;
  const auto lattice = [&](int range) {
    return Vec3(choices.lattice(range), choices.lattice(range), choices.lattice(range));
  };
  Vec3 middle = Vec3::Zero();
  for (std::size_t i = 0; i < count; ++i) {
    const Vec3 x = lattice(1 << 16);
    made.sets[0].push_back({x, x, x});
    middle += x / static_cast<double>(count);
  }
  const Vec3 away = choices.below(2) ? lattice(1 << 18) : Vec3(Vec3::Zero());
  const double shrink = std::ldexp(1, -4 - choices.below(8));
  for (std::size_t i = 0; i < count; ++i) {
    const Vec3 x = middle + shrink * (made.sets[0][i][0] - middle);
    made.sets[1].push_back({x, x + away / 2, x + away});
    if (control_points == 2) made.sets[1].back()[1] = x + away;
  }
  return made;
}

ElementPairs::ElementPairs(ElementType type, Index pairs) : topology_(make_mesh(type, 2 * pairs)), features_(pairs) {
  for (int degree = 0; degree < 2; ++degree) motions_[degree] = Motion(topology_.mesh().vertex_count(), degree + 2);
}

Case ElementPairs::choose(Choices& choices, Index i, FeatureKind kind, int control_points,
                          const ElementGenerator& generator) {
  const Case c = generator(choices, kind, control_points, topology_.mesh().vertices(2 * i).size());
  features_[i].kind = kind;
  features_[i].swapped = choices.one_in(2);
  Motion& motion = motions_[static_cast<std::size_t>(control_points - 2)];
  for (std::size_t set = 0; set < 2; ++set) {
    const Index o = element(i, set);
    std::vector<Index> order = features_[i].sets[set] = choose_feature(choices, c.own(set), o);
    for (const Index v : topology_.mesh().vertices(o))
      if (std::find(order.begin(), order.end(), v) == order.end()) order.push_back(v);
    for (std::size_t k = 0; k < order.size(); ++k)
      for (int point = 0; point < control_points; ++point)
        motion.set(order[k], point, c.sets[set][k][static_cast<std::size_t>(point)]);
  }
  return c;
}

bool ElementPairs::masked(Index i, const FeatureMask& mask) const {
  if (features_[i].kind == FeatureKind::ee) return edge_masked(i, 0, mask) || edge_masked(i, 1, mask);
  return vertex_masked(i, mask);
}

std::vector<Index> ElementPairs::choose_feature(Choices& choices, std::size_t vertices, Index o) const {
  const Features& f = topology_.features();
  const auto any = [&](std::span<const Index> from) {
    return from[static_cast<std::size_t>(choices.below(static_cast<int>(from.size())))];
  };
  if (vertices == 1) return {any(topology_.mesh().vertices(o))};
  if (vertices == 2) {
    const auto& edge = f.edge(any(f.element_edges(o)));
    return {edge.begin(), edge.end()};
  }
  const auto& triangle = f.triangle(any(f.element_triangles(o)));
  return {triangle.begin(), triangle.end()};
}

bool ElementPairs::vertex_masked(Index i, const FeatureMask& mask) const {
  const Index o = element(i, 0);
  const auto vertices = topology_.mesh().vertices(o);
  const auto at = std::find(vertices.begin(), vertices.end(), features_[i].sets[0][0]) - vertices.begin();
  return ((o == 2 * i ? mask.vertices_a : mask.vertices_b) >> at & 1) != 0;
}

bool ElementPairs::edge_masked(Index i, std::size_t set, const FeatureMask& mask) const {
  const Features& f = topology_.features();
  const Index o = element(i, set);
  const auto edges = f.element_edges(o);
  const std::vector<Index>& vertices = features_[i].sets[set];
  const auto at = std::find(edges.begin(), edges.end(), f.find_edge(vertices[0], vertices[1])) - edges.begin();
  return ((o == 2 * i ? mask.edges_a : mask.edges_b) >> at & 1) != 0;
}

}  // namespace volccd::cases
