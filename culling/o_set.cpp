#include <volccd/culling/o_set.hpp>

#include <cassert>
#include <limits>

namespace volccd {

/// Fills blocks of one kind and epoch. Rows that turn out empty are dropped; a row that does not fit goes on in the next
/// block.
class OSet::Writer {
 public:
  Writer(std::vector<Block>& blocks, Rows kind, Epoch epoch) : blocks_(blocks), kind_(kind), epoch_(epoch) {}
  Writer(const Writer&) = delete;
  Writer& operator=(const Writer&) = delete;
  ~Writer() { assert(rows_.empty()); }

  void begin_row(Index owner) {
    row_ = rows_.size();
    rows_.push_back(owner);
    rows_.push_back(0);
  }

  void add(Index partner) {
    if (pairs_ == kBlockPairs) {
      const Index owner = rows_[row_];
      end_row();
      flush();
      begin_row(owner);
    }
    rows_.push_back(partner);
    ++pairs_;
  }

  void end_row() {
    const std::size_t length = rows_.size() - row_ - 2;
    rows_[row_ + 1] = static_cast<Index>(length);
    if (length == 0) rows_.resize(row_);
  }

  void flush() {
    if (pairs_ != 0) blocks_.push_back({{rows_.begin(), rows_.end()}, pairs_, epoch_, kind_});
    written_ += pairs_;
    rows_.clear();
    pairs_ = 0;
  }

  /// Pairs that were flushed.
  std::size_t written() const { return written_; }

