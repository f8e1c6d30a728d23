// The shared files have the numbers given in their README.
#include <algorithm>
#include <array>
#include <cmath>

#include <gtest/gtest.h>

#include <volccd/io/sequence/ground_truth.hpp>
#include <volccd/io/sequence/reader.hpp>
#include <volccd/io/sequence/stepper.hpp>

#include "support/test_data.hpp"

namespace volccd::test {
namespace {

struct Figures {
  const char* name;
  Index points, first_cells, last_cells;
  std::size_t parts;
  int steps, topologies;
  ElementType type;
  bool velocity, thickness;
};

class SharedSequence : public testing::TestWithParam<Figures> {};

TEST_P(SharedSequence, HasTheFiguresOfItsReadme) {
  const Figures& f = GetParam();
  VOLCCD_NEEDS_DATA(path, std::string(f.name) + ".vtkhdf");
  SequenceReader reader(path);
  EXPECT_EQ(reader.frame_count(), f.steps);
  EXPECT_EQ(reader.point_count(), f.points);
  EXPECT_EQ(reader.cell_count(0), f.first_cells);
  EXPECT_EQ(reader.cell_count(f.steps - 1), f.last_cells);
  EXPECT_EQ(reader.topology_index(f.steps - 1) + 1, f.topologies);
  EXPECT_EQ(reader.has_velocity(), f.velocity);
  EXPECT_EQ(reader.has_thickness(), f.thickness);
  EXPECT_FALSE(reader.metadata().title.empty());
  EXPECT_FALSE(reader.metadata().license.empty());
  SequenceCells cells;
  reader.read_cells(0, cells);
  std::vector<std::int32_t> parts = cells.objects;
  std::sort(parts.begin(), parts.end());
  parts.erase(std::unique(parts.begin(), parts.end()), parts.end());
  EXPECT_EQ(parts.size(), f.parts);
  for (const ElementType type : cells.types) ASSERT_EQ(type, f.type);
  for (const auto& [id, name] : reader.metadata().object_names)
    EXPECT_TRUE(std::binary_search(parts.begin(), parts.end(), id)) << name;
  std::vector<Vec3> points;
  reader.read_points(f.steps / 2, points);
  EXPECT_EQ(points.size(), f.points);
}

using enum ElementType;
INSTANTIATE_TEST_SUITE_P(
    Data, SharedSequence,
    testing::Values(Figures{"ls-dyna-projectile", 7668, 5664, 5050, 2, 16, 13, hexahedron, true, false},
                    Figures{"openradioss-bullet", 14691, 11840, 11195, 2, 89, 62, hexahedron, true, false},
                    Figures{"openradioss-airbag", 4531, 9016, 9016, 3, 120, 1, triangle, true, true},
                    Figures{"openradioss-crash", 41264, 39742, 39742, 15, 91, 1, quad, true, true},
                    Figures{"cloth-ball", 46598, 92230, 92230, 2, 2, 1, triangle, false, false},
                    Figures{"rod-twist", 39940, 79864, 79864, 4, 2, 1, triangle, false, false},
                    Figures{"octopus-4k", 1184, 4069, 4069, 1, 1, 1, tetrahedron, false, false},
                    Figures{"octopus-14k", 3430, 13578, 13578, 1, 1, 1, tetrahedron, false, false},
                    Figures{"octopus-32k", 7631, 32102, 32102, 1, 1, 1, tetrahedron, false, false},
                    Figures{"octopus2-14k", 3597, 14289, 14289, 1, 1, 1, tetrahedron, false, false},
                    Figures{"octopus2-42k", 12971, 42096, 42096, 1, 1, 1, tetrahedron, false, false},
                    Figures{"octopus2-105k", 33113, 105440, 105440, 1, 1, 1, tetrahedron, false, false},
                    Figures{"armadillo-15k", 3992, 14870, 14870, 1, 1, 1, tetrahedron, false, false}),
    [](const auto& test) {
      std::string name = test.param.name;
      std::replace(name.begin(), name.end(), '-', '_');
      return name;
    });

class LongSharedSequence : public testing::TestWithParam<const char*> {};

TEST_P(LongSharedSequence, AllContentsAreGood) {
  VOLCCD_NEEDS_DATA(path, std::string(GetParam()) + ".vtkhdf");
  EXPECT_NO_THROW(SequenceReader(path).check_contents());
}

INSTANTIATE_TEST_SUITE_P(Data, LongSharedSequence,
                         testing::Values("ls-dyna-projectile", "openradioss-bullet", "openradioss-airbag",
                                         "openradioss-crash", "cloth-ball", "rod-twist", "octopus2-105k"));

TEST(SharedProjectile, CellsOfEachPartAtEachStep) {
  VOLCCD_NEEDS_DATA(path, "ls-dyna-projectile.vtkhdf");
  const std::array projectile = {1864, 1864, 1846, 1814, 1787, 1757, 1727, 1681,
                                 1635, 1592, 1551, 1517, 1498, 1491, 1491, 1491};
  const std::array plate = {3800, 3800, 3800, 3797, 3784, 3770, 3750, 3724,
                            3676, 3631, 3599, 3577, 3561, 3559, 3559, 3559};
  SequenceReader reader(path);
  EXPECT_EQ(reader.metadata().object_names, (std::map<std::int32_t, std::string>{{1, "Projectile"}, {2, "Plate"}}));
  SequenceCells cells;
  for (int k = 0; k < 16; ++k) {
    reader.read_cells(k, cells);
    EXPECT_EQ(std::count(cells.objects.begin(), cells.objects.end(), 1), projectile[static_cast<std::size_t>(k)]);
    EXPECT_EQ(std::count(cells.objects.begin(), cells.objects.end(), 2), plate[static_cast<std::size_t>(k)]);
  }
}

TEST(SharedProjectile, StepperRemoves614AndAddsNone) {
  VOLCCD_NEEDS_DATA(path, "ls-dyna-projectile.vtkhdf");
  SequenceReader reader(path);
  SequenceStepper stepper(reader);
  ASSERT_EQ(stepper.step_count(), 15);
  std::size_t removed = 0;
  std::uint64_t version = 0;
  std::vector<const TopologyChange*> changes;
  for (int k = 0; k < 15; ++k) {
    stepper.go_to(k);
    EXPECT_EQ(stepper.topology().mesh().element_count(), reader.cell_count(k + 1));
    if (k > 0) {
      ASSERT_TRUE(stepper.topology().changes_since(version, changes));
      for (const TopologyChange* change : changes) {
        removed += change->removed_elements.size();
        EXPECT_TRUE(change->added_elements.empty());
      }
    }
    version = stepper.topology().version();
  }
  EXPECT_EQ(removed, 614u);
  EXPECT_EQ(stepper.topology().features().vertex_count(), 6999u);
}

void expect_counts(const std::vector<KnownAnswer>& answers, FeatureKind kind, std::ptrdiff_t listed,
                   std::ptrdiff_t colliding) {
  EXPECT_EQ(std::count_if(answers.begin(), answers.end(), [&](const auto& a) { return a.kind == kind; }), listed);
  EXPECT_EQ(std::count_if(answers.begin(), answers.end(), [&](const auto& a) { return a.kind == kind && a.collides; }),
            colliding);
}

TEST(SharedGroundTruth, ClothBall) {
  VOLCCD_NEEDS_DATA(path, "cloth-ball.vtkhdf");
  SequenceReader reader(path);
  const auto answers = read_ground_truth(reader);
  ASSERT_TRUE(answers);
  expect_counts(*answers, FeatureKind::vf, 19034, 19032);
  expect_counts(*answers, FeatureKind::ee, 94825, 94822);
  for (const KnownAnswer& answer : *answers) ASSERT_TRUE(std::isnan(answer.toi));
  // The same file is opened a second time while the first reader is used.
  std::vector<Vec3> points;
  EXPECT_NO_THROW(reader.read_points(1, points));
}

TEST(SharedGroundTruth, RodTwistWithTimes) {
  VOLCCD_NEEDS_DATA(path, "rod-twist.vtkhdf");
  SequenceReader reader(path);
  const auto answers = read_ground_truth(reader);
  ASSERT_TRUE(answers);
  expect_counts(*answers, FeatureKind::vf, 801, 765);
  expect_counts(*answers, FeatureKind::ee, 4370, 4179);
  for (const KnownAnswer& answer : *answers) ASSERT_EQ(answer.collides, !std::isnan(answer.toi));
}

TEST(SharedGroundTruth, AbsentElsewhere) {
  VOLCCD_NEEDS_DATA(path, "octopus-4k.vtkhdf");
  SequenceReader reader(path);
  EXPECT_FALSE(read_ground_truth(reader));
}

}  // namespace
}  // namespace volccd::test
