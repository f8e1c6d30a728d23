// The numbers of Figure 3 for a sequence with known answers: a bar that passes through a plate without resistance.
#include <volccd/experiments/tables/feature_sets.hpp>

#include <gtest/gtest.h>

#include <cstdlib>
#include <filesystem>

#include <unistd.h>

#include <volccd/core/error.hpp>
#include <volccd/io/sequence/writer.hpp>
#include <volccd/oracle/cases/shapes.hpp>

namespace volccd {
namespace {

struct Stop {};

class FeatureSets : public testing::Test {
 protected:
  void SetUp() override {
    std::string name = (std::filesystem::temp_directory_path() / "volccd-sets-XXXXXX").string();
    ASSERT_NE(mkdtemp(name.data()), nullptr);
    folder_ = name;
  }
  void TearDown() override { std::filesystem::remove_all(folder_); }

  /// The second cell is divided into two wedges.
  static Shape broken(Shape shape) {
    const std::vector<Index> c = shape.elements[1].vertices;
    ElementSpec half = shape.elements[1];
    half.type = ElementType::wedge;
    half.vertices = {c[0], c[3], c[2], c[4], c[7], c[6]};
    half.id = 1000;
    shape.elements.push_back(half);
    half.vertices = {c[2], c[1], c[0], c[6], c[5], c[4]};
    half.id = shape.elements[1].id;
    shape.elements[1] = half;
    return shape;
  }

  /// The bar has 1 x 1 x 2 cells. Its lower end is 0.5 above the plate of 3 x 3 x 1 cells, and it sinks by 1 in each
  /// step of 0.25 s.
  std::string write(ElementType type) {
    Shape bar = block(type, 1, 1, 2), plate = block(type, 3, 3, 1);
    bar.translate(Vec3(1.2, 1.3, 1.5));
    Shape all;
    all.append(bar, 3).append(plate, 4);
    const Mesh mesh = all.mesh();
    const std::string file = (folder_ / "run.vtkhdf").string();
    SequenceWriter writer(file, mesh.vertex_ids());
    for (int k = 0; k < 4; ++k) {
      std::vector<Vec3> x = all.positions;
      for (std::size_t v = 0; v < bar.positions.size(); ++v) x[v].z() -= k;
      if (k >= 2) x.back().z() -= 5;  // a corner of the plate moves through its element
      writer.write_frame(0.25 * k, x, cells_of(k > 0 && type == ElementType::hexahedron ? broken(all).mesh() : mesh));
    }
    writer.finish();
    return file;
  }

  std::vector<nlohmann::json> motions_of(const std::string& file, int motions = 100) {
    SerialExecutor executor;
    return feature_set_motions(file, executor, [&] {
      if (motions-- == 0) throw Stop();
    });
  }

  std::filesystem::path folder_;
};

TEST_F(FeatureSets, SeesWhatGoesThrough) {
  std::vector<nlohmann::json> motions = motions_of(write(ElementType::hexahedron));
  ASSERT_EQ(motions.size(), 3u);
  for (int k = 0; k < 3; ++k) {
    const nlohmann::json& motion = motions[static_cast<std::size_t>(k)];
    EXPECT_NEAR(motion.at("velocity").get<double>(), 4, 1e-12);
    EXPECT_EQ(motion.at("step"), k);
    EXPECT_EQ(motion.at("time"), 0.25 * (k + 1));
    EXPECT_EQ(motion.at("elements"), 12);
    EXPECT_NEAR(motion.at("travel").get<double>(), k + 1, 1e-12);
    EXPECT_EQ(motion.at("pieces_striker"), 1);
    EXPECT_EQ(motion.at("pieces_target"), 1);
    EXPECT_EQ(motion.at("inverted"), k == 0 ? 0 : 1);
    EXPECT_EQ(motion.at("overlaps_intra"), 0);
    // At the starts of the motions: the bar is above the plate; its lower cell is inside four cells of the plate; its
    // upper cell is inside as well, and one of its wedges misses one of the four cells.
    EXPECT_EQ(motion.at("overlaps_inter"), k == 0 ? 0 : k == 1 ? 4 : 11) << k;
  }
  EXPECT_GT(motions[0].at("contacts").get<int>(), 0);
  // Halfway into the plate, the bar has met few of the features between the plate's cells.
  EXPECT_LT(motions[0].at("interior"), motions[1].at("interior"));
  EXPECT_LT(motions[1].at("interior"), motions[1].at("contacts"));
  // The table has the values of the last motion, and sums.
  for (nlohmann::json& motion : motions)
    motion.update({{"scene", "run"}, {"splits", 5}, {"breaks", 1}, {"simulation_seconds", 1.5}});
  const auto cells = feature_set_tables({{"rows", motions}}).front().table.rows();
  ASSERT_EQ(cells.size(), 2u);
  const std::vector<std::string> expected = {"run", "12", "15", "1", "1", "4", "3000.00", "11", "0", "2"};
  EXPECT_EQ(std::vector<std::string>(cells[1].begin(), cells[1].begin() + 10), expected);
  EXPECT_EQ(cells[1].back(), "4.50 s");
}

TEST_F(FeatureSets, StopsWhenToldAndRefusesOtherElements) {
  EXPECT_THROW(motions_of(write(ElementType::hexahedron), 2), Stop);
  EXPECT_THROW(motions_of(write(ElementType::tetrahedron)), InputError);
}

}  // namespace
}  // namespace volccd
