#include <volccd/simulation/topology/node_merging.hpp>

#include <algorithm>
#include <cassert>
#include <cmath>
#include <tuple>

#include <Eigen/Geometry>

namespace volccd::simulation {

namespace {

/// Least ratio of an element's new to its old volume (of a corner).
constexpr double kMinRatio = 0.1;

struct Candidate {
  double distance;
  Index a, b;  ///< a < b
};

/// Merging limits that satisfy all bodies at a vertex; never, if one of them is rigid.
struct Terms {
  double force = 0, distance = kNever;

  void tighten(const Terms& other) {
    force = std::max(force, other.force);
    distance = std::min(distance, other.distance);
  }
};

/// Neighbours of each corner of a hexahedron, such that corners of a good one have positive volume.
constexpr int kHexCorners[8][3] = {{1, 3, 4}, {2, 0, 5}, {3, 1, 6}, {0, 2, 7},
                                   {7, 5, 0}, {4, 6, 1}, {5, 7, 2}, {6, 4, 3}};

class Merger {
 public:
  Merger(const Topology& topology, std::span<const Body> bodies, std::span<const Vec3> positions)
      : topology_(topology),
        mesh_(topology.mesh()),
        bodies_(bodies),
        x_(positions),
        changed_(mesh_.vertex_count(), false) {}

  std::vector<Candidate> candidates(std::span<const LoadedContact> contacts) const;

  /// Whether a and b may merge to one vertex at `place`.
  bool allowed(const Candidate& pair, const Vec3& place) const;

  void merge(const Candidate& pair, TopologyProposal& proposal);

 private:
  Terms terms(Index v) const;
  std::span<const Index> elements(Index v) const { return topology_.features().vertex_elements(v); }
  bool has(Index o, Index v) const { return std::ranges::find(mesh_.vertices(o), v) != mesh_.vertices(o).end(); }
  bool changed_already(Index v) const;
  bool keeps_shape(Index o, Index v, const Vec3& place) const;
  bool faces_fit(const Candidate& pair, const Vec3& place) const;
  bool face_fits(Index o, Index p, const Candidate& pair, const Vec3& place) const;

