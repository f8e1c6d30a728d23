// Elements from plain arrays in VTK's layout.
#include <gtest/gtest.h>

#include <volccd/core/error.hpp>
#include <volccd/mesh/cell_arrays.hpp>
#include <volccd/oracle/cases/shapes.hpp>

namespace volccd {
namespace {

/// The arrays of a shape.
struct OwnedCells {
  std::vector<std::uint8_t> types;
  std::vector<std::int64_t> offsets = {0}, connectivity, ids, face_offsets = {0}, faces;
  std::vector<std::int32_t> objects;

  explicit OwnedCells(const Shape& shape) {
    for (const ElementSpec& element : shape.elements) {
      types.push_back(static_cast<std::uint8_t>(element.type));
      connectivity.insert(connectivity.end(), element.vertices.begin(), element.vertices.end());
      offsets.push_back(static_cast<std::int64_t>(connectivity.size()));
      faces.insert(faces.end(), element.faces.begin(), element.faces.end());
      face_offsets.push_back(static_cast<std::int64_t>(faces.size()));
      ids.push_back(3 * element.id + 7);
      objects.push_back(element.object + 2);
    }
  }

  CellArrays views() const {
    return {.types = types,
            .offsets = offsets,
            .connectivity = connectivity,
            .ids = ids,
            .objects = objects,
            .face_offsets = face_offsets,
            .faces = faces};
  }
};

TEST(CellArrays, MakeTheMeshOfTheSameElements) {
  const Shape shape = mixed_block(2, 1);
  const OwnedCells cells(shape);
  const auto vertices = static_cast<Index>(shape.positions.size());
  const Mesh mesh = mesh_of(vertices, cells.views());
  EXPECT_EQ(mesh.vertex_count(), vertices);
  EXPECT_EQ(mesh.vertex_id(vertices - 1), vertices - 1);
  ASSERT_EQ(mesh.element_count(), shape.elements.size());
  const std::vector<ElementSpec> elements = elements_of(cells.views());
  for (Index o = 0; o < mesh.element_count(); ++o)
    for (const ElementSpec& element : {mesh.spec(o), elements[o]}) {
      EXPECT_EQ(element.type, shape.elements[o].type);
      EXPECT_EQ(element.vertices, shape.elements[o].vertices);
      EXPECT_EQ(element.faces, shape.elements[o].faces);
      EXPECT_EQ(element.id, 3 * shape.elements[o].id + 7);
      EXPECT_EQ(element.object, shape.elements[o].object + 2);
    }
}

TEST(CellArrays, HaveDefaultsForIdsObjectsAndFaces) {
  const OwnedCells cells(block(ElementType::hexahedron, 3, 1, 1));
  const Mesh mesh = mesh_of(16, {.types = cells.types, .offsets = cells.offsets, .connectivity = cells.connectivity});
  for (Index o = 0; o < 3; ++o) {
    EXPECT_EQ(mesh.element_id(o), o);
    EXPECT_EQ(mesh.object(o), 0);
  }
  const std::int64_t none = 0;
  EXPECT_EQ(mesh_of(4, {.offsets = {&none, 1}}).element_count(), 0u);
}

TEST(CellArrays, ErrorsNameTheArrayAndTheIndex) {
  const Shape shape = mixed_block(1, 1);
  const auto expect = [&](const char* array, std::int64_t index, auto&& change) {
    OwnedCells cells(shape);
    change(cells);
    try {
      mesh_of(static_cast<Index>(shape.positions.size()), cells.views());
      ADD_FAILURE() << array << ": no error";
    } catch (const InputError& error) {
      EXPECT_EQ(error.dataset(), array) << error.what();
      EXPECT_EQ(error.index(), index) << error.what();
    }
  };
  expect("types", 3, [](OwnedCells& c) { c.types[3] = 7; });
  expect("offsets", -1, [](OwnedCells& c) { c.offsets.pop_back(); });
  expect("offsets", -1, [](OwnedCells& c) { c.offsets.clear(); });
  expect("offsets", 0, [](OwnedCells& c) { c.offsets[0] = -1; });
  expect("offsets", -1, [](OwnedCells& c) { c.offsets[0] = 1; });
  expect("offsets", 2, [](OwnedCells& c) { c.offsets[2] = c.offsets[1] - 1; });
  expect("offsets", 4, [](OwnedCells& c) { c.offsets[4] = 1 << 20; });
  expect("offsets", -1, [](OwnedCells& c) { c.connectivity.push_back(0); });
  expect("connectivity", 5, [](OwnedCells& c) { c.connectivity[5] = -1; });
  expect("connectivity", 6, [](OwnedCells& c) { c.connectivity[6] = std::int64_t{1} << 32; });
  expect("ids", -1, [](OwnedCells& c) { c.ids.pop_back(); });
  expect("objects", -1, [](OwnedCells& c) { c.objects.push_back(0); });
  expect("faces", 1, [](OwnedCells& c) { c.faces[1] = -2; });
  expect("face_offsets", -1, [](OwnedCells& c) { c.face_offsets.clear(); });
  expect("face_offsets", 1, [](OwnedCells& c) { c.face_offsets[1] = 1000000; });
  // Found by Mesh::add_element, which names the element.
  expect("elements", 7, [](OwnedCells& c) { c.connectivity[0] = 100000; });
  expect("elements", 7, [](OwnedCells& c) { c.ids[1] = 7, c.connectivity[0] = c.connectivity[1]; });
}

}  // namespace
}  // namespace volccd
