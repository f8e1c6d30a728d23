// The surface of a sequence in which elements appear and disappear: one table of triangles, and the triangles of each
// frame.
#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <unordered_map>
#include <vector>

#include <volccd/io/sequence/cells.hpp>
#include <volccd/numerics/types.hpp>

namespace volccd {

struct TrackedTriangle {
  std::array<Index, 3> corners{};  ///< the smallest one first; the direction of rotation is the element's
  std::uint16_t object = 0;        ///< index into SurfaceTrack::objects()
  std::uint8_t element_edges = 7;  ///< as SurfaceTriangle has it
};

/// The data of an object that a viewer needs.
struct TrackedObject {
  std::int32_t id = 0;
  bool solid = false;  ///< has elements that are no shells, so that its surface is closed
};

/// Boundary triangles of the frames of a sequence, each once. Triangles are numbered in the order in which they first
/// occur.
class SurfaceTrack {
 public:
  /// Appends a frame. `cells` are its elements, `vertices` the vertex slots. O(cells) expected.
  void add(const SequenceCells& cells, std::size_t vertices);
  /// Appends a frame with the triangles of the last one.
  void repeat() { frames_.push_back(frames_.back()); }

  const std::vector<TrackedTriangle>& triangles() const { return triangles_; }
  const std::vector<TrackedObject>& objects() const { return objects_; }
  std::size_t frames() const { return frames_.size(); }
  /// Ascending indices into triangles().
  std::span<const std::uint32_t> frame(std::size_t f) const { return sets_[frames_[f]]; }
  /// Number of triangles of the frame with the most triangles.
  std::size_t largest_frame() const;

  /// Replaces vertices by the first vertex of their cell in a grid over `points`, in which each object has cells of its
  /// own, and leaves out triangles that lose a corner. `size` is the side of a grid cell. The same vertices are joined
  /// in all frames.
  SurfaceTrack clustered(std::span<const Vec3> points, double size) const;

 private:
  struct Hash {
    std::size_t operator()(const std::array<std::uint32_t, 4>& key) const;
  };
  std::uint16_t object_index(std::int32_t id, bool solid);
  void add_triangles(std::span<const TrackedTriangle> frame);

  std::vector<TrackedTriangle> triangles_;
  std::unordered_map<std::array<std::uint32_t, 4>, std::uint32_t, Hash> index_;
  std::vector<TrackedObject> objects_;
  std::vector<std::vector<std::uint32_t>> sets_;
  std::vector<std::size_t> frames_;  ///< into sets_
};

}  // namespace volccd
