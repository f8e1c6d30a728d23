// Whether the boundary around a vertex stays a graph over a plane all through a step.
#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include <volccd/core/executor.hpp>
#include <volccd/culling/detail/star_table.hpp>
#include <volccd/query/step.hpp>

namespace volccd::detail {

/// The moving normals of boundary faces, as Bernstein coefficients, in structure of arrays.
struct FaceNormals {
  static constexpr int kMostCoefficients = 5;

  int coefficients = 0;      ///< 3 for linear motion, 5 for quadratic
  std::size_t stride = 0;    ///< distance of rows, a multiple of 8
  std::vector<double> rows;  ///< [coefficient][axis][face], each coefficient times its binomial; then [face]: the bound
  std::vector<double> units;  ///< [axis][face]: sum of the unit normals at both ends

  const double* row(int coefficient, int axis) const {
    return rows.data() + static_cast<std::size_t>(3 * coefficient + axis) * stride;
  }
  /// For any vector n, dot(n, coefficient) is off by less than |n|_1 times this.
  const double* bounds() const { return row(coefficients, 0); }
};

/// Compiled for each instruction set; the same results on all of them. `begin` is a multiple of 8.
void face_normals(const Step& step, std::span<const std::array<Index, 3>> faces, std::size_t begin, std::size_t end,
                  FaceNormals& out);

/// The boundary faces of a complex. One thread at a time; uses the executor.
class BoundaryRings {
 public:
  /// Faces that have a vertex with a ring: to be called when the table has changed.
  void collect(const Topology& topology, const StarTable& stars);

  /// folds[v] = 1 for each vertex v with a ring whose faces do not keep a positive product of their normals with one
  /// direction all through the step; else 0. The direction is up(v), the sum of unit normals.
  void find_folds(const Step& step, Executor& executor, std::vector<std::uint8_t>& folds);
  const Vec3& up(Index v) const { return ups_[v]; }

  std::size_t bytes() const;

 private:
  std::vector<std::array<Index, 3>> faces_;  ///< oriented outward for positive volumes
  FaceNormals normals_;
  std::vector<Vec3> ups_;             ///< by vertex
  std::vector<std::uint8_t> failed_;  ///< by face: bits of its vertices
};

}  // namespace volccd::detail
