#include <volccd/mesh/topology.hpp>

#include <algorithm>
#include <atomic>

#include <fmt/format.h>

#include <volccd/core/error.hpp>
#include <volccd/core/heap_bytes.hpp>
#include <volccd/core/sort_unique.hpp>
#include <volccd/mesh/check_element.hpp>
#include <volccd/mesh/detail/feature_edit.hpp>
#include <volccd/mesh/tables/chunks.hpp>

namespace volccd {

namespace {

std::uint64_t next_version() {
  static std::atomic<std::uint64_t> last{0};
  return ++last;
}

[[noreturn]] void refuse(const char* dataset, std::size_t index, const std::string& problem) {
  throw InputError("edit", dataset, static_cast<std::int64_t>(index), problem);
}

void check_removed(const Mesh& mesh, const TopologyEdit& edit) {
  for (std::size_t i = 0; i < edit.removed.size(); ++i) {
    const Index o = edit.removed[i];
    if (o >= mesh.element_slots())
      refuse("removed", i, fmt::format("element slot {} is out of range, there are {}", o, mesh.element_slots()));
    if (!mesh.is_live(o)) refuse("removed", i, fmt::format("element slot {} is empty", o));
  }
  if (const std::size_t i = detail::find_repeated<Index>(edit.removed); i < edit.removed.size())
    refuse("removed", i, fmt::format("element slot {} occurs twice", edit.removed[i]));
}

void check_new_vertices(const Mesh& mesh, const TopologyEdit& edit) {
  if (std::size_t{mesh.vertex_count()} + edit.new_vertex_ids.size() >= kNone)
    refuse("new_vertex_ids", 0, "more than 2^32 - 2 vertices");
  for (std::size_t i = 0; i < edit.new_vertex_ids.size(); ++i) {
    if (i == 0 && mesh.vertex_count() == 0) continue;
    const std::int64_t before = i == 0 ? mesh.vertex_ids().back() : edit.new_vertex_ids[i - 1];
    if (edit.new_vertex_ids[i] <= before)
      refuse("new_vertex_ids", i, fmt::format("ids must ascend, but {} follows {}", edit.new_vertex_ids[i], before));
  }
}

/// `removed` is edit.removed in ascending order.
void check_added(const Mesh& mesh, const TopologyEdit& edit, std::span<const Index> removed) {
  const auto vertices = static_cast<Index>(mesh.vertex_count() + edit.new_vertex_ids.size());
  for (std::size_t i = 0; i < edit.added.size(); ++i)
    if (const std::string problem = detail::element_problem(edit.added[i], vertices); !problem.empty())
      refuse("added", i, problem);
  if (mesh.element_slots() + edit.added.size() >= kNone) refuse("added", 0, "more than 2^32 - 2 elements");

  std::vector<std::int64_t> ids;
  for (const ElementSpec& spec : edit.added) {
    const Index holder = mesh.find_element(spec.id);
    if (holder != kNone && !std::binary_search(removed.begin(), removed.end(), holder))
      refuse("added", ids.size(), fmt::format("another element has the id {}", spec.id));
    ids.push_back(spec.id);
  }
  if (const std::size_t i = detail::find_repeated<std::int64_t>(ids); i < ids.size())
    refuse("added", i, fmt::format("element id {} occurs twice", ids[i]));
}

/// Vertices of the elements that an edit removes or adds, each once.
std::vector<Index> vertices_of(const Mesh& mesh, const TopologyEdit& edit) {
  std::vector<Index> vertices;
  for (Index o : edit.removed) vertices.insert(vertices.end(), mesh.vertices(o).begin(), mesh.vertices(o).end());
  for (const ElementSpec& spec : edit.added)
    vertices.insert(vertices.end(), spec.vertices.begin(), spec.vertices.end());
  sort_unique(vertices);
  return vertices;
}

}  // namespace

Topology::Topology(Mesh mesh, Executor& executor, EdgeSet edge_set)
    : mesh_(std::move(mesh)), features_(edge_set), version_(next_version()), base_version_(version_) {
  features_.build(mesh_, executor);
  adjacency_.build(mesh_, executor);
  for (Index o = 0; o < mesh_.element_slots(); ++o)
    if (mesh_.is_live(o)) note_object(mesh_.object(o));
  if (several_objects_) shared_vertices_ = count_all_shared(executor);
}

const TopologyChange& Topology::apply(const TopologyEdit& edit) {
  auto change = std::make_unique<TopologyChange>();
  change->removed_elements = edit.removed;
  std::sort(change->removed_elements.begin(), change->removed_elements.end());
  check_removed(mesh_, edit);
  check_new_vertices(mesh_, edit);
  check_added(mesh_, edit, change->removed_elements);
  // All memory is allocated before the first commit(); until then nothing changes.
  const bool several = several_objects_ || std::ranges::any_of(edit.added, [&](const ElementSpec& spec) {
                         return spec.object != first_object_.value_or(edit.added[0].object);
                       });
  const std::vector<Index> vertices = several ? vertices_of(mesh_, edit) : std::vector<Index>();
  history_.reserve(kHistory);
  const std::vector<Index> slots = mesh_.prepare(change->removed_elements, edit.new_vertex_ids.size(), edit.added);
  change->added_elements = slots;
  std::sort(change->added_elements.begin(), change->added_elements.end());
  const Index element_slots = std::max(mesh_.element_slots(), slots.empty() ? 0 : change->added_elements.back() + 1);
  adjacency_.prepare(edit.added, slots, element_slots);
  detail::FeatureEdit features(features_, mesh_, change->removed_elements, edit.added, slots,
                               static_cast<Index>(mesh_.vertex_count() + edit.new_vertex_ids.size()), element_slots,
                               change->features);

  const Index shared_before = count_shared(vertices);
  for (const ElementSpec& spec : edit.added) note_object(spec.object);
  mesh_.commit(change->removed_elements, edit.new_vertex_ids, edit.added);
  features.commit();
  adjacency_.commit(change->removed_elements, edit.added, slots, element_slots);
  shared_vertices_ = shared_vertices_ - shared_before + count_shared(vertices);
  change->version = next_version();
  if (history_.size() == kHistory) {
    base_version_ = history_.front()->version;
    history_.erase(history_.begin());
  }
  version_ = change->version;
  history_.push_back(std::move(change));
  return *history_.back();
}

bool Topology::changes_since(std::uint64_t version, std::vector<const TopologyChange*>& changes) const {
  changes.clear();
  if (version == version_) return true;
  bool reached = version == base_version_;
  for (const auto& change : history_) {
    if (reached) changes.push_back(change.get());
    reached |= change->version == version;
  }
  return reached;
}

void Topology::note_object(std::int32_t object) {
  if (!first_object_) first_object_ = object;
  several_objects_ |= *first_object_ != object;
}

bool Topology::is_shared(Index vertex) const {
  const std::span<const Index> elements = features_.vertex_elements(vertex);
  return std::any_of(elements.begin(), elements.end(),
                     [&](Index o) { return mesh_.object(o) != mesh_.object(elements[0]); });
}

Index Topology::count_shared(std::span<const Index> vertices) const {
  Index count = 0;
  for (Index v : vertices)
    if (v < features_.vertex_slots()) count += is_shared(v);
  return count;
}

Index Topology::count_all_shared(Executor& executor) const {
  std::atomic<Index> all{0};
  detail::Chunks(mesh_.vertex_count()).for_each(executor, [&](std::size_t, std::size_t begin, std::size_t end) {
    Index count = 0;
    for (Index v = static_cast<Index>(begin); v < end; ++v) count += is_shared(v);
    all += count;
  });
  return all;
}

std::size_t Topology::bytes() const {
  std::size_t total = mesh_.bytes() + features_.bytes() + adjacency_.bytes();
  for (const auto& change : history_) {
    const FeatureChange& f = change->features;
    total += heap_bytes(change->removed_elements, change->added_elements, f.removed_vertices, f.removed_edges,
                        f.removed_triangles, f.added_vertices, f.added_edges, f.added_triangles, f.touched_vertices,
                        f.touched_edges, f.touched_triangles);
  }
  return total;
}

}  // namespace volccd
