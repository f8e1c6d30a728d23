#include <volccd/pipelines/lists/detail/local_candidates.hpp>

#include <algorithm>
#include <cmath>
#include <limits>

#include <volccd/core/sort_unique.hpp>

namespace volccd::detail {

namespace {

constexpr double kInfinity = std::numeric_limits<double>::infinity();

/// The box around all positions of an element; its coordinates are those of control points, without rounding.
template <class Box>
Box box_of(const Mesh& mesh, const Motion& motion, Index o) {
  Box box{Vec3::Constant(kInfinity), Vec3::Constant(-kInfinity)};
  for (const Index v : mesh.vertices(o))
    for (int i = 0; i < motion.control_points(); ++i) {
      const Vec3 p = motion.point(v, i);
      box.low = box.low.cwiseMin(p);
      box.high = box.high.cwiseMax(p);
    }
  return box;
}

template <class Box>
bool overlap(const Box& a, const Box& b) {
  return (a.low.array() <= b.high.array()).all() && (b.low.array() <= a.high.array()).all();
}

}  // namespace

bool LocalCandidates::find(const Pipeline& pipeline, const Step& step, std::span<const Index> vertices,
                           Executor& executor, TestBatch& tests) {
  own_.clear();
  for (const Index v : vertices) {
    const std::span<const Index> star = step.features().vertex_elements(v);
    own_.insert(own_.end(), star.begin(), star.end());
  }
  sort_unique(own_);
  if (own_.size() > kMaxElements) return false;
  if (own_.empty()) return true;
  find_near(step);
  number_vertices(step.mesh());
  const Topology topology = local_topology(step.topology, executor);
  const Motion motion = local_motion(step.motion);
  const ObjectFilter all;
  Workspace workspace = pipeline.make_workspace();
  StepResult result;
  TestBatch found;
  pipeline.run({.topology = topology, .motion = motion, .filter = all, .separation = step.separation}, workspace,
               executor, result, {.count_adjacent = false, .candidates = &found});
  append(step, topology.features(), found, vertices, tests);
  return true;
}

/// Sets near_ to the elements whose boxes come within the separation of those of own_.
void LocalCandidates::find_near(const Step& step) {
  std::vector<Box> boxes;
  Box whole{Vec3::Constant(kInfinity), Vec3::Constant(-kInfinity)};
  for (const Index o : own_) {
    Box box = box_of<Box>(step.mesh(), step.motion, o);
    for (int k = 0; k < 3; ++k) {
      box.low[k] = std::nextafter(box.low[k] - step.separation, -kInfinity);
      box.high[k] = std::nextafter(box.high[k] + step.separation, kInfinity);
    }
    whole = {whole.low.cwiseMin(box.low), whole.high.cwiseMax(box.high)};
    boxes.push_back(box);
  }
  near_.clear();
  for (Index o = 0; o < step.mesh().element_slots(); ++o) {
    if (!step.mesh().is_live(o)) continue;
    const Box box = box_of<Box>(step.mesh(), step.motion, o);
    if (overlap(box, whole) && std::ranges::any_of(boxes, [&](const Box& own) { return overlap(box, own); }))
      near_.push_back(o);
  }
}

void LocalCandidates::number_vertices(const Mesh& mesh) {
  for (const Index v : vertices_) local_[v] = kNone;
  vertices_.clear();
  for (const Index o : near_) vertices_.insert(vertices_.end(), mesh.vertices(o).begin(), mesh.vertices(o).end());
  sort_unique(vertices_);
  local_.resize(mesh.vertex_count(), kNone);
  for (Index i = 0; i < vertices_.size(); ++i) local_[vertices_[i]] = i;
}

/// Vertices keep their order, which determines the diagonals of faces.
Topology LocalCandidates::local_topology(const Topology& whole, Executor& executor) const {
  Mesh mesh;
  std::vector<std::int64_t> ids;
  for (const Index v : vertices_) ids.push_back(whole.mesh().vertex_id(v));
  mesh.add_vertices(ids);
  for (const Index o : near_) {
    ElementSpec spec = whole.mesh().spec(o);
    spec.renumber([&](Index v) { return local_[v]; });
    mesh.add_element(spec);
  }
  return Topology(std::move(mesh), executor, whole.features().edge_set());
}

Motion LocalCandidates::local_motion(const Motion& whole) const {
  Motion motion(static_cast<Index>(vertices_.size()), whole.control_points());
  for (Index i = 0; i < vertices_.size(); ++i)
    for (int c = 0; c < whole.control_points(); ++c) motion.set(i, c, whole.point(vertices_[i], c));
  return motion;
}

/// Appends those of the tests found that have one of the vertices, by their slots in the whole mesh.
void LocalCandidates::append(const Step& step, const Features& local, const TestBatch& found,
                             std::span<const Index> vertices, TestBatch& tests) const {
  std::vector<std::uint8_t> wanted(vertices_.size(), 0);
  for (const Index v : vertices)
    if (local_[v] != kNone) wanted[local_[v]] = 1;
  const Features& features = step.features();
  const auto append_kind = [&](FeatureKind kind, const std::vector<FeaturePair>& list, std::vector<FeaturePair>& out) {
    for (const FeaturePair pair : list) {
      std::array<Index, 4> v = test_vertices(local, kind, pair);
      if (std::ranges::none_of(v, [&](Index i) { return wanted[i] != 0; })) continue;
      for (Index& i : v) i = vertices_[i];
      if (kind == FeatureKind::vf) {
        out.push_back({v[0], features.find_triangle(v[1], v[2], v[3])});
      } else {
        const Index a = features.find_edge(v[0], v[1]), b = features.find_edge(v[2], v[3]);
        out.push_back({std::min(a, b), std::max(a, b)});
      }
    }
  };
  append_kind(FeatureKind::vf, found.vf, tests.vf);
  append_kind(FeatureKind::ee, found.ee, tests.ee);
}

}  // namespace volccd::detail
