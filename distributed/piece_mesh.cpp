#include <volccd/distributed/piece_mesh.hpp>

#include <algorithm>
#include <utility>

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
std::vector<OwnedVertex> vertices_of(const Elements& elements, std::span<const int> owners, std::int64_t group) {
  std::vector<OwnedVertex> vertices;
  vertices.reserve(owners.size());
  for (std::size_t i = 0; i < owners.size(); ++i) vertices.emplace_back(elements.vertices[i], owners[i]);
  std::ranges::sort(vertices);
  vertices.erase(std::unique(vertices.begin(), vertices.end()), vertices.end());
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

}  // namespace

bool PieceMesh::update(const Elements& elements, std::span<const int> owners, const Config& config,
                       Executor& executor) {
  std::vector<std::int64_t> ids = elements.ids;
  std::ranges::sort(ids);
  const bool kept = config_ == config && ids_.size() <= ids.size() + ids.size() / 4 &&
                    std::ranges::includes(ids_, ids) && ids.empty() == ids_.empty();
  if (kept) return false;
  clear();  // if the rest throws, the next update builds the piece
  config_ = config;
  if (elements.size() > 0) build(elements, owners, executor);
  ids_ = std::move(ids);
  return true;
}

void PieceMesh::build(const Elements& elements, std::span<const int> owners, Executor& executor) {
  std::vector<std::int64_t> ids;
  for (const auto& [id, owner] : vertices_of(elements, owners, config_.vertex_group)) {
    ids.push_back(id);
    owners_.push_back(owner);
  }
  Mesh piece;
  piece.add_vertices(ids);
  const auto slot_of = [&](std::int64_t id) {
    return static_cast<Index>(std::ranges::lower_bound(ids, id) - ids.begin());
  };
  for (std::size_t i = 0; i < elements.size(); ++i) piece.add_element(elements.spec(i, slot_of));
  topology_.emplace(std::move(piece), executor, config_.edge_set);
}

std::span<const std::int64_t> PieceMesh::vertex_ids() const { return topology_->mesh().vertex_ids(); }

}  // namespace volccd::distributed
