// The elements and vertices that a rank gives.
#pragma once

#include <cstdint>
#include <utility>
#include <vector>

#include <volccd/core/executor.hpp>
#include <volccd/distributed/detail/vertex_import.hpp>
#include <volccd/distributed/elements.hpp>
#include <volccd/mesh/features.hpp>
#include <volccd/query/region.hpp>

namespace volccd::distributed::detail {

/// What set_mesh() was given, checked, and where the vertices of the elements are.
class Home {
 public:
  Home() = default;
  /// Collective; throws a RankError.
  Home(Exchange& exchange, Elements elements, std::vector<std::int64_t> vertices, EdgeSet edge_set);

  const Elements& elements() const { return elements_; }
  const std::vector<std::int64_t>& vertices() const { return vertices_; }
  EdgeSet edge_set() const { return edge_set_; }
  const IdTable& own() const { return own_; }
  /// The ids of the vertices of the elements, ascending.
  const std::vector<std::int64_t>& used() const { return used_; }
  /// The position of elements().vertices[i] in used(), and its owner.
  Index corner(std::size_t i) const { return corners_[i]; }
  int owner(std::size_t i) const { return owners_[corners_[i]]; }
  /// Which ranks have elements at the vertices of this rank: positions in vertices(), and ranks.
  std::vector<std::pair<Index, int>> users() const { return import_.receivers(); }

  /// The motion of the vertices of the elements. Collective.
  void update(const Motion& own) { import_.update(own); }
  /// Computes the swept boxes of the vertices in the motion of the last update, enlarged by half the separation.
  void make_boxes(double separation, Executor& executor);
  /// Of used(); as make_boxes() left them, here and below.
  const std::vector<MotionBox>& vertex_boxes() const { return vertex_boxes_; }
  /// The box of elements().vertices[i], and that of element i.
  const MotionBox& corner_box(std::size_t i) const { return vertex_boxes_[corners_[i]]; }
  MotionBox element_box(std::size_t i) const;
  std::vector<MotionBox> element_boxes(Executor& executor) const;
  std::uint64_t bytes_received() const { return import_.bytes_received(); }

 private:
  void check_elements(Exchange& exchange) const;

  Elements elements_;
  std::vector<std::int64_t> vertices_;
  EdgeSet edge_set_ = EdgeSet::triangulated;
  IdTable own_;
  std::vector<std::int64_t> used_;
  std::vector<int> owners_;     ///< of used_
  std::vector<Index> corners_;  ///< for each of elements_.vertices, its position in used_
  VertexImport import_;         ///< of used_
  std::vector<MotionBox> vertex_boxes_;
};

}  // namespace volccd::distributed::detail
