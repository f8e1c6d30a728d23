// Valid and invalid query files, and the queries as a step.
#include <functional>
#include <limits>

#include <gtest/gtest.h>

#include <volccd/core/error.hpp>
#include <volccd/io/sequence/query_file.hpp>
#include <volccd/oracle/cases/query_set.hpp>
#include <volccd/query/test_block.hpp>

#include "raw_hdf5.hpp"
#include "sequences.hpp"
#include "support/test_data.hpp"

namespace volccd::test {
namespace {

using I = std::vector<std::int64_t>;
using D = std::vector<double>;

double coordinate(std::size_t query, std::size_t point, std::size_t axis) {
  return static_cast<double>(query) + 0.125 * static_cast<double>(point) - 3.0 * static_cast<double>(axis);
}

void put_group(RawFile& raw, const std::string& path, std::size_t queries, const I& collides, const I& files) {
  raw.group(path);
  D points;
  for (std::size_t q = 0; q < queries; ++q)
    for (std::size_t p = 0; p < 8; ++p)
      for (std::size_t k = 0; k < 3; ++k) points.push_back(coordinate(q, p, k));
  raw.put(path + "/Points", {queries, 8, 3}, H5T_IEEE_F64LE, points);
  raw.put(path + "/Collides", {queries}, H5T_STD_U8LE, collides);
  raw.put(path + "/File", {queries}, H5T_STD_I32LE, files);
  raw.put_attribute(path, "Files", "one.csv two.csv");
}

void write_query_file(const std::string& file) {
  RawFile raw(file, true);
  raw.group("b");
  raw.group("a");
  put_group(raw, "b/EdgeEdge", 1, I{0}, I{0});
  put_group(raw, "a/VertexFace", 3, I{1, 0, 1}, I{0, 1, 1});
  put_group(raw, "a/EdgeEdge", 2, I{0, 1}, I{1, 0});
}

TEST(QueryFile, IsReadInTheOrderOfScenesAndKinds) {
  const ScratchFolder folder;
  write_query_file(folder / "q");
  EXPECT_FALSE(is_sequence_file(folder / "q"));
  const std::vector<QueryGroup> groups = read_query_file(folder / "q");
  ASSERT_EQ(groups.size(), 3u);
  EXPECT_EQ(groups[0].scene + groups[1].scene + groups[2].scene, "aab");
  EXPECT_EQ(groups[0].kind, FeatureKind::vf);
  EXPECT_EQ(groups[1].kind, FeatureKind::ee);
  EXPECT_EQ(groups[2].kind, FeatureKind::ee);
  EXPECT_EQ(groups[0].collides, (std::vector<std::uint8_t>{1, 0, 1}));
  EXPECT_EQ(groups[0].file, (std::vector<std::uint32_t>{0, 1, 1}));
  EXPECT_EQ(groups[1].file_names, (std::vector<std::string>{"one.csv", "two.csv"}));
  ASSERT_EQ(groups[0].points.size(), 24u);
  for (std::size_t q = 0; q < 3; ++q)
    for (std::size_t p = 0; p < 8; ++p)
      for (std::size_t k = 0; k < 3; ++k)
        EXPECT_EQ(groups[0].points[8 * q + p][static_cast<Eigen::Index>(k)], coordinate(q, p, k));
}

TEST(QueryFile, BadOnesAreRefused) {
  struct Case {
    const char* name;
    std::function<void(RawFile&)> spoil;
    std::string dataset;
    std::int64_t index;
  };
  const std::string V = "a/VertexFace", E = "a/EdgeEdge";
  const double nan = std::numeric_limits<double>::quiet_NaN();
  const std::vector<Case> cases = {
      {"not finite", [&](RawFile& f) { f.poke(V + "/Points", 2 * 24 + 5, nan); }, V + "/Points", 2},
      {"answer 2", [&](RawFile& f) { f.poke(E + "/Collides", 1, std::int64_t{2}); }, E + "/Collides", 1},
      {"file out of range", [&](RawFile& f) { f.poke(V + "/File", 1, std::int64_t{2}); }, V + "/File", 1},
      {"file negative", [&](RawFile& f) { f.poke(V + "/File", 2, std::int64_t{-1}); }, V + "/File", 2},
      {"fewer answers", [&](RawFile& f) { f.put(V + "/Collides", {2}, H5T_STD_U8LE, I{}); }, V + "/Collides", -1},
      {"more files", [&](RawFile& f) { f.put(V + "/File", {4}, H5T_STD_I32LE, I{}); }, V + "/File", -1},
      {"no points", [&](RawFile& f) { f.remove(V + "/Points"); }, V + "/Points", -1},
      {"no answers", [&](RawFile& f) { f.remove(V + "/Collides"); }, V + "/Collides", -1},
      {"no file numbers", [&](RawFile& f) { f.remove(E + "/File"); }, E + "/File", -1},
      {"no file names", [&](RawFile& f) { f.remove_attribute(E, "Files"); }, E + "@Files", -1},
      {"names are a number", [&](RawFile& f) { f.put_attribute(E, "Files", I{7}); }, E + "@Files", -1},
      {"seven points",
       [&](RawFile& f) {
         f.put(V + "/Points", {3, 7, 3}, H5T_IEEE_F64LE, D{});
       },
       V + "/Points", -1},
      {"in the plane",
       [&](RawFile& f) {
         f.put(V + "/Points", {3, 8, 2}, H5T_IEEE_F64LE, D{});
       },
       V + "/Points", -1},
      {"rank 2",
       [&](RawFile& f) {
         f.put(V + "/Points", {3, 24}, H5T_IEEE_F64LE, D{});
       },
       V + "/Points", -1},
      {"rank 4",
       [&](RawFile& f) {
         f.put(V + "/Points", {3, 8, 3, 1}, H5T_IEEE_F64LE, D{});
       },
       V + "/Points", -1},
      {"whole numbers",
       [&](RawFile& f) {
         f.put(V + "/Points", {3, 8, 3}, H5T_STD_I32LE, I{});
       },
       V + "/Points", -1},
      {"real answers", [&](RawFile& f) { f.put(V + "/Collides", {3}, H5T_IEEE_F64LE, D{}); }, V + "/Collides", -1},
      {"declared, not stored",
       [&](RawFile& f) {
         f.put_empty(V + "/Points", {std::uint64_t{1} << 40, 8, 3}, H5T_IEEE_F64LE, true);
       },
       V + "/Points", -1},
      {"a dataset for a scene", [&](RawFile& f) { f.put("c", {1}, H5T_STD_I32LE, I{}); }, "c", -1},
      {"an empty scene", [&](RawFile& f) { f.group("c"); }, "c", -1},
      {"nothing",
       [&](RawFile& f) {
         f.remove("a");
         f.remove("b");
       },
       "/", -1}};
  for (const Case& c : cases) {
    SCOPED_TRACE(c.name);
    const ScratchFolder folder;
    write_query_file(folder / "q");
    {
      RawFile raw(folder / "q");
      c.spoil(raw);
    }
    try {
      read_query_file(folder / "q");
      ADD_FAILURE() << "was accepted";
    } catch (const InputError& error) {
      EXPECT_EQ(error.source(), folder / "q");
      EXPECT_EQ(error.dataset(), c.dataset) << error.what();
      EXPECT_EQ(error.index(), c.index) << error.what();
    }
  }
}

TEST(QueryFile, EmptyGroupsAreLeftOut) {
  const ScratchFolder folder;
  {
    RawFile raw(folder / "q", true);
    raw.group("a");
    put_group(raw, "a/VertexFace", 0, I{}, I{});
  }
  EXPECT_TRUE(read_query_file(folder / "q").empty());
}

TEST(QueryFile, SequencesAreToldApart) {
  const ScratchFolder folder;
  random_sequence(1, 1).write(folder / "s");
  EXPECT_TRUE(is_sequence_file(folder / "s"));
  EXPECT_THROW(read_query_file(folder / "s"), InputError);
  EXPECT_THROW(is_sequence_file(folder / "absent"), InputError);
}

/// The counts given in the README of the data.
TEST(QueryFile, SharedQueries) {
  VOLCCD_NEEDS_DATA(path, "ccd-queries.h5");
  std::size_t queries = 0, colliding = 0;
  const std::vector<QueryGroup> groups = read_query_file(path);
  EXPECT_EQ(groups.size(), 12u);
  for (const QueryGroup& group : groups) {
    queries += group.size();
    for (const std::uint8_t c : group.collides) colliding += c;
  }
  EXPECT_EQ(queries, 4779u);
  EXPECT_EQ(colliding, 22u + 38 + 4 + 9 + 14 + 36 + 22 + 16 + 124 + 36);
}

TEST(QuerySet, KeepsPointsInTheOrderOfTests) {
  for (const int control_points : {2, 3})
    for (const FeatureKind kind : {FeatureKind::vf, FeatureKind::ee}) {
      std::vector<Vec3> points;
      for (int i = 0; i < 5 * 4 * control_points; ++i) points.emplace_back(i, -i, i % 7);
      QuerySet made(kind, control_points, points);
      const QuerySet set = std::move(made);
      ASSERT_EQ(set.size(), 5u);
      const Step step = set.step(0.5, 0.25);
      EXPECT_EQ(step.t_max, 0.5);
      EXPECT_EQ(step.separation, 0.25);
      EXPECT_EQ(step.motion.control_points(), control_points);
      std::size_t at = 0;
      for (std::size_t i = 0; i < set.size(); ++i) {
        ASSERT_TRUE(is_test(step.features(), kind, set.pairs()[i]));
        const std::array<Index, 4> v = test_vertices(step.features(), kind, set.pairs()[i]);
        EXPECT_EQ(QuerySet::query_of({kind, v, 0, {}, {}, {}}), i);
        for (int c = 0; c < control_points; ++c)
          for (std::size_t p = 0; p < 4; ++p) EXPECT_EQ(step.motion.point(v[p], c), points[at++]);
      }
    }
}

TEST(QuerySet, RefusesBadPoints) {
  std::vector<Vec3> points(24, Vec3::Zero());
  EXPECT_EQ(QuerySet(FeatureKind::vf, 2, points).size(), 3u);
  EXPECT_EQ(QuerySet(FeatureKind::vf, 3, points).size(), 2u);
  EXPECT_EQ(QuerySet(FeatureKind::ee, 2, {}).size(), 0u);
  EXPECT_THROW(QuerySet(FeatureKind::vf, 2, std::span(points).first(20)), InputError);
  points[17].y() = std::numeric_limits<double>::infinity();
  try {
    QuerySet(FeatureKind::vf, 2, points);
    ADD_FAILURE() << "was accepted";
  } catch (const InputError& error) {
    EXPECT_EQ(error.index(), 2);
  }
}

}  // namespace
}  // namespace volccd::test
