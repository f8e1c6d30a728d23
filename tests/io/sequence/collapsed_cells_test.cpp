// Cells with repeated nodes, as finite-element programs write them, are read as the elements that they represent.
#include <gtest/gtest.h>

#include <set>

#include <volccd/io/sequence/reader.hpp>
#include <volccd/io/sequence/stepper.hpp>
#include <volccd/mesh/features.hpp>

#include "raw_hdf5.hpp"
#include "sequences.hpp"

namespace volccd::test {
namespace {

const std::string kGrid = "VTKHDF/";

/// Two steps of a shape that moves in the second one; ids of cells and points have gaps.
Sequence sequence_of(const Shape& shape) {
  Sequence sequence;
  for (std::size_t i = 0; i < shape.positions.size(); ++i)
    sequence.point_ids.push_back(10 + 2 * static_cast<std::int64_t>(i));
  for (int k = 0; k < 2; ++k) {
    Sequence::Step step{0.5 * k, {}, {}, {}, {}};
    for (const Vec3& p : shape.positions) step.points.push_back(p + k * Vec3(0.1, 0, 0.3));
    for (ElementSpec element : shape.elements) {
      element.id = 100 + 3 * element.id;
      element.object = static_cast<std::int32_t>(element.id % 2);
      step.cells.add(element);
    }
    sequence.steps.push_back(std::move(step));
  }
  return sequence;
}

/// Rewrites the cells of a file with one topology and no polytopes. `nodes` gives the nodes of a cell in its new type.
void rewrite_cells(const std::string& file, const std::vector<std::pair<ElementType, std::vector<Index>>>& cells) {
  RawFile raw(file);
  std::vector<std::int64_t> types, offsets{0}, connectivity;
  for (const auto& [type, nodes] : cells) {
    types.push_back(static_cast<std::int64_t>(type));
    connectivity.insert(connectivity.end(), nodes.begin(), nodes.end());
    offsets.push_back(static_cast<std::int64_t>(connectivity.size()));
  }
  raw.put(kGrid + "Types", {types.size()}, H5T_STD_U8LE, types);
  raw.put(kGrid + "Offsets", {offsets.size()}, H5T_STD_I64LE, offsets);
  raw.put(kGrid + "Connectivity", {connectivity.size()}, H5T_STD_I64LE, connectivity);
  raw.put(kGrid + "NumberOfConnectivityIds", {1}, H5T_STD_I64LE,
          std::vector<std::int64_t>{static_cast<std::int64_t>(connectivity.size())});
}

/// The element as another type with repeated nodes, as LS-DYNA writes it.
std::pair<ElementType, std::vector<Index>> widened(const ElementSpec& element) {
  const auto& v = element.vertices;
  switch (element.type) {
    case ElementType::wedge: return {ElementType::hexahedron, {v[0], v[3], v[5], v[2], v[1], v[4], v[4], v[1]}};
    case ElementType::pyramid: return {ElementType::hexahedron, {v[0], v[1], v[2], v[3], v[4], v[4], v[4], v[4]}};
    case ElementType::tetrahedron: return {ElementType::hexahedron, {v[0], v[1], v[2], v[3], v[3], v[3], v[3], v[3]}};
    case ElementType::triangle: return {ElementType::quad, {v[0], v[1], v[2], v[2]}};
    default: return {element.type, v};
  }
}

/// Triangles and edges by vertex ids, with the ids of their elements.
std::set<std::vector<std::int64_t>> feature_set(const Topology& topology) {
  std::set<std::vector<std::int64_t>> result;
  const Mesh& mesh = topology.mesh();
  const Features& features = topology.features();
  const auto add = [&](auto vertices, auto elements) {
    if (elements.empty()) return;
    std::vector<std::int64_t> key{-static_cast<std::int64_t>(vertices.size())}, ids;
    for (const Index v : vertices) key.push_back(mesh.vertex_id(v));
    for (const Index o : elements) ids.push_back(mesh.element_id(o));
    std::sort(ids.begin(), ids.end());
    key.insert(key.end(), ids.begin(), ids.end());
    result.insert(key);
  };
  for (Index t = 0; t < features.triangle_slots(); ++t) add(features.triangle(t), features.triangle_elements(t));
  for (Index e = 0; e < features.edge_slots(); ++e) add(features.edge(e), features.edge_elements(e));
  return result;
}

TEST(CollapsedCells, AreTheElementsThatTheyStandFor) {
  for (const ElementType type :
       {ElementType::wedge, ElementType::pyramid, ElementType::tetrahedron, ElementType::triangle}) {
    const ScratchFolder folder;
    const Shape shape = permuted(block(type, 2, 2, 2), 7);
    sequence_of(shape).write(folder / "plain");
    sequence_of(shape).write(folder / "widened");
    std::vector<std::pair<ElementType, std::vector<Index>>> cells;
    for (const ElementSpec& element : shape.elements) cells.push_back(widened(element));
    rewrite_cells(folder / "widened", cells);

    SequenceReader plain(folder / "plain"), wide(folder / "widened");
    SequenceCells expected, found;
    plain.read_cells(0, expected);
    EXPECT_TRUE(plain.collapsed_cells().empty());
    wide.read_cells(0, found);
    ASSERT_EQ(wide.collapsed_cells().size(), 1u);
    EXPECT_EQ(wide.collapsed_cells().begin()->first, std::pair(cells[0].first, type));
    EXPECT_EQ(wide.collapsed_cells().begin()->second, shape.elements.size());
    EXPECT_EQ(found.types, expected.types);
    EXPECT_EQ(found.offsets, expected.offsets);
    EXPECT_EQ(found.ids, expected.ids);
    EXPECT_EQ(found.objects, expected.objects);
    for (const EdgeSet edges : {EdgeSet::triangulated, EdgeSet::polytope}) {
      SequenceStepper::Config config;
      config.edge_set = edges;
      SequenceStepper a(plain, config), b(wide, config);
      a.go_to(0);
      b.go_to(0);
      EXPECT_EQ(feature_set(a.topology()), feature_set(b.topology())) << to_string(type);
    }
    // Elements that are read can be written.
    SequenceWriter writer(folder / "again", wide.point_ids(), {});
    std::vector<Vec3> points;
    wide.read_points(0, points);
    writer.write_frame(0, points, found, {});
    writer.finish();
    SequenceCells again;
    SequenceReader(folder / "again").read_cells(0, again);
    EXPECT_EQ(again, found);
  }
}

TEST(CollapsedCells, MixWithPolytopesOfTheFile) {
  const ScratchFolder folder;
  Shape shape = block(ElementType::hexahedron, 2, 1, 1);
  shape.append(block(ElementType::polytope, 1, 1, 1), 1);
  sequence_of(shape).write(folder / "s");
  {
    RawFile raw(folder / "s");
    // Nodes 0 and 4 of the first hexahedron are identified, which leaves seven nodes.
    raw.poke(kGrid + "Connectivity", 4, raw.integers(kGrid + "Connectivity")[0]);
  }
  SequenceReader reader(folder / "s");
  SequenceCells cells;
  reader.read_cells(1, cells);
  EXPECT_EQ(cells.types,
            (std::vector<ElementType>{ElementType::polytope, ElementType::hexahedron, ElementType::polytope}));
  EXPECT_EQ(cells.offsets, (std::vector<std::size_t>{0, 7, 15, 23}));
  ASSERT_EQ(cells.face_offsets.size(), 4u);
  EXPECT_TRUE(cells.face_stream(1).empty());
  EXPECT_EQ(cells.face_stream(2).size(), 30u);
  EXPECT_NO_THROW(Topology(mesh_of(reader.point_ids(), cells)));
}

/// Two columns of cells touch at step 0 and are one body. At step 1 the middle cells are removed, and the halves remain
/// one part.
TEST(ConnectedComponents, AreThoseOfAllSteps) {
  const ScratchFolder folder;
  Shape shape = block(ElementType::hexahedron, 3, 1, 1);
  shape.append(block(ElementType::tetrahedron, 1, 1, 1).translate(Vec3(0, 0, 5)), 0);
  Sequence sequence = sequence_of(shape);
  SequenceCells fewer;
  for (std::size_t i = 0; i < sequence.steps[1].cells.size(); ++i)
    if (i != 1) fewer.add(sequence.steps[1].cells.spec(i));
  sequence.steps[1].cells = fewer;
  sequence.write(folder / "s");
  SequenceReader reader(folder / "s");
  const ConnectedComponents parts(reader);
  EXPECT_EQ(parts.count(), 2);
  SequenceStepper::Config config;
  config.objects = ObjectModel::components;
  SequenceStepper stepper(reader, config);
  stepper.go_to(0);
  const Mesh& mesh = stepper.topology().mesh();
  EXPECT_EQ(mesh.element_count(), 8u);
  for (Index o = 0; o < mesh.element_slots(); ++o)
    EXPECT_EQ(mesh.object(o), mesh.type(o) == ElementType::hexahedron ? 0 : 1);
}

}  // namespace
}  // namespace volccd::test
