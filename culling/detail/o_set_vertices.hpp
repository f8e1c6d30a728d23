// The vertices of all elements in one array, for the random access of O-Set building.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include <volccd/mesh/incidence_pool.hpp>
#include <volccd/mesh/mesh.hpp>

namespace volccd::detail {

class ElementVertices {
 public:
  void build(const Mesh& mesh);
  /// Brings the given slots up to date. All of them, if larger elements than before come in.
  void update(const Mesh& mesh, std::span<const Index> slots);

  /// In any order; some may be repeated.
  std::span<const Index> operator[](Index o) const {
    if (large_.size() != 0 && !large_[o].empty()) return large_[o];
    return {ids_.data() + std::size_t{o} * stride_, stride_};
  }

  std::size_t bytes() const { return ids_.capacity() * sizeof(Index) + large_.bytes(); }

 private:
  void store(const Mesh& mesh, Index o);

  std::uint32_t stride_ = 4;  ///< 4 or 8; short elements repeat their first vertex
  std::vector<Index> ids_;
  IncidencePool large_;  ///< vertices of elements with more than 8; no lists if there are none
};

}  // namespace volccd::detail
