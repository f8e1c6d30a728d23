// Random changes of a topology.
#pragma once

#include <algorithm>
#include <set>
#include <utility>
#include <vector>

#include <volccd/core/random.hpp>
#include <volccd/mesh/topology.hpp>

namespace volccd {

inline std::vector<Index> distinct_vertices(Random& random, Index vertices, std::size_t n) {
  std::vector<Index> picked;
  while (picked.size() < n) {
    const auto v = static_cast<Index>(random.below(vertices));
    if (std::find(picked.begin(), picked.end(), v) == picked.end()) picked.push_back(v);
  }
  return picked;
}

/// A prism over an n-gon, as a polytope.
inline ElementSpec prism(std::vector<Index> v) {
  ElementSpec spec;
  spec.type = ElementType::polytope;
  const auto n = static_cast<Index>(v.size() / 2);
  for (const Index base : {0u, n}) {
    spec.faces.push_back(n);
    for (Index i = 0; i < n; ++i) spec.faces.push_back(v[base + i]);
  }
  for (Index i = 0; i < n; ++i)
    for (Index w : {Index{4}, v[i], v[(i + 1) % n], v[n + (i + 1) % n], v[n + i]}) spec.faces.push_back(w);
  spec.vertices = std::move(v);
  return spec;
}

/// An element on random vertices: of the given type, or a prism with `sides` sides.
inline ElementSpec random_element(Random& random, Index vertices, ElementType type, std::int64_t id,
                                  std::size_t sides = 5) {
  ElementSpec spec;
  if (type == ElementType::polytope) {
    spec = prism(distinct_vertices(random, vertices, 2 * sides));
  } else {
    spec.type = type;
    spec.vertices = distinct_vertices(random, vertices, static_cast<std::size_t>(vertex_count(type)));
  }
  spec.id = id;
  return spec;
}

inline ElementSpec spec_of(const Mesh& mesh, Index o) {
  const auto vertices = mesh.vertices(o), faces = mesh.polytope_faces(o);
  return {.type = mesh.type(o),
          .vertices = {vertices.begin(), vertices.end()},
          .faces = {faces.begin(), faces.end()},
          .object = mesh.object(o),
          .id = mesh.element_id(o)};
}

/// Random changes that keep the topology similar to that of its generator: elements are removed, added again, or made
/// new on vertices that are near each other, old or new ones.
class TopologyEditor {
 public:
  TopologyEditor(Topology& topology, std::uint64_t seed, std::vector<ElementType> types)
      : topology_(topology), random_(seed), types_(std::move(types)), next_id_(1'000'000) {}

  Random& random() { return random_; }

  void edit(std::size_t removals, std::size_t returns, std::size_t inventions) {
    const Mesh& mesh = topology_.mesh();
    TopologyEdit edit;
    for (std::size_t i = 0; i < returns && !out_.empty(); ++i) {
      const std::size_t at = random_.below(out_.size());
      edit.added.push_back(out_[at]);
      out_.erase(out_.begin() + static_cast<std::ptrdiff_t>(at));
    }
    std::set<Index> removed;
    for (std::size_t i = 0; i < removals && mesh.element_count() > removed.size() + 8; ++i) {
      const auto o = static_cast<Index>(random_.below(mesh.element_slots()));
      if (mesh.is_live(o) && removed.insert(o).second) out_.push_back(spec_of(mesh, o));
    }
    edit.removed.assign(removed.begin(), removed.end());
    if (random_.below(4) == 0) edit.new_vertex_ids.push_back(mesh.vertex_id(mesh.vertex_count() - 1) + 1);
    for (std::size_t i = 0; i < inventions; ++i) invent(edit);
    topology_.apply(edit);
  }

  /// One edit of any kind, of at most about a twenty-fourth of the elements.
  void edit_at_random() {
    const std::size_t max = 1 + topology_.mesh().element_count() / 24;
    switch (random_.below(6)) {
      case 0: edit(random_.below(max) + 1, 0, 0); break;
      case 1: edit(0, random_.below(max) + 1, 0); break;
      case 2: edit(0, 0, random_.below(3) + 1); break;
      case 3: remove_region(max); break;
      default: edit(random_.below(max), random_.below(max), random_.below(3)); break;
    }
  }

  /// All elements within a number of adjacency steps from a random one, but at most `most`.
  void remove_region(std::size_t max) {
    const Mesh& mesh = topology_.mesh();
    Index start = 0;
    do start = static_cast<Index>(random_.below(mesh.element_slots()));
    while (!mesh.is_live(start));
    std::vector<Index> region{start};
    std::set<Index> seen{start};
    for (std::size_t i = 0; i < region.size() && region.size() < max; ++i)
      for (Index v : mesh.vertices(region[i]))
        for (Index o : topology_.features().vertex_elements(v))
          if (region.size() < max && seen.insert(o).second) region.push_back(o);
    for (Index o : region) out_.push_back(spec_of(mesh, o));
    TopologyEdit edit;
    edit.removed = region;
    topology_.apply(edit);
  }
  void put_everything_back() {
    TopologyEdit edit;
    edit.added = std::exchange(out_, {});
    topology_.apply(edit);
  }

 private:
  void invent(TopologyEdit& edit) {
    const ElementType type = types_[random_.below(types_.size())];
    const Index vertices = topology_.mesh().vertex_count() + static_cast<Index>(edit.new_vertex_ids.size());
    const std::size_t n = type == ElementType::polytope ? 10 : static_cast<std::size_t>(vertex_count(type));
    const auto window = static_cast<Index>(std::min<std::size_t>(vertices, 2 * n + 2));
    const auto at =
        random_.below(4) == 0 ? vertices - window : static_cast<Index>(random_.below(vertices - window + 1));
    ElementSpec spec = random_element(random_, window, type, next_id_++);
    spec.renumber([&](Index v) { return v + at; });
    edit.added.push_back(std::move(spec));
  }

  Topology& topology_;
  Random random_;
  std::vector<ElementType> types_;
  std::vector<ElementSpec> out_;
  std::int64_t next_id_;
};

}  // namespace volccd
