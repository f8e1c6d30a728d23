// Valid and invalid ground truth in a small file.
#include <cmath>
#include <functional>
#include <limits>

#include <gtest/gtest.h>

#include <volccd/core/error.hpp>
#include <volccd/io/sequence/ground_truth.hpp>

#include "raw_hdf5.hpp"
#include "sequences.hpp"

namespace volccd::test {
namespace {

using I = std::vector<std::int64_t>;
using D = std::vector<double>;

/// Points 0 .. 6 have the ids 70, 60, .. 10; cells: triangles 0 1 2 and 3 4 5, a tetrahedron.
void write_file(const std::string& file, int steps = 2) {
  Sequence s;
  s.point_ids = {70, 60, 50, 40, 30, 20, 10};
  for (int k = 0; k < steps; ++k) {
    Sequence::Step step{1.0 * k, std::vector<Vec3>(7, Vec3(k, 0, 0)), {}, {}, {}};
    step.cells.add({.type = ElementType::triangle, .vertices = {0, 1, 2}});
    step.cells.add({.type = ElementType::triangle, .vertices = {3, 4, 5}, .id = 1});
    step.cells.add({.type = ElementType::tetrahedron, .vertices = {0, 1, 2, 6}, .id = 2});
    s.steps.push_back(step);
  }
  s.write(file);
  RawFile raw(file);
  raw.group("GroundTruth");
  raw.group("GroundTruth/VertexFace");
  raw.group("GroundTruth/EdgeEdge");
  raw.put("GroundTruth/Edges", {4, 2}, H5T_STD_I32LE, I{0, 1, 0, 2, 3, 4, 3, 5});
  raw.put("GroundTruth/VertexFace/Pairs", {2, 2}, H5T_STD_I32LE, I{6, 0, 1, 1});
  raw.put("GroundTruth/VertexFace/Collides", {2}, H5T_STD_U8LE, I{1, 0});
  raw.put("GroundTruth/VertexFace/TimeOfImpact", {2}, H5T_IEEE_F64LE, D{0.25, kNan});
  raw.put("GroundTruth/EdgeEdge/Pairs", {2, 2}, H5T_STD_I32LE, I{0, 2, 3, 1});
  raw.put("GroundTruth/EdgeEdge/Collides", {2}, H5T_STD_U8LE, I{0, 1});
}

TEST(GroundTruth, IdsInTheOrderOfContacts) {
  const ScratchFolder folder;
  write_file(folder / "s");
  SequenceReader reader(folder / "s");
  const auto answers = read_ground_truth(reader);
  ASSERT_TRUE(answers);
  ASSERT_EQ(answers->size(), 4u);
  using Four = std::array<std::int64_t, 4>;
  EXPECT_EQ((*answers)[0].ids, (Four{10, 50, 60, 70}));
  EXPECT_TRUE((*answers)[0].collides);
  EXPECT_EQ((*answers)[0].toi, 0.25);
  EXPECT_EQ((*answers)[1].ids, (Four{60, 20, 30, 40}));
  EXPECT_FALSE((*answers)[1].collides);
  EXPECT_TRUE(std::isnan((*answers)[1].toi));
  EXPECT_EQ((*answers)[2].ids, (Four{30, 40, 60, 70}));
  EXPECT_EQ((*answers)[2].kind, FeatureKind::ee);
  EXPECT_FALSE((*answers)[2].collides);
  EXPECT_EQ((*answers)[3].ids, (Four{20, 40, 50, 70}));
  EXPECT_TRUE((*answers)[3].collides);
  EXPECT_TRUE(std::isnan((*answers)[3].toi)) << "there is no dataset of times";
}

TEST(GroundTruth, BadOnesAreRefused) {
  struct Case {
    const char* name;
    std::function<void(RawFile&)> spoil;
    std::string dataset;
    std::int64_t index;
  };
  const std::string V = "GroundTruth/VertexFace/", E = "GroundTruth/EdgeEdge/";
  const std::vector<Case> cases = {
      {"point out of range", [&](RawFile& f) { f.poke(V + "Pairs", 0, std::int64_t{7}); }, V + "Pairs", 0},
      {"cell out of range", [&](RawFile& f) { f.poke(V + "Pairs", 3, std::int64_t{3}); }, V + "Pairs", 1},
      {"cell negative", [&](RawFile& f) { f.poke(V + "Pairs", 1, std::int64_t{-1}); }, V + "Pairs", 0},
      {"not a triangle", [&](RawFile& f) { f.poke(V + "Pairs", 3, std::int64_t{2}); }, V + "Pairs", 1},
      {"vertex of the triangle", [&](RawFile& f) { f.poke(V + "Pairs", 2, std::int64_t{4}); }, V + "Pairs", 1},
      {"no pairs", [&](RawFile& f) { f.remove(V + "Pairs"); }, V + "Pairs", -1},
      {"pairs of three",
       [&](RawFile& f) {
         f.put(V + "Pairs", {2, 3}, H5T_STD_I32LE, I{});
       },
       V + "Pairs", -1},
      {"no answers", [&](RawFile& f) { f.remove(V + "Collides"); }, V + "Collides", -1},
      {"few answers", [&](RawFile& f) { f.put(V + "Collides", {1}, H5T_STD_U8LE, I{1}); }, V + "Collides", -1},
      {"answer 2", [&](RawFile& f) { f.poke(E + "Collides", 1, std::int64_t{2}); }, E + "Collides", 1},
      {"late time", [&](RawFile& f) { f.poke(V + "TimeOfImpact", 0, 1.5); }, V + "TimeOfImpact", 0},
      {"no time", [&](RawFile& f) { f.poke(V + "TimeOfImpact", 0, kNan); }, V + "TimeOfImpact", 0},
      {"time of nothing", [&](RawFile& f) { f.poke(V + "TimeOfImpact", 1, 0.5); }, V + "TimeOfImpact", 1},
      {"many times", [&](RawFile& f) { f.put(V + "TimeOfImpact", {3}, H5T_IEEE_F64LE, D{}); }, V + "TimeOfImpact", -1},
      {"no edges", [&](RawFile& f) { f.remove("GroundTruth/Edges"); }, "GroundTruth/Edges", -1},
      {"edge out of range", [&](RawFile& f) { f.poke(E + "Pairs", 1, std::int64_t{4}); }, E + "Pairs", 0},
      {"edges with a common vertex", [&](RawFile& f) { f.poke(E + "Pairs", 2, std::int64_t{0}); }, E + "Pairs", 1},
      {"an edge with itself", [&](RawFile& f) { f.poke(E + "Pairs", 0, std::int64_t{2}); }, E + "Pairs", 0},
      {"edge of one point", [&](RawFile& f) { f.poke("GroundTruth/Edges", 3, std::int64_t{0}); }, "GroundTruth/Edges",
       1},
      {"edge to nowhere", [&](RawFile& f) { f.poke("GroundTruth/Edges", 7, std::int64_t{7}); }, "GroundTruth/Edges",
       3}};
  for (const Case& c : cases) {
    SCOPED_TRACE(c.name);
    const ScratchFolder folder;
    write_file(folder / "s");
    {
      RawFile raw(folder / "s");
      c.spoil(raw);
    }
    SequenceReader reader(folder / "s");
    try {
      read_ground_truth(reader);
      ADD_FAILURE() << "was accepted";
    } catch (const InputError& error) {
      EXPECT_EQ(error.source(), folder / "s");
      EXPECT_EQ(error.dataset(), c.dataset) << error.what();
      EXPECT_EQ(error.index(), c.index) << error.what();
    }
  }
}

TEST(GroundTruth, NeedsTwoSteps) {
  const ScratchFolder folder;
  write_file(folder / "s", 1);
  SequenceReader reader(folder / "s");
  EXPECT_THROW(read_ground_truth(reader), InputError);
}

}  // namespace
}  // namespace volccd::test
