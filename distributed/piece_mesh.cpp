#include <volccd/distributed/piece_mesh.hpp>

#include <algorithm>
#include <initializer_list>
#include <utility>

#include <volccd/core/function_ref.hpp>
#include <volccd/core/sort_unique.hpp>
#include <volccd/distributed/detail/owners.hpp>

namespace volccd::distributed {

static_assert(PieceMesh::kNoRank == detail::kNoRank);

namespace {

using OwnedVertex = std::pair<std::int64_t, int>;

/// The first id of the group of an id.
std::int64_t group_begin(std::int64_t id, std::int64_t group) {
  const std::int64_t rest = id % group;
  return id - (rest < 0 ? rest + group : rest);
}

/// The vertices of elements and those that complete their groups, ascending.
std::vector<OwnedVertex> vertices_of(std::initializer_list<const ReceivedElements*> parts, std::int64_t group) {
  std::vector<OwnedVertex> vertices;
  for (const ReceivedElements* part : parts)
    for (std::size_t i = 0; i < part->owners.size(); ++i)
      vertices.emplace_back(part->elements.vertices[i], part->owners[i]);
  sort_unique(vertices);
  if (group == 1) return vertices;
  std::vector<OwnedVertex> all;
  for (const OwnedVertex& vertex : vertices)
    for (std::int64_t i = 0, first = group_begin(vertex.first, group); i < group; ++i)
      all.emplace_back(first + i, detail::kNoRank);
  all.insert(all.end(), vertices.begin(), vertices.end());
  // Of the same id, the one with an owner is first, and stays.
  std::ranges::sort(all, [](const OwnedVertex& a, const OwnedVertex& b) {
    return a.first != b.first ? a.first < b.first : a.second > b.second;
  });
  all.erase(std::unique(all.begin(), all.end(),
                        [](const OwnedVertex& a, const OwnedVertex& b) { return a.first == b.first; }),
            all.end());
  return all;
}

/// Marks all vertices of the elements but those at which an element of their stars is not held (`held`: ids,
/// ascending). Returns the number of those.
std::uint64_t mark_complete(const Elements& elements, const Elements& stars, std::span<const std::int64_t> held,
                            FunctionRef<Index(std::int64_t)> slot_of, std::vector<std::uint8_t>& complete) {
  for (const std::int64_t id : elements.vertices) complete[slot_of(id)] = 1;
  std::uint64_t count = 0;
  for (std::size_t i = 0; i < stars.size(); ++i) {
    if (std::ranges::binary_search(held, stars.ids[i])) continue;
    for (const std::int64_t id : stars.vertices_of(i)) complete[slot_of(id)] = 0;
    ++count;
  }
  return count;
}

}  // namespace

bool PieceMesh::serves(const Elements& elements, const Config& config) const {
  std::vector<std::int64_t> ids = elements.ids;
  std::ranges::sort(ids);
  return config_ == config && ids_.size() <= ids.size() + ids.size() / 4 && std::ranges::includes(ids_, ids) &&
         ids.empty() == ids_.empty();
}

void PieceMesh::build(const ReceivedElements& received, const ReceivedElements& stars, const Config& config,
                      Executor& executor) {
  clear();  // if the rest throws, the piece serves for no elements
  config_ = config;
  if (received.elements.size() == 0) return;
  std::vector<std::int64_t> ids, held = received.elements.ids;
  std::ranges::sort(held);
  for (const auto& [id, owner] : vertices_of({&received, &stars}, config.vertex_group)) {
    ids.push_back(id);
    owners_.push_back(owner);
  }
  const auto slot_of = [&](std::int64_t id) {
    return static_cast<Index>(std::ranges::lower_bound(ids, id) - ids.begin());
  };
  const auto mesh_of = [&](const Elements& elements, auto&& keep) {
    Mesh mesh;
    mesh.add_vertices(ids);
    for (std::size_t i = 0; i < elements.size(); ++i)
      if (keep(i)) mesh.add_element(elements.spec(i, slot_of));
    return mesh;
  };
  topology_.emplace(mesh_of(received.elements, [](std::size_t) { return true; }), executor, config.edge_set);
  complete_.assign(ids.size(), 0);
  for (std::size_t i = 0; i < received.complete.size(); ++i)
    if (received.complete[i] != 0) complete_[slot_of(received.elements.vertices[i])] = 1;
  if (stars.elements.size() > 0) {
    halo_ = mark_complete(received.elements, stars.elements, held, slot_of, complete_);
    const auto is_cut = [&](std::int64_t id) {
      const Index v = slot_of(id);
      return complete_[v] == 0 && !topology_->features().vertex_elements(v).empty();
    };
    Mesh others = mesh_of(stars.elements,
                          [&](std::size_t i) { return std::ranges::any_of(stars.elements.vertices_of(i), is_cut); });
    if (others.element_count() > 0) cut_stars_.emplace(std::move(others), executor, config.edge_set);
  }
  ids_ = std::move(held);
}

std::span<const std::int64_t> PieceMesh::vertex_ids() const { return topology_->mesh().vertex_ids(); }

}  // namespace volccd::distributed
