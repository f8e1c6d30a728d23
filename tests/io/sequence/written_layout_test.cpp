// Compares each dataset of a written file with the published layout, using plain HDF5 calls only.
#include <gtest/gtest.h>

#include "raw_hdf5.hpp"
#include "sequences.hpp"

namespace volccd::test {
namespace {

struct Expected {
  std::string path;
  hid_t type;
  std::vector<hsize_t> shape;
};

/// Without polytopes, which are an extension of the layout; with thickness and velocity in all steps.
Sequence plain_sequence() {
  std::mt19937_64 random(11);
  Sequence sequence;
  const Shape shape = block(ElementType::hexahedron, 4, 3, 2).append(block(ElementType::quad, 3, 3, 1), 1);
  for (std::size_t i = 0; i < shape.positions.size(); ++i)
    sequence.point_ids.push_back(static_cast<std::int64_t>(2 * i + 1));
  for (int k = 0; k < 5; ++k) {
    Sequence::Step step{0.5 * k, shape.positions, shape.positions, {}, {}};
    // Steps 0 and 1 share their cells, and so do steps 3 and 4.
    const std::size_t dead = k < 2 ? 0 : k == 2 ? 3 : 7;
    for (std::size_t i = dead; i < shape.elements.size(); ++i) step.cells.add(shape.elements[i]);
    step.thickness.assign(step.cells.size(), 0.25 * k);
    for (Vec3& p : step.points) p += Vec3(0.1 * k, 0, 0);
    sequence.steps.push_back(step);
  }
  return sequence;
}

bool filtered(const RawFile& raw, const std::string& path) {
  const hid_t creation = H5Dget_create_plist(raw.open(path));
  bool shuffled = false, deflated = false;
  for (int i = 0; i < H5Pget_nfilters(creation); ++i) {
    std::size_t values = 0;
    unsigned flags = 0;
    const H5Z_filter_t filter =
        H5Pget_filter2(creation, static_cast<unsigned>(i), &flags, &values, nullptr, 0, nullptr, nullptr);
    shuffled |= filter == H5Z_FILTER_SHUFFLE;
    deflated |= filter == H5Z_FILTER_DEFLATE && shuffled;
  }
  return deflated;
}

TEST(SequenceLayout, DatasetsTypesShapesFilters) {
  const ScratchFolder folder;
  const Sequence s = plain_sequence();
  s.write(folder / "s.vtkhdf", {"T", "S", "L", "U", "TU", {{1, "one"}}});
  const RawFile raw(folder / "s.vtkhdf");
  const hsize_t n = s.point_ids.size(), steps = 5, topologies = 3;
  hsize_t cells = 0, nodes = 0, shells = 0;
  for (const std::size_t k : {0u, 2u, 3u}) {
    cells += s.steps[k].cells.size();
    nodes += s.steps[k].cells.connectivity.size();
  }
  for (const auto& step : s.steps) shells += step.cells.size();
  const hid_t i64 = H5T_STD_I64LE, f64 = H5T_IEEE_F64LE;
  const std::vector<Expected> expected = {{"VTKHDF/NumberOfPoints", i64, {topologies}},
                                          {"VTKHDF/NumberOfCells", i64, {topologies}},
                                          {"VTKHDF/NumberOfConnectivityIds", i64, {topologies}},
                                          {"VTKHDF/Points", f64, {steps * n, 3}},
                                          {"VTKHDF/Connectivity", i64, {nodes}},
                                          {"VTKHDF/Offsets", i64, {cells + topologies}},
                                          {"VTKHDF/Types", H5T_STD_U8LE, {cells}},
                                          {"VTKHDF/PointData/GlobalPointIds", i64, {n}},
                                          {"VTKHDF/PointData/Velocity", f64, {steps * n, 3}},
                                          {"VTKHDF/CellData/PartId", H5T_STD_I32LE, {cells}},
                                          {"VTKHDF/CellData/GlobalCellIds", i64, {cells}},
                                          {"VTKHDF/CellData/Thickness", f64, {shells}},
                                          {"VTKHDF/Steps/Values", f64, {steps}},
                                          {"VTKHDF/Steps/PartOffsets", i64, {steps}},
                                          {"VTKHDF/Steps/NumberOfParts", i64, {steps}},
                                          {"VTKHDF/Steps/PointOffsets", i64, {steps}},
                                          {"VTKHDF/Steps/CellOffsets", i64, {steps, 1}},
                                          {"VTKHDF/Steps/ConnectivityIdOffsets", i64, {steps, 1}},
                                          {"VTKHDF/Steps/PointDataOffsets/GlobalPointIds", i64, {steps}},
                                          {"VTKHDF/Steps/PointDataOffsets/Velocity", i64, {steps}},
                                          {"VTKHDF/Steps/CellDataOffsets/PartId", i64, {steps}},
                                          {"VTKHDF/Steps/CellDataOffsets/GlobalCellIds", i64, {steps}},
                                          {"VTKHDF/Steps/CellDataOffsets/Thickness", i64, {steps}}};
  std::set<std::string> paths = {"VTKHDF",
                                 "VTKHDF/PointData",
                                 "VTKHDF/CellData",
                                 "VTKHDF/Steps",
                                 "VTKHDF/Steps/PointDataOffsets",
                                 "VTKHDF/Steps/CellDataOffsets"};
  for (const Expected& e : expected) {
    SCOPED_TRACE(e.path);
    paths.insert(e.path);
    EXPECT_EQ(raw.shape(e.path), e.shape);
    EXPECT_GT(H5Tequal(H5Dget_type(raw.open(e.path)), e.type), 0);
    if (raw.count(e.path) > 64) {
      EXPECT_TRUE(filtered(raw, e.path));
    }
  }
  EXPECT_EQ(raw.objects(), paths);
}

void expect_text(const RawFile& raw, const char* object, const char* name, const std::string& text) {
  SCOPED_TRACE(name);
  const hid_t attribute = H5Aopen_by_name(raw.id(), object, name, H5P_DEFAULT, H5P_DEFAULT);
  ASSERT_GE(attribute, 0);
  const hid_t type = H5Aget_type(attribute);
  EXPECT_EQ(H5Tget_class(type), H5T_STRING);
  EXPECT_EQ(H5Tis_variable_str(type), 0);
  EXPECT_EQ(H5Tget_cset(type), H5T_CSET_ASCII);
  EXPECT_EQ(H5Tget_size(type), text.size());
  EXPECT_EQ(H5Sget_simple_extent_type(H5Aget_space(attribute)), H5S_SCALAR);
  std::string stored(text.size(), ' ');
  H5Aread(attribute, type, stored.data());
  EXPECT_EQ(stored, text);
}

TEST(SequenceLayout, Attributes) {
  const ScratchFolder folder;
  plain_sequence().write(folder / "s.vtkhdf", {"T", "S", "L", "U", "TU", {{1, "one"}, {2, "two"}}});
  const RawFile raw(folder / "s.vtkhdf");
  expect_text(raw, "VTKHDF", "Type", "UnstructuredGrid");
  expect_text(raw, "/", "Title", "T");
  expect_text(raw, "/", "Source", "S");
  expect_text(raw, "/", "License", "L");
  expect_text(raw, "/", "Units", "U");
  expect_text(raw, "/", "TimeUnit", "TU");
  expect_text(raw, "/", "Parts", "1 one; 2 two");

  std::int64_t version[2], steps;
  const hid_t v = H5Aopen_by_name(raw.id(), "VTKHDF", "Version", H5P_DEFAULT, H5P_DEFAULT);
  EXPECT_GT(H5Tequal(H5Aget_type(v), H5T_STD_I64LE), 0);
  ASSERT_EQ(H5Sget_simple_extent_npoints(H5Aget_space(v)), 2);
  H5Aread(v, H5T_NATIVE_INT64, version);
  EXPECT_EQ(version[0], 2);
  EXPECT_EQ(version[1], 2);
  const hid_t n = H5Aopen_by_name(raw.id(), "VTKHDF/Steps", "NSteps", H5P_DEFAULT, H5P_DEFAULT);
  EXPECT_GT(H5Tequal(H5Aget_type(n), H5T_STD_I64LE), 0);
  EXPECT_EQ(H5Sget_simple_extent_type(H5Aget_space(n)), H5S_SCALAR);
  H5Aread(n, H5T_NATIVE_INT64, &steps);
  EXPECT_EQ(steps, 5);
}

/// Reads every step according to the rules of the layout.
TEST(SequenceLayout, AddressesOfEveryStep) {
  const ScratchFolder folder;
  const Sequence s = plain_sequence();
  s.write(folder / "s.vtkhdf");
  const RawFile raw(folder / "s.vtkhdf");
  const auto table = [&](const std::string& name, std::size_t k) {
    return static_cast<std::size_t>(raw.integers("VTKHDF/Steps/" + name)[k]);
  };
  const auto types = raw.integers("VTKHDF/Types"), offsets = raw.integers("VTKHDF/Offsets"),
             connectivity = raw.integers("VTKHDF/Connectivity"), ids = raw.integers("VTKHDF/CellData/GlobalCellIds"),
             parts = raw.integers("VTKHDF/CellData/PartId");
  const auto points = raw.reals("VTKHDF/Points"), velocity = raw.reals("VTKHDF/PointData/Velocity"),
             thickness = raw.reals("VTKHDF/CellData/Thickness");
  EXPECT_EQ(raw.integers("VTKHDF/PointData/GlobalPointIds"), s.point_ids);
  const std::vector<std::size_t> topology = {0, 0, 1, 2, 2};
  for (std::size_t k = 0; k < s.steps.size(); ++k) {
    SCOPED_TRACE(k);
    const Sequence::Step& step = s.steps[k];
    const std::size_t b = table("PartOffsets", k), cell = table("CellOffsets", k),
                      node = table("ConnectivityIdOffsets", k);
    EXPECT_EQ(b, topology[k]);
    EXPECT_EQ(table("NumberOfParts", k), 1u);
    EXPECT_EQ(raw.reals("VTKHDF/Steps/Values")[k], step.time);
    EXPECT_EQ(raw.integers("VTKHDF/NumberOfPoints")[b], static_cast<std::int64_t>(s.point_ids.size()));
    ASSERT_EQ(raw.integers("VTKHDF/NumberOfCells")[b], static_cast<std::int64_t>(step.cells.size()));
    ASSERT_EQ(raw.integers("VTKHDF/NumberOfConnectivityIds")[b],
              static_cast<std::int64_t>(step.cells.connectivity.size()));
    EXPECT_EQ(table("PointDataOffsets/GlobalPointIds", k), 0u);
    for (std::size_t i = 0; i < step.points.size(); ++i)
      for (std::size_t c = 0; c < 3; ++c) {
        EXPECT_EQ(points[3 * (table("PointOffsets", k) + i) + c], step.points[i][static_cast<int>(c)]);
        EXPECT_EQ(velocity[3 * (table("PointDataOffsets/Velocity", k) + i) + c], step.velocity[i][static_cast<int>(c)]);
      }
    const std::size_t id_row = table("CellDataOffsets/GlobalCellIds", k), part_row = table("CellDataOffsets/PartId", k),
                      thickness_row = table("CellDataOffsets/Thickness", k);
    for (std::size_t i = 0; i < step.cells.size(); ++i) {
      EXPECT_EQ(types[cell + i], static_cast<std::int64_t>(step.cells.types[i]));
      EXPECT_EQ(ids[id_row + i], step.cells.ids[i]);
      EXPECT_EQ(parts[part_row + i], step.cells.objects[i]);
      EXPECT_EQ(thickness[thickness_row + i], step.thickness[i]);
    }
    for (std::size_t i = 0; i <= step.cells.size(); ++i)
      EXPECT_EQ(offsets[cell + b + i], static_cast<std::int64_t>(step.cells.offsets[i]));
    for (std::size_t i = 0; i < step.cells.connectivity.size(); ++i)
      EXPECT_EQ(connectivity[node + i], static_cast<std::int64_t>(step.cells.connectivity[i]));
  }
}

TEST(SequenceLayout, PolytopesAreThoseOfVtkHdf25) {
  const ScratchFolder folder;
  Sequence s;
  const Shape shape = block(ElementType::polytope, 2, 1, 1);
  for (std::size_t i = 0; i < shape.positions.size(); ++i) s.point_ids.push_back(static_cast<std::int64_t>(i));
  for (int k = 0; k < 2; ++k) {
    Sequence::Step step{1.0 * k, shape.positions, {}, {}, {}};
    for (std::size_t i = static_cast<std::size_t>(k); i < 2; ++i) step.cells.add(shape.elements[i]);
    s.steps.push_back(step);
  }
  s.write(folder / "s.vtkhdf");
  const RawFile raw(folder / "s.vtkhdf");
  std::int64_t version[2];
  H5Aread(H5Aopen_by_name(raw.id(), "VTKHDF", "Version", H5P_DEFAULT, H5P_DEFAULT), H5T_NATIVE_INT64, version);
  EXPECT_EQ(version[1], 5);
  using Integers = std::vector<std::int64_t>;
  EXPECT_EQ(raw.integers("VTKHDF/NumberOfFaces"), (Integers{12, 6}));
  EXPECT_EQ(raw.integers("VTKHDF/NumberOfFaceConnectivityIds"), (Integers{48, 24}));
  EXPECT_EQ(raw.integers("VTKHDF/NumberOfPolyhedronToFaceIds"), (Integers{12, 6}));
  EXPECT_EQ(raw.integers("VTKHDF/PolyhedronOffsets"), (Integers{0, 6, 12, 0, 6}));
  EXPECT_EQ(raw.integers("VTKHDF/PolyhedronToFaces"),
            (Integers{0, 1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11, 0, 1, 2, 3, 4, 5}));
  EXPECT_EQ(raw.integers("VTKHDF/FaceOffsets"),
            (Integers{0, 4, 8, 12, 16, 20, 24, 28, 32, 36, 40, 44, 48, 0, 4, 8, 12, 16, 20, 24}));
  EXPECT_EQ(raw.integers("VTKHDF/Steps/FaceOffsetsOffsets"), (Integers{0, 12}));
  EXPECT_EQ(raw.integers("VTKHDF/Steps/FaceConnectivityOffsets"), (Integers{0, 48}));
  EXPECT_EQ(raw.integers("VTKHDF/Steps/PolyhedronToFaceIdOffsets"), (Integers{0, 12}));
  const auto points = raw.integers("VTKHDF/FaceConnectivity");
  for (std::size_t i = 0; i < 24; ++i) EXPECT_EQ(points[48 + i], shape.elements[1].faces[i / 4 * 5 + 1 + i % 4]);
}

}  // namespace
}  // namespace volccd::test
