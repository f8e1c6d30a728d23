// Bodies for topology edits, and checks after edits that are computed from the elements only.
#pragma once

#include <algorithm>
#include <array>
#include <map>
#include <numeric>
#include <set>
#include <vector>

#include <Eigen/Geometry>

#include <volccd/core/error.hpp>
#include <volccd/core/random.hpp>
#include <volccd/oracle/cases/shapes.hpp>
#include <volccd/simulation/topology/topology_proposal.hpp>

namespace volccd::simulation {

struct MovingMesh {
  explicit MovingMesh(const Shape& shape) : topology(shape.mesh()), x(shape.positions), v(x.size(), Vec3::Zero()) {}

  /// Applies the proposal as a time loop does.
  void apply(const TopologyProposal& proposal) {
    inherit(proposal, x);
    inherit(proposal, v);
    for (const MovedVertex& moved : proposal.moved) x[moved.vertex] = moved.position, v[moved.vertex] = moved.velocity;
    topology.apply(proposal.edit);
  }

  const Mesh& mesh() const { return topology.mesh(); }
  std::vector<Index> elements() const {
    std::vector<Index> live;
    for (Index o = 0; o < mesh().element_slots(); ++o)
      if (mesh().is_live(o)) live.push_back(o);
    return live;
  }

  Topology topology;
  std::vector<Vec3> x, v;
};

inline double tet_volume(const MovingMesh& body, Index o) {
  const auto t = body.mesh().vertices(o);
  const Vec3& a = body.x[t[0]];
  return (body.x[t[1]] - a).dot((body.x[t[2]] - a).cross(body.x[t[3]] - a)) / 6;
}

inline double total_volume(const MovingMesh& body) {
  double sum = 0;
  for (Index o : body.elements()) sum += tet_volume(body, o);
  return sum;
}

inline double min_volume(const MovingMesh& body) {
  double min = 1e300;
  for (Index o : body.elements()) min = std::min(min, tet_volume(body, o));
  return min;
}

/// Sets of elements that are connected by vertices.
inline std::vector<std::vector<Index>> components(const MovingMesh& body) {
  std::vector<Index> root(body.mesh().vertex_count());
  std::iota(root.begin(), root.end(), Index{0});
  const auto find = [&](Index v) {
    while (root[v] != v) v = root[v] = root[root[v]];
    return v;
  };
  for (Index o : body.elements())
    for (Index v : body.mesh().vertices(o)) root[find(v)] = find(body.mesh().vertices(o)[0]);
  std::map<Index, std::vector<Index>> sets;
  for (Index o : body.elements()) sets[find(body.mesh().vertices(o)[0])].push_back(o);
  std::vector<std::vector<Index>> result;
  for (auto& [v, set] : sets) result.push_back(set);
  return result;
}

/// The boundary of a body of tetrahedra. Where a boundary face coincides with another one, the body has been separated.
struct Boundary {
  double outer_area = 0, parted_area = 0;  ///< both sides of a separated face count
  int max_elements = 0;                    ///< of the elements at one face
  bool pairs = true;                       ///< coinciding faces occur in pairs with opposite orientations
  std::vector<std::array<Vec3, 3>> parted;
};

inline Boundary boundary_of(const MovingMesh& body) {
  std::map<std::array<Index, 3>, std::vector<std::array<Index, 3>>> faces;
  constexpr std::size_t kFaces[4][3] = {{0, 2, 1}, {0, 1, 3}, {1, 2, 3}, {0, 3, 2}};
  for (Index o : body.elements())
    for (const auto& f : kFaces) {
      const auto t = body.mesh().vertices(o);
      const std::array<Index, 3> face{t[f[0]], t[f[1]], t[f[2]]};
      std::array<Index, 3> key = face;
      std::sort(key.begin(), key.end());
      faces[key].push_back(face);
    }
  Boundary result;
  std::map<std::vector<std::array<double, 3>>, std::vector<std::array<Vec3, 3>>> by_place;
  for (const auto& [key, users] : faces) {
    result.max_elements = std::max(result.max_elements, static_cast<int>(users.size()));
    if (users.size() != 1) continue;
    std::array<Vec3, 3> corners;
    std::vector<std::array<double, 3>> place;
    for (std::size_t i = 0; i < 3; ++i) {
      corners[i] = body.x[users[0][i]];
      place.push_back({corners[i][0], corners[i][1], corners[i][2]});
    }
    std::sort(place.begin(), place.end());
    by_place[place].push_back(corners);
  }
  const auto normal = [](const std::array<Vec3, 3>& c) { return Vec3(0.5 * (c[1] - c[0]).cross(c[2] - c[0])); };
  for (const auto& [place, sides] : by_place)
    if (sides.size() == 1) {
      result.outer_area += normal(sides[0]).norm();
    } else {
      result.pairs &= sides.size() == 2 && normal(sides[0]).dot(normal(sides[1])) < 0;
      result.parted_area += normal(sides[0]).norm() + normal(sides[1]).norm();
      result.parted.push_back(sides[0]);
    }
  return result;
}

/// Vertices - edges + faces - elements of some tetrahedra, which is 1 if they form a ball and are conforming.
inline int euler_characteristic(const MovingMesh& body, const std::vector<Index>& elements) {
  std::set<std::vector<Index>> simplices;
  for (Index o : elements) {
    std::vector<Index> t(body.mesh().vertices(o).begin(), body.mesh().vertices(o).end());
    std::sort(t.begin(), t.end());
    for (unsigned subset = 1; subset < 16; ++subset) {
      std::vector<Index> simplex;
      for (unsigned i = 0; i < 4; ++i)
        if (subset >> i & 1) simplex.push_back(t[i]);
      simplices.insert(simplex);
    }
  }
  int sum = 0;
  for (const auto& simplex : simplices) sum += simplex.size() % 2 == 1 ? 1 : -1;
  return sum;
}

/// Lumped masses of tetrahedra of density 1.
inline std::vector<double> tet_masses(const MovingMesh& body) {
  std::vector<double> mass(body.mesh().vertex_count(), 0.0);
  for (Index o : body.elements())
    for (Index v : body.mesh().vertices(o)) mass[v] += tet_volume(body, o) / 4;
  return mass;
}

inline Vec3 momentum(const MovingMesh& body, const std::vector<double>& mass) {
  Vec3 sum = Vec3::Zero();
  for (std::size_t v = 0; v < mass.size(); ++v) sum += mass[v] * body.v[v];
  return sum;
}

/// Type, object and vertices of every element by its id.
inline std::map<std::int64_t, std::vector<Index>> by_id(const MovingMesh& body) {
  std::map<std::int64_t, std::vector<Index>> result;
  for (Index o : body.elements()) {
    auto& list = result[body.mesh().element_id(o)];
    list.assign(body.mesh().vertices(o).begin(), body.mesh().vertices(o).end());
    list.push_back(static_cast<Index>(body.mesh().type(o)));
    list.push_back(static_cast<Index>(body.mesh().object(o)));
  }
  return result;
}

}  // namespace volccd::simulation
