// The candidates of a few vertices, found on the part of the mesh around them.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include <volccd/core/heap_bytes.hpp>
#include <volccd/pipelines/pipeline.hpp>

namespace volccd::detail {

/// Finds the tests of features with one of the given vertices, among them all that come within the separation of the
/// step. The pipeline runs on a mesh of its own: the elements at these vertices, and those whose boxes come within the
/// separation of theirs. A feature with such a vertex has all its elements there, and a feature within the separation
/// of it has one. Object filters are not applied. Reuses its memory; not thread-safe.
class LocalCandidates {
 public:
  /// So many elements at the vertices that comparing all elements with them is no longer worth it.
  static constexpr std::size_t kMaxElements = 96;

  /// Appends the tests to `tests`. Returns false, with `tests` unchanged, if the vertices have more than kMaxElements
  /// elements. O(elements), and the run on the part of the mesh.
  bool find(const Pipeline& pipeline, const Step& step, std::span<const Index> vertices, Executor& executor,
            TestBatch& tests);

  std::size_t bytes() const { return heap_bytes(own_, near_, local_, vertices_); }

 private:
  struct Box {
    Vec3 low, high;
  };
  void find_near(const Step& step);
  void number_vertices(const Mesh& mesh);
  Topology local_topology(const Topology& whole, Executor& executor) const;
  Motion local_motion(const Motion& whole) const;
  void append(const Step& step, const Features& local, const TestBatch& found, std::span<const Index> vertices,
              TestBatch& tests) const;

  std::vector<Index> own_, near_;  ///< slots of elements: at the vertices; those and the ones near them
  std::vector<Index> local_;       ///< by vertex: its slot in the part, or kNone
  std::vector<Index> vertices_;    ///< of the part: slots in the whole mesh, ascending
};

}  // namespace volccd::detail