  const Topology& topology_;
  const Mesh& mesh_;
  std::span<const Body> bodies_;
  std::span<const Vec3> x_;
  std::vector<bool> changed_;  ///< vertices of elements at those that have merged
};

Terms Merger::terms(Index v) const {
  if (elements(v).empty()) return {kNever, 0};
  Terms result;
  for (Index o : elements(v)) {
    const Body& body = bodies_[static_cast<std::size_t>(mesh_.object(o))];
    const ElementType type = mesh_.type(o);
    const bool suits =
        type == ElementType::tetrahedron || type == ElementType::hexahedron || type == ElementType::triangle;
    if (body.rigid || !suits) return {kNever, 0};
    result.tighten({body.material.merging_force, body.material.merging_distance});
  }
  return result;
}

std::vector<Candidate> Merger::candidates(std::span<const LoadedContact> contacts) const {
  std::vector<Candidate> found;
  for (const LoadedContact& loaded : contacts) {
    const std::size_t first = loaded.contact.kind == FeatureKind::vf ? 1 : 2;  // vertices of the first feature
    const auto& v = loaded.contact.vertices;
    for (std::size_t i = 0; i < first; ++i)
      for (std::size_t j = first; j < 4; ++j) {
        Terms limit = terms(v[i]);
        limit.tighten(terms(v[j]));
        const double distance = (x_[v[i]] - x_[v[j]]).norm();
        if (v[i] != v[j] && loaded.force > limit.force && distance < limit.distance)
          found.push_back({distance, std::min(v[i], v[j]), std::max(v[i], v[j])});
      }
  }
  std::sort(found.begin(), found.end(), [](const Candidate& p, const Candidate& q) {
    return std::tuple(p.distance, p.a, p.b) < std::tuple(q.distance, q.a, q.b);
  });
  return found;
}

bool Merger::changed_already(Index v) const {
  return std::ranges::any_of(elements(v), [&](Index o) {
    return std::ranges::any_of(mesh_.vertices(o), [&](Index w) { return bool{changed_[w]}; });
  });
}

bool Merger::allowed(const Candidate& pair, const Vec3& place) const {
  if (changed_already(pair.a) || changed_already(pair.b)) return false;
  const auto keep = [&](Index v) {
    return std::ranges::all_of(elements(v), [&](Index o) { return keeps_shape(o, v, place); });
  };
  return std::ranges::none_of(elements(pair.a), [&](Index o) { return has(o, pair.b); }) && keep(pair.a) &&
         keep(pair.b) && faces_fit(pair, place);
}

/// Whether the element keeps enough of its volume, and its orientation, if v moves to `place`.
bool Merger::keeps_shape(Index o, Index v, const Vec3& place) const {
  const std::span<const Index> vertices = mesh_.vertices(o);
  const auto corner = [&](std::size_t i, std::size_t j, std::size_t k, std::size_t l, bool moved) {
    const auto at = [&](std::size_t n) -> const Vec3& { return moved && vertices[n] == v ? place : x_[vertices[n]]; };
    return (at(j) - at(i)).dot((at(k) - at(i)).cross(at(l) - at(i)));
  };
  const auto enough = [](double before, double after) { return before != 0 && after / before >= kMinRatio; };
  if (mesh_.type(o) == ElementType::tetrahedron) return enough(corner(0, 1, 2, 3, false), corner(0, 1, 2, 3, true));
  if (mesh_.type(o) == ElementType::triangle) {
    const auto normal = [&](bool moved) {
      const auto at = [&](std::size_t n) -> const Vec3& { return moved && vertices[n] == v ? place : x_[vertices[n]]; };
      return Vec3((at(1) - at(0)).cross(at(2) - at(0)));
    };
    return enough(normal(false).squaredNorm(), normal(false).dot(normal(true)));
  }
  for (std::size_t i = 0; i < 8; ++i) {
    const auto [j, k, l] = kHexCorners[i];
    const auto volume = [&, j = j, k = k, l = l](bool moved) {
      return corner(i, static_cast<std::size_t>(j), static_cast<std::size_t>(k), static_cast<std::size_t>(l), moved);
    };
    if (!enough(volume(false), volume(true))) return false;
  }
  return true;
}

bool Merger::faces_fit(const Candidate& pair, const Vec3& place) const {
  return std::ranges::all_of(elements(pair.a), [&](Index o) {
    return std::ranges::all_of(elements(pair.b), [&](Index p) { return face_fits(o, p, pair, place); });
  });
}

/// Whether, after the merge, element o at a and element p at b share no face, or one that has them on its two sides and
/// no other element.
bool Merger::face_fits(Index o, Index p, const Candidate& pair, const Vec3& place) const {
  std::vector<Index> common;
  for (Index v : mesh_.vertices(o))
    if (has(p, v)) common.push_back(v);
  if (common.size() < 2) return true;
  if (mesh_.type(o) != mesh_.type(p) || is_shell(mesh_.type(o))) return false;
  const std::size_t others = mesh_.type(o) == ElementType::tetrahedron ? 2 : 3;  // of a face, with the merged one
  if (common.size() != others) return common.size() < others;
  const auto users = [&](Index v) {
    return std::ranges::count_if(
        elements(v), [&](Index q) { return std::ranges::all_of(common, [&](Index w) { return has(q, w); }); });
  };
  if (users(pair.a) != 1 || users(pair.b) != 1) return false;
  const Vec3 normal = (x_[common[0]] - place).cross(x_[common[1]] - place);
  const auto height = [&](Index q) {
    double sum = 0;
    for (Index v : mesh_.vertices(q))
      if (v != pair.a && v != pair.b) sum += normal.dot(x_[v] - place);
    return sum;
  };
  return height(o) * height(p) < 0;
}

void Merger::merge(const Candidate& pair, TopologyProposal& proposal) {
  for (Index v : {pair.a, pair.b})
    for (Index o : elements(v))
      for (Index w : mesh_.vertices(o)) changed_[w] = true;
  for (Index o : elements(pair.b)) {
    ElementSpec element = element_spec(mesh_, o);
    replace_vertex(element, pair.b, pair.a);
    replace_element(proposal, o, std::move(element));
  }
}

}  // namespace

TopologyProposal propose_merging(const Topology& topology, std::span<const Body> bodies,
                                 std::span<const LoadedContact> contacts, std::span<const Vec3> positions,
                                 std::span<const Vec3> velocities, std::span<const double> mass) {
  assert(positions.size() >= topology.mesh().vertex_count() && velocities.size() >= topology.mesh().vertex_count() &&
         mass.size() >= topology.mesh().vertex_count());
  TopologyProposal proposal;
  if (std::ranges::none_of(bodies, [](const Body& body) { return body.material.merging_force != kNever; }))
    return proposal;

  Merger merger(topology, bodies, positions);
  for (const Candidate& pair : merger.candidates(contacts)) {
    const double total = mass[pair.a] + mass[pair.b];
    if (!(total > 0)) continue;
    const double wa = mass[pair.a] / total, wb = mass[pair.b] / total;
    const Vec3 place = wa * positions[pair.a] + wb * positions[pair.b];
    if (!merger.allowed(pair, place)) continue;
    merger.merge(pair, proposal);
    proposal.moved.push_back({pair.a, place, wa * velocities[pair.a] + wb * velocities[pair.b]});
  }
  return proposal;
}

}  // namespace volccd::simulation
