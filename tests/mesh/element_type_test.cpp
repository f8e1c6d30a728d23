#include <gtest/gtest.h>

#include <map>

#include <Eigen/Geometry>

#include <volccd/mesh/detail/element_tables.hpp>
#include <volccd/mesh/element_type.hpp>

namespace volccd {
namespace {

/// An element of positive volume in VTK's node order.
const std::map<ElementType, std::vector<Vec3>>& canonical() {
  static const std::map<ElementType, std::vector<Vec3>> positions = {
      {ElementType::tetrahedron, {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, 0, 1}}},
      {ElementType::pyramid, {{0, 0, 0}, {1, 0, 0}, {1, 1, 0}, {0, 1, 0}, {.5, .5, 1}}},
      {ElementType::wedge, {{0, 0, 0}, {0, 1, 0}, {1, 0, 0}, {0, 0, 1}, {0, 1, 1}, {1, 0, 1}}},
      {ElementType::hexahedron,
       {{0, 0, 0}, {1, 0, 0}, {1, 1, 0}, {0, 1, 0}, {0, 0, 1}, {1, 0, 1}, {1, 1, 1}, {0, 1, 1}}}};
  return positions;
}

std::vector<std::vector<std::size_t>> faces(ElementType type) {
  std::vector<std::vector<std::size_t>> result;
  const auto stream = face_stream(type);
  for (std::size_t at = 0; at < stream.size(); at += stream[at] + 1u)
    result.emplace_back(stream.begin() + static_cast<std::ptrdiff_t>(at + 1),
                        stream.begin() + static_cast<std::ptrdiff_t>(at + 1 + stream[at]));
  return result;
}

TEST(ElementType, FacesLieOnTheHullAndPointOutward) {
  for (const auto& [type, x] : canonical()) {
    EXPECT_EQ(vertex_count(type), static_cast<int>(x.size()));
    for (const auto& face : faces(type)) {
      const Vec3 normal = (x[face[1]] - x[face[0]]).cross(x[face[2]] - x[face[0]]);
      for (std::size_t v = 0; v < x.size(); ++v) {
        const double side = normal.dot(x[v] - x[face[0]]);
        const bool on_face = std::find(face.begin(), face.end(), v) != face.end();
        EXPECT_TRUE(on_face ? std::abs(side) < 1e-12 : side < -1e-3) << to_string(type) << " vertex " << v;
      }
    }
  }
}

TEST(ElementType, FacesCloseUpAndEdgesAreTheirSides) {
  for (const auto& [type, x] : canonical()) {
    std::map<std::pair<std::size_t, std::size_t>, int> sides;  // directed
    for (const auto& face : faces(type))
      for (std::size_t i = 0; i < face.size(); ++i) ++sides[{face[i], face[(i + 1) % face.size()]}];
    for (const auto& [side, count] : sides) {
      EXPECT_EQ(count, 1);
      EXPECT_EQ(sides.count({side.second, side.first}), 1u) << to_string(type);
    }
    const detail::ElementTable& table = detail::element_table(type);
    EXPECT_EQ(sides.size(), 2u * table.edges);
    for (std::size_t e = 0; e < table.edges; ++e)
      EXPECT_EQ(sides.erase({table.edge[e][0], table.edge[e][1]}) + sides.erase({table.edge[e][1], table.edge[e][0]}),
                2u);
    EXPECT_TRUE(sides.empty());
  }
}

TEST(ElementType, KnowsVtkNumbers) {
  int known = 0;
  for (int type = -300; type < 300; ++type) known += is_element_type(type);
  EXPECT_EQ(known, 7);
  for (int type : {5, 9, 10, 12, 13, 14, 42}) {
    EXPECT_TRUE(is_element_type(type));
    EXPECT_STRNE(to_string(static_cast<ElementType>(type)), "unknown");
  }
  EXPECT_TRUE(is_shell(ElementType::quad) && is_shell(ElementType::triangle));
  EXPECT_FALSE(is_shell(ElementType::tetrahedron) || is_shell(ElementType::polytope));
  EXPECT_EQ(vertex_count(ElementType::polytope), 0);
}

}  // namespace
}  // namespace volccd
