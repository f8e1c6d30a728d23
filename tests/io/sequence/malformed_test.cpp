// Invalid files: each gives an error with the file, the dataset and the index, and none is read as if it were valid.
#include <concepts>
#include <fstream>
#include <functional>
#include <limits>

#include <gtest/gtest.h>
#include <sys/resource.h>

#include <volccd/core/error.hpp>
#include <volccd/io/hdf5/hdf5_messages.hpp>
#include <volccd/io/sequence/ground_truth.hpp>
#include <volccd/io/sequence/reader.hpp>

#include "raw_hdf5.hpp"
#include "sequences.hpp"

namespace volccd::test {
namespace {

using I = std::vector<std::int64_t>;
using D = std::vector<double>;
constexpr std::int64_t kAny = -2, kNo = InputError::kNoIndex;
const double kInf = std::numeric_limits<double>::infinity();
constexpr std::int64_t kHuge = std::numeric_limits<std::int64_t>::max();

/// Three steps, two topologies, 12 points: a hexahedron, a tetrahedron on its top, and a triangle; later a polytope
/// replaces the hexahedron. The file is small, so that all indices are known.
///
///     topology 0 (steps 0, 1): hexahedron 0-7, tetrahedron 4 5 6 8, triangle 8 9 10; connectivity at 0, 8, 12; 15 ids
///     topology 1 (step 2):     polytope 0-7 with 6 faces, triangle 8 9 11; connectivity from 15: at 15, 23; 11 ids
Sequence small() {
  Sequence s;
  const Shape cube = block(ElementType::polytope, 1, 1, 1), hexahedron = block(ElementType::hexahedron, 1, 1, 1);
  for (std::int64_t i = 0; i < 12; ++i) s.point_ids.push_back(100 - 3 * i);
  for (int k = 0; k < 3; ++k) {
    Sequence::Step step{0.5 * k, {}, {}, {}, {}};
    for (int i = 0; i < 12; ++i) {
      step.points.emplace_back(i, i * i, k);
      step.velocity.emplace_back(k, i, 0.5);
    }
    if (k < 2) {
      step.cells.add({ElementType::hexahedron, hexahedron.elements[0].vertices, {}, 1, 20});
      step.cells.add({.type = ElementType::tetrahedron, .vertices = {4, 5, 6, 8}, .object = 1, .id = 10});
      step.cells.add({.type = ElementType::triangle, .vertices = {8, 9, 10}, .object = 2, .id = 30});
    } else {
      step.cells.add({ElementType::polytope, cube.elements[0].vertices, cube.elements[0].faces, 1, 21});
      step.cells.add({.type = ElementType::triangle, .vertices = {8, 9, 11}, .object = 2, .id = 30});
    }
    step.thickness.assign(step.cells.size(), 0.5);
    s.steps.push_back(step);
  }
  return s;
}

struct Case {
  const char* name;
  std::function<void(RawFile&)> spoil;
  std::string dataset;
  std::int64_t index;
};

void PrintTo(const Case& c, std::ostream* out) { *out << c.name; }

/// Opens the file and reads everything.
void read_all(const std::string& file) {
  SequenceReader reader(file);
  reader.check_contents();
  read_ground_truth(reader);
}

class Malformed : public testing::TestWithParam<Case> {};

TEST_P(Malformed, IsRefusedWithFileDatasetAndIndex) {
  const Case& c = GetParam();
  const ScratchFolder folder;
  const std::string file = folder / "bad.vtkhdf";
  small().write(file);
  ASSERT_NO_THROW(read_all(file));
  {
    RawFile raw(file);
    c.spoil(raw);
  }
  testing::internal::CaptureStderr();
  try {
    read_all(file);
    ADD_FAILURE() << "was accepted";
  } catch (const InputError& error) {
    EXPECT_EQ(error.source(), file);
    EXPECT_EQ(error.dataset(), c.dataset) << error.what();
    if (c.index != kAny) {
      EXPECT_EQ(error.index(), c.index) << error.what();
    }
  }
  EXPECT_EQ(testing::internal::GetCapturedStderr(), "") << "HDF5 has printed";
}

template <std::integral Value>
Case poke(const char* name, std::string dataset, std::size_t at, Value value, std::int64_t index,
          std::string blamed = "") {
  return {name, [=](RawFile& f) { f.poke(dataset, at, std::int64_t{value}); }, blamed.empty() ? dataset : blamed,
          index};
}
Case poke(const char* name, std::string dataset, std::size_t at, double value, std::int64_t index) {
  return {name, [=](RawFile& f) { f.poke(dataset, at, value); }, dataset, index};
}
Case remove(const char* name, std::string dataset) {
  return {name, [=](RawFile& f) { f.remove(dataset); }, dataset, kNo};
}
/// A dataset with the same numbers and another type or shape.
Case retyped(const char* name, std::string dataset, hid_t type) {
  return {name, [=](RawFile& f) { f.put(dataset, f.shape(dataset), type, f.integers(dataset)); }, dataset, kNo};
}
Case retyped_reals(const char* name, std::string dataset, hid_t type) {
  return {name, [=](RawFile& f) { f.put(dataset, f.shape(dataset), type, f.reals(dataset)); }, dataset, kNo};
}
Case reshaped(const char* name, std::string dataset, std::vector<hsize_t> shape, std::string blamed = "",
              std::int64_t index = kNo) {
  return {name, [=](RawFile& f) { f.put(dataset, shape, H5T_STD_I64LE, f.integers(dataset)); },
          blamed.empty() ? dataset : blamed, index};
}
Case reshaped_reals(const char* name, std::string dataset, std::vector<hsize_t> shape, std::string blamed = "",
                    std::int64_t index = kNo) {
  return {name, [=](RawFile& f) { f.put(dataset, shape, H5T_IEEE_F64LE, f.reals(dataset)); },
          blamed.empty() ? dataset : blamed, index};
}

const std::string V = "VTKHDF/", S = "VTKHDF/Steps/";

std::string case_name(const testing::TestParamInfo<Case>& test) { return test.param.name; }

INSTANTIATE_TEST_SUITE_P(
    Header, Malformed,
    testing::Values(
        remove("NoGrid", "VTKHDF"),
        Case{"NoType", [](RawFile& f) { f.remove_attribute("VTKHDF", "Type"); }, "VTKHDF@Type", kNo},
        Case{"PolyData", [](RawFile& f) { f.put_attribute("VTKHDF", "Type", "PolyData"); }, "VTKHDF@Type", kNo},
        Case{"TypeIsNumber", [](RawFile& f) { f.put_attribute("VTKHDF", "Type", I{1}); }, "VTKHDF@Type", kNo},
        Case{"NoVersion", [](RawFile& f) { f.remove_attribute("VTKHDF", "Version"); }, "VTKHDF@Version", kNo},
        Case{"Version3",
             [](RawFile& f) {
               f.put_attribute("VTKHDF", "Version", I{3, 0});
             },
             "VTKHDF@Version", kNo},
        Case{"VersionOfOneNumber", [](RawFile& f) { f.put_attribute("VTKHDF", "Version", I{2}); }, "VTKHDF@Version",
             kNo},
        Case{"VersionIsText", [](RawFile& f) { f.put_attribute("VTKHDF", "Version", "2.2"); }, "VTKHDF@Version", kNo},
        Case{"TitleIsNumber", [](RawFile& f) { f.put_attribute("/", "Title", I{1}); }, "@Title", kNo},
        Case{"PartsWithoutIds", [](RawFile& f) { f.put_attribute("/", "Parts", "1 a; b"); }, "@Parts", 1},
        Case{"GridIsDataset",
             [](RawFile& f) {
               f.remove("VTKHDF");
               f.put("VTKHDF", {1}, H5T_STD_I64LE, I{1});
             },
             "VTKHDF@Type", kNo}),
    case_name);

INSTANTIATE_TEST_SUITE_P(
    Steps, Malformed,
    testing::Values(
        Case{"NoStepNumber", [](RawFile& f) { f.remove_attribute("VTKHDF/Steps", "NSteps"); }, "VTKHDF/Steps@NSteps",
             kNo},
        Case{"ZeroSteps", [](RawFile& f) { f.put_attribute("VTKHDF/Steps", "NSteps", I{0}); }, "VTKHDF/Steps@NSteps",
             kNo},
        Case{"NegativeSteps", [](RawFile& f) { f.put_attribute("VTKHDF/Steps", "NSteps", I{-3}); },
             "VTKHDF/Steps@NSteps", kNo},
        Case{"HugeSteps", [](RawFile& f) { f.put_attribute("VTKHDF/Steps", "NSteps", I{kHuge}); },
             "VTKHDF/Steps@NSteps", kNo},
        Case{"MoreStepsThanTimes", [](RawFile& f) { f.put_attribute("VTKHDF/Steps", "NSteps", I{4}); }, S + "Values",
             kNo},
        Case{"FewerStepsThanTimes", [](RawFile& f) { f.put_attribute("VTKHDF/Steps", "NSteps", I{2}); }, S + "Values",
             kNo},
        remove("NoValues", S + "Values"), poke("TimeNan", S + "Values", 1, kNan, 1),
        poke("TimeInf", S + "Values", 2, kInf, 2), poke("TimeEqual", S + "Values", 2, 0.5, 2),
        poke("TimeFalls", S + "Values", 1, -1.0, 1), retyped_reals("TimesAreIntegers", S + "Values", H5T_STD_I64LE),
        remove("NoPartOffsets", S + "PartOffsets"), poke("PartOffsetNegative", S + "PartOffsets", 1, -1, 1),
        poke("PartOffsetTooLarge", S + "PartOffsets", 2, 2, 2), poke("TwoPieces", S + "NumberOfParts", 1, 2, 1),
        poke("NoPiece", S + "NumberOfParts", 2, 0, 2), reshaped("PartOffsetsShort", S + "PartOffsets", {2}),
        retyped("PartOffsetsAreReals", S + "PartOffsets", H5T_IEEE_F64LE), remove("NoPointOffsets", S + "PointOffsets"),
        poke("PointOffsetNegative", S + "PointOffsets", 0, -1, 0),
        poke("PointOffsetTooLarge", S + "PointOffsets", 2, 25, 2),
        poke("PointOffsetHuge", S + "PointOffsets", 1, kHuge, 1), remove("NoCellOffsets", S + "CellOffsets"),
        poke("CellOffsetNegative", S + "CellOffsets", 1, -1, 1), poke("CellOffsetTooLarge", S + "CellOffsets", 2, 4, 2),
        poke("CellOffsetHuge", S + "CellOffsets", 2, kHuge, 2),
        reshaped("CellOffsetsTwoColumns", S + "CellOffsets", {3, 2}),
        reshaped("CellOffsetsRank3", S + "CellOffsets", {3, 1, 1}),
        reshaped("CellOffsetsScalar", S + "CellOffsets", {}),
        remove("NoConnectivityOffsets", S + "ConnectivityIdOffsets"),
        poke("ConnectivityOffsetTooLarge", S + "ConnectivityIdOffsets", 2, 16, 2),
        poke("ConnectivityOffsetShifted", S + "ConnectivityIdOffsets", 2, 14, 4, V + "PolyhedronOffsets"),
        remove("NoVelocityOffsets", S + "PointDataOffsets/Velocity"),
        poke("VelocityOffsetTooLarge", S + "PointDataOffsets/Velocity", 2, 25, 2),
        remove("NoThicknessOffsets", S + "CellDataOffsets/Thickness"),
        poke("ThicknessOffsetNegative", S + "CellDataOffsets/Thickness", 2, -4, 2),
        poke("CellIdOffsetTooLarge", S + "CellDataOffsets/GlobalCellIds", 2, 4, 2),
        poke("PartIdOffsetTooLarge", S + "CellDataOffsets/PartId", 1, 3, 1),
        remove("NoFaceOffsetsOffsets", S + "FaceOffsetsOffsets"),
        poke("FaceOffsetNegative", S + "FaceOffsetsOffsets", 2, -1, 2),
        poke("FaceOffsetTooLarge", S + "FaceOffsetsOffsets", 2, 1, 2),
        poke("FaceConnectivityOffsetTooLarge", S + "FaceConnectivityOffsets", 2, 1, 2),
        poke("ToFaceOffsetTooLarge", S + "PolyhedronToFaceIdOffsets", 2, 1, 2)),
    case_name);

INSTANTIATE_TEST_SUITE_P(
    Counts, Malformed,
    testing::Values(
        remove("NoNumberOfPoints", V + "NumberOfPoints"), remove("NoNumberOfCells", V + "NumberOfCells"),
        remove("NoNumberOfConnectivityIds", V + "NumberOfConnectivityIds"),
        reshaped("NoTopology", V + "NumberOfPoints", {0}), reshaped("CellCountsShort", V + "NumberOfCells", {1}),
        poke("PointsDiffer", V + "NumberOfPoints", 1, 11, 1), poke("PointsNegative", V + "NumberOfPoints", 0, -12, 0),
        Case{"NoPoints",
             [](RawFile& f) {
               f.put(V + "NumberOfPoints", {2}, H5T_STD_I64LE, I{0, 0});
             },
             V + "NumberOfPoints", 0},
        Case{"PointsBeyond32Bits",
             [](RawFile& f) {
               f.put(V + "NumberOfPoints", {2}, H5T_STD_I64LE, I{1ll << 33, 1ll << 33});
             },
             V + "NumberOfPoints", 0},
        Case{"PointsBeyondTheData",
             [](RawFile& f) {
               f.put(V + "NumberOfPoints", {2}, H5T_STD_I64LE, I{13, 13});
             },
             S + "PointOffsets", 2},
        poke("CellsNegative", V + "NumberOfCells", 1, -1, 1), poke("NoCells", V + "NumberOfCells", 1, 0, 1),
        poke("CellsHuge", V + "NumberOfCells", 1, kHuge, 1),
        poke("CellsBeyondTheData", V + "NumberOfCells", 1, 3, 2, S + "CellOffsets"),
        poke("ConnectivityHuge", V + "NumberOfConnectivityIds", 0, kHuge, 0),
        poke("ConnectivityVeryLarge", V + "NumberOfConnectivityIds", 0, std::int64_t{1} << 61, 0,
             S + "ConnectivityIdOffsets"),
        poke("ConnectivityFew", V + "NumberOfConnectivityIds", 0, 14, 3, V + "Offsets"),
        poke("FacesHuge", V + "NumberOfFaces", 1, std::int64_t{1} << 62, 2, S + "FaceOffsetsOffsets"),
        poke("FacesNegative", V + "NumberOfFaces", 0, -1, 0), remove("NoNumberOfFaces", V + "NumberOfFaces")),
    case_name);

INSTANTIATE_TEST_SUITE_P(
    Arrays, Malformed,
    testing::Values(remove("NoPoints", V + "Points"), reshaped_reals("PointsTwoColumns", V + "Points", {54, 2}),
                    reshaped_reals("PointsFlat", V + "Points", {108}),
                    reshaped_reals("PointsShort", V + "Points", {35, 3}, S + "PointOffsets", 2),
                    retyped_reals("PointsAreIntegers", V + "Points", H5T_STD_I32LE),
                    retyped_reals("PointsAreLongDouble", V + "Points", H5T_NATIVE_LDOUBLE),
                    poke("PointNan", V + "Points", 3 * 30 + 1, kNan, 30), poke("PointInf", V + "Points", 5, -kInf, 1),
                    poke("UnusedPointNan", V + "Points", 3 * 11, kNan, 11),
                    poke("VelocityNan", V + "PointData/Velocity", 3 * 13 + 2, kNan, 13),
                    reshaped_reals("VelocityFlat", V + "PointData/Velocity", {108}),
                    poke("PointIdTwice", V + "PointData/GlobalPointIds", 7, 100, 7),
                    poke("PointIdNegative", V + "PointData/GlobalPointIds", 3, -1, 3),
                    reshaped("PointIdsShort", V + "PointData/GlobalPointIds", {11},
                             S + "PointDataOffsets/GlobalPointIds", 0),
                    Case{"PointIdBeyond63Bits",
                         [](RawFile& f) {
                           f.put(V + "PointData/GlobalPointIds", {12}, H5T_STD_U64LE,
                                 f.integers(V + "PointData/GlobalPointIds"));
                           std::vector<std::uint64_t> ids(12, 1);
                           for (std::size_t i = 0; i < 12; ++i) ids[i] = i;
                           ids[5] = ~std::uint64_t{0} - 5;
                           H5Dwrite(f.open(V + "PointData/GlobalPointIds"), H5T_NATIVE_UINT64, H5S_ALL, H5S_ALL,
                                    H5P_DEFAULT, ids.data());
                         },
                         V + "PointData/GlobalPointIds", 5},
                    remove("NoTypes", V + "Types"), poke("UnknownType", V + "Types", 1, 11, 1),
                    poke("TypeZero", V + "Types", 4, 0, 4), poke("OtherType", V + "Types", 1, 13, 2, V + "Offsets"),
                    poke("TetrahedronAsPolytope", V + "Types", 1, 42, kAny, V + "PolyhedronOffsets"),
                    poke("PolytopeAsHexahedron", V + "Types", 3, 12, kAny, V + "PolyhedronOffsets"),
                    retyped("TypesAreReals", V + "Types", H5T_IEEE_F32LE),
                    reshaped("TypesShort", V + "Types", {4}, S + "CellOffsets", 2), remove("NoOffsets", V + "Offsets"),
                    poke("OffsetFalls", V + "Offsets", 2, 7, 2), poke("OffsetNegative", V + "Offsets", 1, -8, 1),
                    poke("OffsetTooLarge", V + "Offsets", 2, 16, 2), poke("OffsetNotFromZero", V + "Offsets", 4, 1, 4),
                    poke("LastOffsetShort", V + "Offsets", 3, 14, 3), poke("WrongVertexCount", V + "Offsets", 1, 7, 1),
                    reshaped("OffsetsShort", V + "Offsets", {6}, S + "CellOffsets", 2),
                    remove("NoConnectivity", V + "Connectivity"), poke("PointOutOfRange", V + "Connectivity", 9, 12, 9),
                    poke("PointNegative", V + "Connectivity", 25, -1, 25),
                    poke("PointHuge", V + "Connectivity", 0, std::int64_t{1} << 32, 0),
                    poke("FlatQuadrupleIsNoTetrahedron", V + "Connectivity", 11, 4, 11),
                    poke("PointTwiceInATriangle", V + "Connectivity", 14, 8, 14),
                    poke("PointTwiceInAPolytope", V + "Connectivity", 17, 0, 17),
                    reshaped("ConnectivityShort", V + "Connectivity", {25}, S + "ConnectivityIdOffsets", 2),
                    poke("CellIdTwice", V + "CellData/GlobalCellIds", 2, 20, 2),
                    poke("CellIdNegative", V + "CellData/GlobalCellIds", 4, -30, 4),
                    reshaped("CellIdsShort", V + "CellData/GlobalCellIds", {4}, S + "CellDataOffsets/GlobalCellIds", 2),
                    Case{"PartIdBeyond32Bits",
                         [](RawFile& f) {
                           f.put(V + "CellData/PartId", {5}, H5T_STD_I64LE, I{1, 1ll << 31, 1, 1, 1});
                         },
                         V + "CellData/PartId", 1},
                    poke("ThicknessNegative", V + "CellData/Thickness", 6, -0.5, 6),
                    poke("ThicknessNan", V + "CellData/Thickness", 2, kNan, 2),
                    poke("ThicknessInf", V + "CellData/Thickness", 7, kInf, 7)),
    case_name);

INSTANTIATE_TEST_SUITE_P(
    Polytopes, Malformed,
    testing::Values(remove("NoFaceConnectivity", V + "Types"),
                    Case{"NoFaces", [](RawFile& f) { f.remove(V + "FaceConnectivity"); }, V + "Types", 3},
                    remove("NoFaceOffsets", V + "FaceOffsets"), remove("NoToFaces", V + "PolyhedronToFaces"),
                    remove("NoPolyhedronOffsets", V + "PolyhedronOffsets"),
                    poke("FacePointOutOfRange", V + "FaceConnectivity", 5, 12, 5),
                    poke("FacePointNegative", V + "FaceConnectivity", 0, -1, 0),
                    poke("FacePointOfNoCell", V + "FaceConnectivity", 5, 9, kAny, V + "PolyhedronOffsets"),
                    poke("FaceOutOfRange", V + "PolyhedronToFaces", 5, 6, 5),
                    poke("FaceNegative", V + "PolyhedronToFaces", 0, -1, 0),
                    poke("FaceTwice", V + "PolyhedronToFaces", 5, 0, kAny, V + "PolyhedronOffsets"),
                    Case{"FaceOften",
                         [](RawFile& f) {
                           f.put(V + "PolyhedronToFaces", {6}, H5T_STD_I64LE, I{0, 0, 0, 1, 2, 3});
                         },
                         V + "PolyhedronToFaces", 2},
                    poke("FaceOffsetFalls", V + "FaceOffsets", 3, 3, 3),
                    poke("FaceOffsetsNotFromZero", V + "FaceOffsets", 1, 1, 1),
                    poke("PolyhedronOffsetFalls", V + "PolyhedronOffsets", 5, -1, 5),
                    poke("FacesOfATriangle", V + "PolyhedronOffsets", 5, 5, kAny)),
    case_name);

/// The reader must not trust a size and allocate memory for it.
INSTANTIATE_TEST_SUITE_P(
    Hostile, Malformed,
    testing::Values(Case{"PointsWithoutStorage",
                         [](RawFile& f) {
                           f.put_empty(V + "Points", {hsize_t{1} << 40, 3}, H5T_IEEE_F64LE, true);
                         },
                         V + "Points", kNo},
                    Case{"PointsContiguousWithoutStorage",
                         [](RawFile& f) {
                           f.put_empty(V + "Points", {hsize_t{1} << 40, 3}, H5T_IEEE_F64LE, false);
                         },
                         V + "Points", kNo},
                    Case{"RowsOverflow",
                         [](RawFile& f) { f.put_empty(V + "Connectivity", {hsize_t{1} << 62}, H5T_STD_I64LE, true); },
                         V + "Connectivity", kNo},
                    Case{"CountsWithoutStorage",
                         [](RawFile& f) { f.put_empty(V + "NumberOfPoints", {hsize_t{1} << 40}, H5T_STD_I64LE, true); },
                         V + "NumberOfPoints", kNo},
                    Case{"TimesWithoutStorage",
                         [](RawFile& f) {
                           f.put_attribute("VTKHDF/Steps", "NSteps", I{1ll << 30});
                           f.put_empty(S + "Values", {hsize_t{1} << 30}, H5T_IEEE_F64LE, true);
                         },
                         S + "Values", kNo},
                    Case{"CompoundType",
                         [](RawFile& f) {
                           const hid_t type = H5Tcreate(H5T_COMPOUND, 16);
                           H5Tinsert(type, "x", 0, H5T_NATIVE_INT64);
                           f.put_empty(V + "Types", {5}, type, false);
                         },
                         V + "Types", kNo},
                    Case{"TextType", [](RawFile& f) { f.put_empty(V + "Types", {5}, H5T_C_S1, false); }, V + "Types",
                         kNo},
                    Case{"DatasetIsGroup",
                         [](RawFile& f) {
                           f.remove(V + "Points");
                           f.group(V + "Points");
                         },
                         V + "Points", kNo},
                    Case{"DanglingLink",
                         [](RawFile& f) {
                           f.remove(V + "Points");
                           H5Lcreate_soft("/nowhere", f.id(), (V + "Points").c_str(), H5P_DEFAULT, H5P_DEFAULT);
                         },
                         V + "Points", kNo}),
    case_name);

TEST(MalformedFile, HugeSizesAllocateNothing) {
  const ScratchFolder folder;
  const std::string file = folder / "bad.vtkhdf";
  small().write(file);
  {
    RawFile raw(file);
    // 32 million points, none of which is stored.
    const std::int64_t n = std::int64_t{1} << 25;
    raw.put(V + "NumberOfPoints", {2}, H5T_STD_I64LE, I{n, n});
    raw.put_empty(V + "Points", {static_cast<hsize_t>(3 * n), 3}, H5T_IEEE_F64LE, true);
    raw.put_empty(V + "PointData/GlobalPointIds", {static_cast<hsize_t>(n)}, H5T_STD_I64LE, true);
  }
  rusage before{}, after{};
  getrusage(RUSAGE_SELF, &before);
  EXPECT_THROW(SequenceReader{file}, InputError);
  getrusage(RUSAGE_SELF, &after);
  EXPECT_LT(after.ru_maxrss - before.ru_maxrss, 64 * 1024) << "kilobytes";
}

/// The error message after `spoil` has changed the file.
std::string error_of(const std::function<void(RawFile&)>& spoil) {
  const ScratchFolder folder;
  const std::string file = folder / "bad.vtkhdf";
  small().write(file);
  {
    RawFile raw(file);
    spoil(raw);
  }
  try {
    read_all(file);
  } catch (const InputError& error) {
    return error.what();
  }
  return "was accepted";
}

/// Point i has the id 100 - 3 i; the cells' ids are 20, 10, 30 at the steps 0 and 1, then 21 and 30.
TEST(MalformedFile, ErrorsNameThePointOrTheCellAndTheStep) {
  const auto expect = [](const std::string& text, std::function<void(RawFile&)> spoil) {
    const std::string error = error_of(spoil);
    EXPECT_NE(error.find(text), std::string::npos) << error;
  };
  expect("(point id 82, frame 2)", [](RawFile& f) { f.poke(V + "Points", 3 * 30 + 1, kNan); });
  expect("(point id 97, frame 1)", [](RawFile& f) { f.poke(V + "PointData/Velocity", 3 * 13 + 2, kNan); });
  expect("(cell id 30, frame 2)", [](RawFile& f) { f.poke(V + "CellData/Thickness", 7, kInf); });
  expect("(cell id 10, frame 0)", [](RawFile& f) { f.poke(V + "Types", 1, std::int64_t{11}); });
  expect("(cell id 10, frame 0)", [](RawFile& f) { f.poke(V + "Connectivity", 9, std::int64_t{12}); });
  expect("(cell id 30, frame 2)", [](RawFile& f) { f.poke(V + "Connectivity", 25, std::int64_t{-1}); });
  expect("(cell id 21, frame 2)", [](RawFile& f) { f.poke(V + "FaceConnectivity", 5, std::int64_t{12}); });
  expect("point id 100 twice (cell id 21, frame 2)",
         [](RawFile& f) { f.poke(V + "Connectivity", 17, std::int64_t{0}); });
  expect("its point ids are 76 73 76 (cell id 30, frame 0)",
         [](RawFile& f) { f.poke(V + "Connectivity", 14, std::int64_t{8}); });
}

std::string bytes_of(const std::string& file) {
  std::ifstream stream(file, std::ios::binary);
  return {std::istreambuf_iterator<char>(stream), {}};
}

void write_bytes(const std::string& file, const std::string& bytes) {
  std::ofstream(file, std::ios::binary).write(bytes.data(), static_cast<std::streamsize>(bytes.size()));
}

TEST(MalformedFile, NotThereNotAFileNotHdf5) {
  const ScratchFolder folder;
  const auto problem = [](const std::string& file) -> std::string {
    try {
      SequenceReader reader(file);
    } catch (const InputError& error) {
      EXPECT_EQ(error.source(), file);
      return error.what();
    }
    return "accepted";
  };
  EXPECT_NE(problem(folder / "absent").find("No such file"), std::string::npos) << problem(folder / "absent");
  EXPECT_NE(problem(folder / "").find("not a regular file"), std::string::npos);
  EXPECT_NE(problem("/dev/null").find("not a regular file"), std::string::npos);
  for (const std::string& bytes : {std::string(), std::string("step,kind\n"), std::string(5000, '\0')}) {
    write_bytes(folder / "text", bytes);
    EXPECT_NE(problem(folder / "text").find("not a readable HDF5 file"), std::string::npos);
  }
}

TEST(MalformedFile, KeepsTheCallersErrorHandler) {
  H5E_auto2_t before = nullptr, after = nullptr;
  void *before_data = nullptr, *after_data = nullptr;
  H5Eget_auto2(H5E_DEFAULT, &before, &before_data);
  EXPECT_NE(before, nullptr);
  EXPECT_THROW(SequenceReader("/dev/null"), InputError);
  const ScratchFolder folder;
  random_sequence(1).write(folder / "s.vtkhdf");
  SequenceReader(folder / "s.vtkhdf").check_contents();
  H5Eget_auto2(H5E_DEFAULT, &after, &after_data);
  EXPECT_EQ(before, after);
  EXPECT_EQ(before_data, after_data);
}

/// HDF5 leaks blocks of its own for damaged files, and would print errors at the end of the process.
class QuietEnd : public testing::Environment {
 public:
  void TearDown() override { turn_off_hdf5_messages(); }
};
[[maybe_unused]] const testing::Environment* const quiet_end = testing::AddGlobalTestEnvironment(new QuietEnd);

/// Either an error with the name of the file, or a sequence that can be read; no other outcome.
bool survives(const std::string& file) {
  try {
    read_all(file);
    return true;
  } catch (const InputError& error) {
    EXPECT_EQ(error.source(), file) << error.what();
    return false;
  }
}

TEST(MalformedFile, TruncatedAtManyLengths) {
  const ScratchFolder folder;
  small().write(folder / "good");
  const std::string good = bytes_of(folder / "good");
  std::mt19937_64 random(5);
  for (int i = 0; i < 200; ++i) {
    const std::size_t length = i < 40 ? good.size() - 1 - static_cast<std::size_t>(i) : random() % good.size();
    write_bytes(folder / "cut", good.substr(0, length));
    EXPECT_FALSE(survives(folder / "cut")) << length << " of " << good.size() << " bytes";
  }
}

void flip_bytes(std::uint64_t seed, int rounds) {
  const ScratchFolder folder;
  small().write(folder / "good");
  const std::string good = bytes_of(folder / "good");
  std::mt19937_64 random(seed);
  int refused = 0;
  for (int i = 0; i < rounds; ++i) {
    std::string bad = good;
    for (std::uint64_t flips = 1 + random() % 3; flips > 0; --flips)
      bad[random() % bad.size()] ^= static_cast<char>(1 + random() % 255);
    write_bytes(folder / "flipped", bad);
    refused += !survives(folder / "flipped");
  }
  EXPECT_GT(refused, rounds / 5);
}

TEST(MalformedFile, RandomByteFlips) { flip_bytes(17, 300); }
TEST(LongMalformedFile, RandomByteFlips) { flip_bytes(18, 600); }

}  // namespace
}  // namespace volccd::test
