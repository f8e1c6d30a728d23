// Small scenes with plenty of contacts, of every element type.
#pragma once

#include <string>
#include <vector>

#include <volccd/core/random.hpp>
#include <volccd/mesh/topology.hpp>
#include <volccd/oracle/cases/shapes.hpp>
#include <volccd/query/motion.hpp>

namespace volccd::cases {

struct Scene {
  std::string name;
  Topology topology;
  Motion motion;
};

/// Two objects with permuted ids. The second moves down onto the first, and all vertices are displaced at random at
/// both ends, so that elements invert and neighbours collide, too.
inline Scene colliding(const std::string& name, const Shape& shape, std::uint64_t seed, double jitter) {
  Shape both;
  both.append(shape, 1);
  Shape other = shape;
  double height = 0;
  for (const Vec3& p : shape.positions) height = std::max(height, p.z());
  other.translate(Vec3(0.31, 0.27, height + 0.4));
  both.append(other, 2);
  const Index first_of_second = static_cast<Index>(shape.positions.size());
  // The permutation mixes the vertices of the objects, so that the second object has to be moved before it.
  Shape end = both;
  for (Index v = first_of_second; v < end.positions.size(); ++v) end.positions[v] += Vec3(0.1, -0.05, -0.9);
  const Shape start_permuted = permuted(both, seed), end_permuted = permuted(end, seed);
  return {name, Topology(start_permuted.mesh()),
          Motion::linear(jittered(start_permuted.positions, jitter, seed + 1),
                         jittered(end_permuted.positions, jitter, seed + 2))};
}

/// One scene for each element type, and one with all types.
inline std::vector<Scene> small_scenes(std::uint64_t seed, double jitter) {
  std::vector<Scene> scenes;
  for (const ElementType type :
       {ElementType::tetrahedron, ElementType::pyramid, ElementType::wedge, ElementType::hexahedron,
        ElementType::polytope, ElementType::triangle, ElementType::quad})
    scenes.push_back(colliding(to_string(type), block(type, 2, 2, 1), seed, jitter));
  scenes.push_back(colliding("mixed", mixed_block(1, 1), seed, jitter));
  return scenes;
}

}  // namespace volccd::cases
