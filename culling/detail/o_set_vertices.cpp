#include <volccd/culling/detail/o_set_vertices.hpp>

#include <algorithm>

namespace volccd::detail {

namespace {

constexpr std::size_t kBlock = 8;

}  // namespace

void ElementVertices::build(const Mesh& mesh) {
  std::size_t most = 0;
  for (Index o = 0; o < mesh.element_slots(); ++o) most = std::max(most, mesh.vertices(o).size());
  stride_ = most <= 4 ? 4 : kBlock;
  ids_.assign(std::size_t{mesh.element_slots()} * stride_, kNone);
  large_.clear(most > kBlock ? mesh.element_slots() : 0, 0);
  for (Index o = 0; o < mesh.element_slots(); ++o) store(mesh, o);
}

void ElementVertices::update(const Mesh& mesh, std::span<const Index> slots) {
  std::size_t most = 0;
  for (Index o : slots) most = std::max(most, mesh.vertices(o).size());
  if (most > stride_ && (stride_ < kBlock || large_.size() == 0)) return build(mesh);
  ids_.resize(std::size_t{mesh.element_slots()} * stride_, kNone);
  if (large_.size() != 0) large_.extend(mesh.element_slots());
  for (Index o : slots) store(mesh, o);
  large_.compact_if_sparse();
}

void ElementVertices::store(const Mesh& mesh, Index o) {
  const std::span<const Index> vertices = mesh.vertices(o);
  Index* const block = ids_.data() + std::size_t{o} * stride_;
  const std::size_t held = std::min<std::size_t>(vertices.size(), stride_);
  std::fill(std::copy_n(vertices.begin(), held, block), block + stride_, vertices.empty() ? kNone : vertices[0]);
  if (large_.size() == 0) return;
  if (vertices.size() > kBlock) {
    large_.assign(o, vertices);
  } else {
    large_.assign(o, {});
  }
}

}  // namespace volccd::detail
