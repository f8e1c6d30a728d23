// The control points of an element in the layout of the projection kernels of CSAT.
#pragma once

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <span>

#include <volccd/numerics/rounding.hpp>
#include <volccd/numerics/step_interval.hpp>
#include <volccd/query/motion.hpp>
#include <volccd/query/step.hpp>

namespace volccd::detail {

inline constexpr int kCsatVertices = 32;
inline constexpr int kCsatControlPoints = 3;

/// The interval of the step that is tested, and the reference points from which differences are computed, one for each
/// control point.
struct CsatFrame {
  int control_points;
  StepInterval interval;
  double reference[3 * kCsatControlPoints] = {};

  CsatFrame(const Motion& motion, double t_max)
      : control_points(motion.control_points()), interval(t_max, control_points) {}
};

/// Differences of the vertices and the reference points: rows by (control point, axis), columns by vertex, padded to a
/// multiple of 4 with copies of the first vertex.
struct CsatPoints {
  int count = 0, stride = 4;
  double extent[3] = {};  ///< greatest magnitude on each axis over the whole step
  double total[3] = {};   ///< sum over all vertices and control points
  alignas(64) double rows[3 * kCsatControlPoints * kCsatVertices];

  const double* row(int control_point, int axis) const { return rows + (3 * control_point + axis) * stride; }
  double at(int control_point, int axis, int i) const { return row(control_point, axis)[i]; }

  template <int kControlPoints>
  void gather(const CsatFrame& frame, const Motion& motion, std::span<const Index> vertices) {
    constexpr int n = 3 * kControlPoints;
    count = static_cast<int>(vertices.size());
    stride = (count + 3) / 4 * 4;
    double greatest[n] = {}, sum[n] = {};
    for (int i = 0; i < count; ++i) {
      const double* p = motion.at(vertices[static_cast<std::size_t>(i)]);
      for (int k = 0; k < n; ++k) {
        const double difference = p[k] - frame.reference[k];
        rows[k * stride + i] = difference;
        greatest[k] = std::max(greatest[k], std::abs(difference));
        sum[k] += difference;
      }
    }
    for (int k = 0; k < n; ++k)
      for (int i = count; i < stride; ++i) rows[k * stride + i] = rows[k * stride];
    for (int k = 0; k < 3; ++k) {
      extent[k] = kMinExtent;
      total[k] = 0;
      for (int c = k; c < n; c += 3) {
        extent[k] = std::max(extent[k], greatest[c]);
        total[k] += sum[c];
      }
    }
  }
  /// Copies the vertices i0 and i1 of `from`; the extents are those of all vertices.
  void copy_vertices(const CsatPoints& from, int control_points, int i0, int i1) {
    count = i0 == i1 ? 1 : 2;
    stride = 4;
    std::copy(from.extent, from.extent + 3, extent);
    std::fill(total, total + 3, 0.0);
    for (int k = 0; k < 3 * control_points; ++k) {
      const double* source = from.rows + k * from.stride;
      double* to = rows + 4 * k;
      to[0] = to[2] = source[i0];
      to[1] = to[3] = source[i1];
      total[k % 3] += count == 1 ? source[i0] : source[i0] + source[i1];
    }
  }
};

/// The edges of an element, in a layout for testing all of them together: the local vertex numbers of their ends, and
/// their directions at t = 0. Padded to a multiple of 4 with copies of the last edge.
struct CsatEdges {
  static constexpr int kMax = 64;  ///< further edges are not tested (FeatureMask)

  int count = 0;
  std::uint8_t ends[2][kMax];
  alignas(64) double direction[3][kMax];

  void gather(const Step& step, Index o) {
    const auto edges = step.features().element_edges(o);
    const auto vertices = step.mesh().vertices(o);
    const auto local = [&](Index v) {
      return static_cast<std::uint8_t>(std::find(vertices.begin(), vertices.end(), v) - vertices.begin());
    };
    count = static_cast<int>(std::min<std::size_t>(edges.size(), kMax));
    for (int i = 0; i < (count + 3) / 4 * 4; ++i) {
      const auto& edge = step.features().edge(edges[static_cast<std::size_t>(std::min(i, count - 1))]);
      for (std::size_t end = 0; end < 2; ++end) ends[end][i] = local(edge[end]);
      for (int k = 0; k < 3; ++k) direction[k][i] = step.motion.at(edge[1])[k] - step.motion.at(edge[0])[k];
    }
  }
};

}  // namespace volccd::detail