 private:
  std::vector<Block>& blocks_;
  Rows kind_;
  Epoch epoch_;
  std::vector<Index> rows_;
  std::size_t row_ = 0;
  std::uint32_t pairs_ = 0;
  std::size_t written_ = 0;
};

namespace {

/// Visits each vertex in use and each edge once, neighbours soon after each other (breadth first): around features that are
/// near, the same elements are looked at, which numbering may have scattered over all of memory.
template <class VisitVertex, class VisitEdge>
void for_each_near(const Topology& topology, VisitVertex&& visit_vertex, VisitEdge&& visit_edge) {
  const Features& features = topology.features();
  std::vector<char> vertex_seen(features.vertex_slots(), 0), element_seen(topology.mesh().element_slots(), 0);
  std::vector<Index> queue;
  queue.reserve(features.vertex_count());
  for (Index start = 0, next = 0; start < features.vertex_slots(); ++start) {
    if (vertex_seen[start] || features.vertex_elements(start).empty()) continue;
    vertex_seen[start] = 1;
    queue.push_back(start);
    for (; next < queue.size(); ++next) {
      visit_vertex(queue[next]);
      for (Index o : features.vertex_elements(queue[next])) {
        if (element_seen[o]) continue;
        element_seen[o] = 1;
        for (Index e : features.element_edges(o))
          if (features.edge_elements(e)[0] == o) visit_edge(e);
        for (Index v : topology.mesh().vertices(o)) {
          if (vertex_seen[v]) continue;
          vertex_seen[v] = 1;
          queue.push_back(v);
        }
      }
    }
  }
}

}  // namespace

OSet::OSet(OSetKind kind) : kind_(kind) { assert(kind != OSetKind::none); }

template <class Visit>
void OSet::visit(const Block& block, Visit&& pair) const {
  const std::vector<Epoch>& owner_births = block.kind == Rows::vertex     ? vertex_births_
                                           : block.kind == Rows::triangle ? triangle_births_
                                                                          : edge_births_;
  const std::vector<Epoch>& partner_births = block.kind == Rows::vertex     ? triangle_births_
                                             : block.kind == Rows::triangle ? vertex_births_
                                                                            : edge_births_;
  const bool all_sound = block.epoch == epoch_;
  for (std::size_t at = 0; at < block.rows.size();) {
    const Index owner = block.rows[at];
    const std::size_t end = at + 2 + block.rows[at + 1];
    if (all_sound) {
      for (std::size_t i = at + 2; i < end; ++i) pair(owner, block.rows[i]);
    } else if (owner_births[owner] <= block.epoch) {
      for (std::size_t i = at + 2; i < end; ++i)
        if (partner_births[block.rows[i]] <= block.epoch) pair(owner, block.rows[i]);
    }
    at = end;
  }
}

void OSet::append(std::size_t block, TestBatch& out) const {
  const Block& source = blocks_[block];
  switch (source.kind) {
    case Rows::vertex: return visit(source, [&](Index v, Index f) { out.vf.push_back({v, f}); });
    case Rows::triangle: return visit(source, [&](Index f, Index v) { out.vf.push_back({v, f}); });
    case Rows::edge: return visit(source, [&](Index a, Index b) { out.ee.push_back({std::min(a, b), std::max(a, b)}); });
  }
}

OSetCounts OSet::counts() const {
  OSetCounts counts;
  for (const Block& block : blocks_) {
    std::size_t& count = block.kind == Rows::edge ? counts.ee : counts.vf;
    if (block.epoch == epoch_) {
      count += block.pairs;
    } else {
      visit(block, [&](Index, Index) { ++count; });
    }
  }
  return counts;
}

std::size_t OSet::bytes() const {
  std::size_t bytes = blocks_.capacity() * sizeof(Block) + vertices_.bytes() + partners_.bytes();
  for (const Block& block : blocks_) bytes += block.rows.capacity() * sizeof(Index);
  for (const auto* births : {&vertex_births_, &triangle_births_, &edge_births_})
    bytes += births->capacity() * sizeof(Epoch);
  for (const auto* list : {&touched_.vertices, &touched_.triangles, &touched_.edges})
    bytes += list->capacity() * sizeof(Index);
  return bytes;
}

void OSet::start_over(const Features& features) {
  blocks_.clear();
  epoch_ = 0;
  written_pairs_ = births_ = 0;
  vertex_births_.assign(features.vertex_slots(), 0);
  triangle_births_.assign(features.triangle_slots(), 0);
  edge_births_.assign(features.edge_slots(), 0);
}

void OSet::build(const Topology& topology) {
  const Features& features = topology.features();
  const bool literal = kind_ == OSetKind::literal;
  start_over(features);
  vertices_.build(topology.mesh());
  partners_.fit(features, vertices_, topology.mesh().element_slots());

  Writer vertex_rows(blocks_, Rows::vertex, epoch_), edge_rows(blocks_, Rows::edge, epoch_);
  for_each_near(topology, [&](Index v) {
    vertex_rows.begin_row(v);
    partners_.triangles_of_vertex(literal, v, [&](Index f) { vertex_rows.add(f); });
    vertex_rows.end_row();
  }, [&](Index e) {
    edge_rows.begin_row(e);
    partners_.edges_of_edge(literal, e, [e](Index e2) { return e2 > e; }, [&](Index e2) { edge_rows.add(e2); });
    edge_rows.end_row();
  });
  vertex_rows.flush();
  edge_rows.flush();
  blocks_.shrink_to_fit();
  sound_pairs_ = vertex_rows.written() + edge_rows.written();
  sound_blocks_ = blocks_.size();
  version_ = topology.version();
}

void OSet::bear(std::vector<Epoch>& births, const std::vector<Index>& slots, std::vector<Index>& touched) {
  for (Index slot : slots)
    if (births[slot] != epoch_) {
      births[slot] = epoch_;
      touched.push_back(slot);
      ++births_;
    }
}

void OSet::collect_touched(const Topology& topology, const std::vector<const TopologyChange*>& changes) {
  const Features& features = topology.features();
  vertex_births_.resize(features.vertex_slots(), 0);
  triangle_births_.resize(features.triangle_slots(), 0);
  edge_births_.resize(features.edge_slots(), 0);
  touched_.vertices.clear();
  touched_.triangles.clear();
  touched_.edges.clear();
  for (const TopologyChange* change : changes) {
    const FeatureChange& f = change->features;
    bear(vertex_births_, f.removed_vertices, touched_.vertices);
    bear(triangle_births_, f.removed_triangles, touched_.triangles);
    bear(edge_births_, f.removed_edges, touched_.edges);
    bear(vertex_births_, f.touched_vertices, touched_.vertices);
    bear(triangle_births_, f.touched_triangles, touched_.triangles);
    bear(edge_births_, f.touched_edges, touched_.edges);
  }
  std::erase_if(touched_.vertices, [&](Index v) { return features.vertex_elements(v).empty(); });
  std::erase_if(touched_.triangles, [&](Index f) { return features.triangle_elements(f).empty(); });
  std::erase_if(touched_.edges, [&](Index e) { return features.edge_elements(e).empty(); });
}

void OSet::update(const Topology& topology) {
  std::vector<const TopologyChange*> changes;
  if (version_ == 0 || !topology.changes_since(version_, changes)) return build(topology);
  if (changes.empty()) return;
  ++epoch_;
  collect_touched(topology, changes);
  for (const TopologyChange* change : changes) {
    vertices_.update(topology.mesh(), change->removed_elements);
    vertices_.update(topology.mesh(), change->added_elements);
  }
  partners_.fit(topology.features(), vertices_, topology.mesh().element_slots());

  // A pair of two touched features is written once: VF by its vertex, EE by its smaller edge.
  const bool literal = kind_ == OSetKind::literal;
  Writer vertex_rows(blocks_, Rows::vertex, epoch_), triangle_rows(blocks_, Rows::triangle, epoch_),
      edge_rows(blocks_, Rows::edge, epoch_);
  for (Index v : touched_.vertices) {
    vertex_rows.begin_row(v);
    partners_.triangles_of_vertex(literal, v, [&](Index f) { vertex_rows.add(f); });
    vertex_rows.end_row();
  }
  vertex_rows.flush();
  for (Index f : touched_.triangles) {
    triangle_rows.begin_row(f);
    partners_.vertices_of_triangle(topology.mesh(), literal, f, [&](Index v) { return vertex_births_[v] != epoch_; },
                                   [&](Index v) { triangle_rows.add(v); });
    triangle_rows.end_row();
  }
  triangle_rows.flush();
  for (Index e : touched_.edges) {
    edge_rows.begin_row(e);
    partners_.edges_of_edge(literal, e, [&](Index e2) { return e2 > e || edge_births_[e2] != epoch_; },
                            [&](Index e2) { edge_rows.add(e2); });
    edge_rows.end_row();
  }
  edge_rows.flush();
  written_pairs_ += vertex_rows.written() + triangle_rows.written() + edge_rows.written();
  version_ = topology.version();
  compact_if_stale(topology.features());
}

void OSet::compact_if_stale(const Features& features) {
  const std::size_t live =
      std::size_t{features.vertex_count()} + features.triangle_count() + features.edge_count();
  // Few births can have made few pairs void; many small blocks cost more than they hold.
  const bool stale = births_ > live / 4 + 1024 || written_pairs_ > sound_pairs_ / 2 + kBlockPairs;
  const bool scattered = blocks_.size() > 2 * sound_blocks_ + 64;
  if (stale || scattered || epoch_ == std::numeric_limits<Epoch>::max()) compact();
}

void OSet::compact() {
  std::vector<Block> old;
  old.swap(blocks_);
  Writer writers[] = {{blocks_, Rows::vertex, 0}, {blocks_, Rows::triangle, 0}, {blocks_, Rows::edge, 0}};
  sound_pairs_ = 0;
  for (Block& block : old) {
    Writer& writer = writers[static_cast<std::size_t>(block.kind)];
    Index row = kNone;
    visit(block, [&](Index owner, Index partner) {
      if (owner != row) {
        if (row != kNone) writer.end_row();
        writer.begin_row(row = owner);
      }
      writer.add(partner);
    });
    if (row != kNone) writer.end_row();
    block = {};
  }
  for (Writer& writer : writers) {
    writer.flush();
    sound_pairs_ += writer.written();
  }
  sound_blocks_ = blocks_.size();
  epoch_ = 0;
  written_pairs_ = births_ = 0;
  for (auto* births : {&vertex_births_, &triangle_births_, &edge_births_})
    std::fill(births->begin(), births->end(), Epoch{0});
}

}  // namespace volccd
