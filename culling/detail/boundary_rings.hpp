// Tests whether the boundary around a vertex remains a graph over a plane throughout a step.
#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include <volccd/core/executor.hpp>
#include <volccd/query/step.hpp>

namespace volccd::detail {

/// A boundary triangle, and the vertices for which its normal is tested: bit i of `tested` is for vertex(i).
struct RingFace {
  std::array<Index, 3> triangle;  ///< oriented outward for elements of positive volume
  Index fourth = kNone;           ///< the other vertex of a quad face
  std::uint8_t tested = 0x7;

  Index vertex(std::size_t i) const { return i < 3 ? triangle[i] : fourth; }
};

/// The normals of the moving boundary faces as Bernstein coefficients, in a structure of arrays.
struct FaceNormals {
  int coefficients = 0;      ///< 3 for linear motion, 5 for quadratic
  std::size_t stride = 0;    ///< distance between rows, a multiple of 8
  std::vector<double> rows;  ///< [coefficient][axis][face], each coefficient times its binomial; then [face]: the error
                             ///< bound
  std::vector<double> units;  ///< [axis][face]: sum of the unit normals at both ends

  const double* row(int coefficient, int axis) const {
    return rows.data() + static_cast<std::size_t>(3 * coefficient + axis) * stride;
  }
  /// For any vector n, the error of dot(n, coefficient) is less than |n|_1 times this bound.
  const double* bounds() const { return row(coefficients, 0); }
};

/// Computes the normals of the faces [begin, end); `begin` is a multiple of 8. Compiled for each instruction set, with
/// the same results on all of them.
void face_normals(const Step& step, std::span<const RingFace> faces, std::size_t begin, std::size_t end,
                  FaceNormals& out);

/// The boundary faces of a mesh. Not thread-safe; uses the executor.
class BoundaryRings {
 public:
  /// Replaces the faces. Every vertex that is tested is a vertex of a triangle.
  void set_faces(const Mesh& mesh, std::vector<RingFace> faces);

  /// Sets folds[v] to 1 for each vertex v of the faces, unless the normals of all faces that are tested for v have
  /// positive dot products with the direction up(v), the sum of the unit normals of its triangles, throughout the step.
  /// Sets all others to 0.
  void find_folds(const Step& step, Executor& executor, std::vector<std::uint8_t>& folds);
  const Vec3& up(Index v) const { return ups_[v]; }

  std::size_t bytes() const;

 private:
  /// A face at a vertex, and whether the vertex is one of its triangle and is tested with it.
  struct Corner {
    Index face;
    bool of_triangle, tested;
  };

  bool folds_at(Index v);

  std::vector<RingFace> faces_;
  FaceNormals normals_;
  std::vector<Vec3> ups_;        ///< by vertex
  std::vector<Index> begins_;    ///< by vertex: where its corners begin
  std::vector<Corner> corners_;  ///< of one vertex after the other
};

}  // namespace volccd::detail
