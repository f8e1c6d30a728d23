#include <volccd/report/surface_track.hpp>

#include <algorithm>
#include <cmath>
#include <map>

#include <volccd/core/sort_unique.hpp>
#include <volccd/mesh/element_type.hpp>
#include <volccd/pictures/surface.hpp>

namespace volccd {

std::size_t SurfaceTrack::Hash::operator()(const std::array<std::uint32_t, 4>& key) const {
  std::uint64_t hash = 0xcbf29ce484222325u;
  for (const std::uint32_t word : key) hash = (hash ^ word) * 0x100000001b3u;
  return static_cast<std::size_t>(hash ^ hash >> 29);
}

std::uint16_t SurfaceTrack::object_index(std::int32_t id, bool solid) {
  const auto found = std::find_if(objects_.begin(), objects_.end(), [&](const TrackedObject& p) { return p.id == id; });
  if (found == objects_.end()) {
    objects_.push_back({id, solid});
    return static_cast<std::uint16_t>(objects_.size() - 1);
  }
  found->solid = found->solid || solid;
  return static_cast<std::uint16_t>(found - objects_.begin());
}

void SurfaceTrack::add(const SequenceCells& cells, std::size_t vertices) {
  std::vector<std::uint16_t> colours;
  colours.reserve(cells.size());
  std::map<std::pair<std::int32_t, bool>, std::uint16_t> known;
  for (std::size_t cell = 0; cell < cells.size(); ++cell) {
    const auto [at, fresh] = known.try_emplace({cells.objects[cell], !is_shell(cells.types[cell])});
    if (fresh) at->second = object_index(cells.objects[cell], !is_shell(cells.types[cell]));
    colours.push_back(at->second);
  }
  std::vector<TrackedTriangle> frame;
  for (const SurfaceTriangle& t : boundary_triangles(cells, vertices, colours))
    frame.push_back({t.corners, t.colour, t.element_edges});
  add_triangles(frame);
}

void SurfaceTrack::add_triangles(std::span<const TrackedTriangle> frame) {
  std::vector<std::uint32_t> set;
  set.reserve(frame.size());
  for (const TrackedTriangle& t : frame) {
    const auto [at, fresh] = index_.try_emplace({t.corners[0], t.corners[1], t.corners[2], t.object},
                                                static_cast<std::uint32_t>(triangles_.size()));
    if (fresh) triangles_.push_back(t);
    set.push_back(at->second);
  }
  sort_unique(set);
  frames_.push_back(sets_.size());
  sets_.push_back(std::move(set));
}

std::size_t SurfaceTrack::largest_frame() const {
  std::size_t largest = 0;
  for (const auto& set : sets_) largest = std::max(largest, set.size());
  return largest;
}

SurfaceTrack SurfaceTrack::clustered(std::span<const Vec3> points, double size) const {
  std::vector<std::uint16_t> object_of(points.size(), 0xffff);
  for (const TrackedTriangle& t : triangles_)
    for (const Index v : t.corners) object_of[v] = std::min(object_of[v], t.object);
  std::vector<Index> target(points.size(), kNone);
  std::map<std::array<std::int64_t, 4>, Index> grid;
  for (std::size_t v = 0; v < points.size(); ++v) {
    if (object_of[v] == 0xffff) continue;
    std::array<std::int64_t, 4> key{object_of[v], 0, 0, 0};
    for (int axis = 0; axis < 3; ++axis) key[axis + 1] = static_cast<std::int64_t>(std::floor(points[v][axis] / size));
    target[v] = grid.try_emplace(key, static_cast<Index>(v)).first->second;
  }
  SurfaceTrack result;
  result.objects_ = objects_;
  for (const auto& set : sets_) {
    std::vector<TrackedTriangle> frame;
    for (const std::uint32_t i : set) {
      TrackedTriangle t = triangles_[i];
      for (Index& v : t.corners) v = target[v];
      if (t.corners[0] == t.corners[1] || t.corners[1] == t.corners[2] || t.corners[2] == t.corners[0]) continue;
      std::rotate(t.corners.begin(), std::min_element(t.corners.begin(), t.corners.end()), t.corners.end());
      t.element_edges = 7;
      frame.push_back(t);
    }
    result.add_triangles(frame);
  }
  result.frames_ = frames_;
  return result;
}

}  // namespace volccd
