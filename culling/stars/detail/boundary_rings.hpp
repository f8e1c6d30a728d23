// Tests whether the boundary around a vertex remains a graph over a plane throughout a step.
#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include <volccd/core/executor.hpp>
#include <volccd/core/heap_bytes.hpp>
#include <volccd/query/step.hpp>

namespace volccd::detail {

/// A boundary triangle, and the vertices for which its normal is tested: bit i of `tested` is for vertex(i).
struct RingFace {
  std::array<Index, 3> triangle;  ///< oriented outward for elements of positive volume
  Index fourth = kNone;           ///< the other vertex of a quad face
  std::uint8_t tested = 0x7;

  Index vertex(std::size_t i) const { return i < 3 ? triangle[i] : fourth; }
};

/// A face at a vertex, and whether the vertex is one of its triangle and is tested with it.
struct RingCorner {
  static constexpr Index kMaxFaces = Index{1} << 30;
  Index face : 30;  ///< a place among the triangles of the vertex's group
  bool of_triangle : 1, tested : 1;
};

/// The normal of a moving face as Bernstein coefficients, each times its binomial: three for linear motion, five for
/// quadratic. All are divided by about the greatest magnitude among them. Copies of the first fill kLanes.
template <int kLanes>
struct alignas(64) FaceNormal {
  float coefficients[3][kLanes];  ///< [axis][coefficient]
  float unit[3];                  ///< sum of the unit normals at both ends
  float bound;  ///< for any vector n, the error of dot(n, coefficient) is less than |n|_1 times this bound
};

/// By triangle of a group: the normals, in the first or the second list, and upper bounds on the longest edges
/// throughout the step, divided as the normals; null without a separation.
struct FaceNormals {
  FaceNormal<4>* linear;
  FaceNormal<8>* quadratic;
  double* longest_edges;
};

/// A group of vertices and the boundary triangles at them, for the kernel: the corners of vertex v are
/// corners[begins[v] .. begins[v + 1]). `normals` is memory for those of all triangles.
struct RingGroup {
  Index begin, end;
  std::span<const std::array<Index, 3>> triangles;
  const RingCorner* corners;
  const Index* begins;
  Eigen::Vector3f* ups;
  std::uint8_t* folds;
  FaceNormals normals;
};

/// The boundary faces of a mesh. Normals are found for one group of consecutive vertices after another, so that they
/// remain in the cache, and once more for a face whose vertices are in several groups. Not thread-safe; uses the
/// executor.
class BoundaryRings {
 public:
  /// Replaces the faces. Every vertex that is tested is a vertex of a triangle. Throws Error if there are too many.
  void set_faces(const Mesh& mesh, std::span<const RingFace> faces);

  /// Sets folds[v] to 1 for each vertex v of the faces, unless the normals of all faces that are tested for v have
  /// positive dot products with the direction up(v), the rounded sum of the unit normals of its triangles, throughout
  /// the step. With a separation d > 0, also if some vertices are displaced by w/2, others by -w/2, and the rest not, for any w
  /// with |w| <= d: this changes a normal by the cross product of w and a vector that is no longer than its longest
  /// edge. Sets all others to 0.
  void find_folds(const Step& step, Executor& executor, std::vector<std::uint8_t>& folds);
  Vec3 up(Index v) const { return ups_[v].cast<double>(); }

  std::size_t bytes() const { return heap_bytes(triangles_, groups_, ups_, begins_, corners_, normals_); }

 private:
  /// Memory for the normals of a group.
  struct Normals {
    std::vector<FaceNormal<4>> linear;
    std::vector<FaceNormal<8>> quadratic;
    std::vector<double> longest_edges;
    FaceNormals resize(std::size_t triangles, const Step& step);
    std::size_t bytes() const { return heap_bytes(linear, quadratic, longest_edges); }
  };
  void group_triangles(std::span<const RingFace> faces);

  std::vector<std::array<Index, 3>> triangles_;  ///< of one group after the other
  std::vector<std::size_t> groups_ = {0};        ///< by group: where its triangles begin
  std::vector<Eigen::Vector3f> ups_;             ///< by vertex
  std::vector<Index> begins_;                    ///< by vertex: where its corners begin
  std::vector<RingCorner> corners_;              ///< of one vertex after the other
  std::vector<Normals> normals_;                 ///< by worker
};

}  // namespace volccd::detail
