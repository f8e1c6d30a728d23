// The scenes on which every broad phase must be correct: all element types, and extreme geometry.
#pragma once

#include "broadphase/support.hpp"

namespace volccd::test {

/// Tetrahedra and triangles with vertices in the whole range of doubles; some share vertices with others.
inline Shape soup(std::size_t elements, std::uint64_t seed, double max_exponent) {
  std::mt19937_64 random(seed);
  std::uniform_real_distribution<double> sign(-1, 1), exponent(-323, max_exponent);
  Shape shape;
  for (std::size_t i = 0; i < 3 * elements; ++i) {
    Vec3 p;
    for (int c = 0; c < 3; ++c) p[c] = sign(random) * std::pow(10.0, exponent(random));
    shape.positions.push_back(p);
  }
  for (std::size_t i = 0; i < elements; ++i) {
    const ElementType type = i % 3 == 0 ? ElementType::triangle : ElementType::tetrahedron;
    ElementSpec spec{.type = type, .object = static_cast<std::int32_t>(i % 2), .id = static_cast<std::int64_t>(i)};
    std::set<Index> vertices;
    while (vertices.size() < static_cast<std::size_t>(vertex_count(type)))
      vertices.insert(static_cast<Index>(random() % shape.positions.size()));
    spec.vertices.assign(vertices.begin(), vertices.end());
    shape.elements.push_back(spec);
  }
  return shape;
}

inline Shape two_objects() {
  Shape shape = block(ElementType::tetrahedron, 2, 2, 2);
  Shape other = block(ElementType::hexahedron, 2, 2, 2);
  return shape.append(other.translate({1.5, 0.3, 0.2}), 1);
}

/// Blocks of small elements, and a few elements that span all blocks or are far away, which is unfavourable for a grid.
inline Shape with_outliers() {
  Shape shape = block(ElementType::tetrahedron, 4, 3, 3);
  for (int i = 0; i < 6; ++i) {
    Shape big = block(ElementType::tetrahedron, 1, 1, 1);
    big.elements.resize(1);
    big.positions = scaled(big.positions, std::pow(1000.0, i));
    shape.append(big.translate({-0.5, 0.1 * i, 1e5 * i * i}), 1 + i);
  }
  return shape;
}

/// Two tetrahedra that overlap by 2^-61 along x+y+z and by far more along all other axes. In doubles, 1 + 2^-60 - 1 is
/// 0: without a margin for sums of three terms, they would be found apart.
inline Shape cancellation() {
  Shape shape = block(ElementType::tetrahedron, 1, 1, 1);
  shape.elements.resize(2);
  shape.elements[0].vertices = {0, 1, 2, 3};
  shape.elements[1].vertices = {4, 5, 6, 7};
  shape.positions = {{1, 0x1p-60, -1}, {-1, 0, 1}, {0, -1, 1}, {0, 1, -1},
                     {0x1p-61, 0, 0},  {1, 1, 1},  {2, -1, 1}, {-1, 2, 1}};
  return shape;
}

inline std::vector<Scene> scenes() {
  std::vector<Scene> all;
  const auto add = [&](std::string name, const Shape& shape, std::vector<Vec3> x1, double separation) {
    all.push_back(make_scene(name, shape, x1));
    if (separation == 0) return;
    all.push_back(make_scene(name + ", separation", shape, x1));
    all.back().separation = separation;
  };
  for (ElementType type : {ElementType::tetrahedron, ElementType::pyramid, ElementType::wedge, ElementType::hexahedron,
                           ElementType::polytope, ElementType::triangle, ElementType::quad}) {
    const bool small = type == ElementType::tetrahedron || type == ElementType::pyramid;
    const Shape shape = permuted(small ? block(type, 3, 2, 2) : block(type, 6, 4, 3), 7);
    add(to_string(type), shape, jittered(shape.positions, 0.4, 1), 0.15);
  }
  const Shape mixed = permuted(mixed_block(2, 2), 3);
  add("mixed", mixed, jittered(mixed.positions, 0.8, 2), 0.3);
  add("at rest", mixed, mixed.positions, 0.25);
  const Shape two = two_objects();
  add("two objects", two, jittered(two.positions, 0.2, 3), 0.1);
  const Shape outliers = with_outliers();
  add("outliers", outliers, jittered(outliers.positions, 0.3, 4), 0.1);
  for (double scale : {1e-320, 1e-300, 1e-44, 1e-38, 1e30, 1e37, 1e38, 1e300, 5e307}) {
    Shape shape = mixed_block(1, 2);
    shape.translate({-2.5, -1, -1});
    const std::vector<Vec3> x1 = scaled(jittered(shape.positions, 0.4, 5), scale);
    shape.positions = scaled(shape.positions, scale);
    add("scale " + std::to_string(std::log10(scale)), shape, x1, 0.2 * scale);
  }
  Shape flat = block(ElementType::tetrahedron, 3, 3, 1);
  for (Vec3& p : flat.positions) p[2] = 1;
  add("flat", flat, jittered(flat.positions, 0, 6), 0.5);
  Shape point = block(ElementType::tetrahedron, 2, 2, 2);
  for (Vec3& p : point.positions) p = Vec3(0.1, 0.2, 0.3);
  add("one point", point, point.positions, 1);
  Shape far = mixed_block(2, 1);
  far.translate({1e8 / 3, -1e9 / 7, 1e7 / 11});
  add("far from the origin", far, jittered(far.positions, 0.4, 8), 0.1);
  add("cancellation", cancellation(), cancellation().positions, 0);
  add("soup", soup(120, 9, 308), soup(120, 10, 308).positions, 1e20);
  add("soup of floats", soup(120, 11, 30), soup(120, 12, 30).positions, 0);
  return all;
}

}  // namespace volccd::test
