// Pictures of sequences: contacts, parts, panels, sections, and what is refused.
#include <volccd/pictures/sequence_picture.hpp>

#include <algorithm>
#include <fstream>
#include <numeric>

#include <gtest/gtest.h>

#include <volccd/core/error.hpp>
#include <volccd/io/sequence/writer.hpp>
#include <volccd/pictures/palette.hpp>

#include "pictures/picture_shapes.hpp"
#include "support/scratch_folder.hpp"

namespace volccd {
namespace {

using namespace test;

/// The tip of a tetrahedron passes through a triangle: one contact, of vertex 3 (id 13).
class TipOnTriangle {
 public:
  /// `remade`: at the end, another triangle, of other vertices at the same places, takes its place.
  explicit TipOnTriangle(std::int32_t part_of_triangle, bool remade = false) {
    const std::vector<std::int64_t> ids{10, 11, 12, 13, 14, 15, 16, 17, 18, 19};
    std::vector<Vec3> points{{-1, -1, 2}, {1, -1, 2}, {0, 1, 2}, {0, 0, 0.5}, {-3, -2, 0}, {3, -2, 0}, {0, 4, 0}};
    for (std::size_t v = 4; v < 7; ++v) points.push_back(points[v]);
    const auto cells_with = [&](const std::vector<Index>& triangle, std::int64_t id) {
      SequenceCells cells;
      cells.add({.type = ElementType::tetrahedron, .vertices = {0, 1, 2, 3}, .object = 1});
      cells.add({.type = ElementType::triangle, .vertices = triangle, .object = part_of_triangle, .id = id});
      return cells;
    };
    const SequenceCells cells = cells_with({4, 5, 6}, 1), end = remade ? cells_with({7, 8, 9}, 2) : cells;
    SequenceMetadata metadata;
    metadata.object_names = {{1, "Tip, steel"}};
    SequenceWriter writer(path(), ids, metadata);
    writer.write_frame(0, points, cells);
    for (int v = 0; v < 4; ++v) points[v].z() -= 1;
    writer.write_frame(1, points, end);
    writer.finish();
  }

  std::string path() const { return folder_ / "tip.vtkhdf"; }

  static PictureConfig config() {
    PictureConfig config;
    config.width = 240;
    config.height = 200;
    config.view = front();
    config.box = {-3, 3, -2, 4, -0.5, 2.5};
    config.text = false;
    config.mark_radius = 5;
    config.render.samples = 1;
    config.render.hidden_marks = 1;  // the point of contact is behind the triangle, or in the tip
    return config;
  }

  /// The place in the picture of a point, for the camera of the box.
  static Eigen::Vector2d pixel(const Vec3& place) {
    const Camera::Projected p = Camera::fit(box_corners({-3, -2, -0.5}, {3, 4, 2.5}), front(), 240, 200).project(place);
    return {p.x, p.y};
  }

 private:
  test::ScratchFolder folder_;
};

/// The number of pixels that have exactly this colour, and their mean position.
std::pair<int, Eigen::Vector2d> find_colour(const Image& image, Colour colour) {
  int count = 0;
  Eigen::Vector2d sum = Eigen::Vector2d::Zero();
  for (int y = 0; y < image.height(); ++y)
    for (int x = 0; x < image.width(); ++x)
      if (image.at(x, y) == colour) {
        ++count;
        sum += Eigen::Vector2d(x + 0.5, y + 0.5);
      }
  return {count, Eigen::Vector2d(sum / std::max(count, 1))};
}

TEST(SequencePicture, MarksTheContactWhereItIs) {
  for (const int part : {1, 2})
    for (const int step : {0, 1}) {
      const TipOnTriangle scene(part);
      const PicturePanel panel{scene.path(), step, "", ""};
      const Image image = draw_sequences({&panel, 1}, TipOnTriangle::config());
      const auto [count, middle] = find_colour(image, part == 1 ? kIntraColour : kInterColour);
      EXPECT_GT(count, 40);
      EXPECT_LT(count, 90);
      EXPECT_LT((middle - TipOnTriangle::pixel({0, 0, 0})).norm(), 1);  // at t = 0.5
      EXPECT_EQ(find_colour(image, part == 1 ? kInterColour : kIntraColour).first, 0);
      PictureConfig without = TipOnTriangle::config();
      without.contacts = false;
      EXPECT_EQ(find_colour(draw_sequences({&panel, 1}, without), part == 1 ? kIntraColour : kInterColour).first, 0);
    }
}

TEST(SequencePicture, ContactsOfNewCellsAreOfTheirParts) {
  for (const int part : {1, 2}) {
    const TipOnTriangle scene(part, true);
    const PicturePanel panel{scene.path(), 0, "", ""};
    const Image image = draw_sequences({&panel, 1}, TipOnTriangle::config());
    EXPECT_GT(find_colour(image, part == 1 ? kIntraColour : kInterColour).first, 40);
    EXPECT_EQ(find_colour(image, part == 1 ? kInterColour : kIntraColour).first, 0);
  }
}

TEST(SequencePicture, TakesContactsFromAFile) {
  const TipOnTriangle scene(2);
  const test::ScratchFolder folder;
  const std::string csv = folder / "contacts.csv";
  PicturePanel panel{scene.path(), 0, "", ""};
  const Image computed = draw_sequences({&panel, 1}, TipOnTriangle::config());
  panel.contacts = csv;
  std::ofstream(csv) << "step,kind,a,b,c,d,toi,nx,ny,nz,px,py,pz\n0,VF,13,14,15,16,0.5,0,0,1,0,0,0\n"
                        "1,VF,10,14,15,16,0.5,0,0,1,0,0,0\n";
  EXPECT_EQ(draw_sequences({&panel, 1}, TipOnTriangle::config()), computed);
  // Without a point of contact, the mark is at the vertex.
  std::ofstream(csv) << "step,kind,a,b,c,d,toi\n0,VF,13,14,15,16,0.5\n";
  const auto [count, middle] = find_colour(draw_sequences({&panel, 1}, TipOnTriangle::config()), kInterColour);
  EXPECT_GT(count, 40);
  EXPECT_LT((middle - TipOnTriangle::pixel({0, 0, 0.5})).norm(), 1);
  std::ofstream(csv) << "step,kind,a,b,c,d,toi\n0,VF,99,114,115,116,0.5\n";
  EXPECT_THROW(draw_sequences({&panel, 1}, TipOnTriangle::config()), InputError);
}

TEST(SequencePicture, HiddenMarksArePaleOrAbsent) {
  const TipOnTriangle scene(2);
  const PicturePanel panel{scene.path(), 0, "", ""};
  PictureConfig config = TipOnTriangle::config();
  parse_view("top", config.view);  // the tip is below the tetrahedron's base
  config.render.hidden_marks = 0.25;
  EXPECT_EQ(find_colour(draw_sequences({&panel, 1}, config), kInterColour).first, 0);
  config.render.hidden_marks = 0;
  const Image hidden = draw_sequences({&panel, 1}, config);
  config.contacts = false;
  EXPECT_EQ(hidden, draw_sequences({&panel, 1}, config));
}

TEST(SequencePicture, PartsHaveTheirColours) {
  const TipOnTriangle scene(2);
  const PicturePanel panel{scene.path(), 0, "", ""};
  PictureConfig config = TipOnTriangle::config();
  config.contacts = false;
  config.render = plain();
  config.colours = {"tip, steel=#ff0000", "2=#0000ff"};
  const auto count = [&](bool red) {
    const Image image = draw_sequences({&panel, 1}, config);
    return std::count_if(image.pixels().begin(), image.pixels().end(),
                         [&](Colour c) { return red ? c.r > 2 * c.b + 20 : c.b > 2 * c.r + 20; });
  };
  parse_view("iso", config.view);
  EXPECT_GT(count(true), 500);
  EXPECT_GT(count(false), 500);
  config.without = "2";
  EXPECT_GT(count(true), 500);
  EXPECT_EQ(count(false), 0);
  config.without.clear();
  config.objects = "2";
  EXPECT_EQ(count(true), 0);
  EXPECT_GT(count(false), 500);
  for (const char* both : {"1,2", "1; 2", " tip, STEEL ; 2"}) {
    config.objects = both;
    EXPECT_GT(count(true), 500) << both;
    EXPECT_GT(count(false), 500) << both;
  }
  config.objects = "Tip, steel";
  EXPECT_EQ(count(false), 0);
}

TEST(SequencePicture, IsTheSameEveryTime) {
  const TipOnTriangle scene(2);
  const std::vector<PicturePanel> panels{{scene.path(), 0, "before", ""}, {scene.path(), 1, "after", ""}};
  PictureConfig config;
  config.width = 300;
  const std::string once = encode_png(draw_sequences(panels, config));
  config.threads = 2;
  EXPECT_EQ(once, encode_png(draw_sequences(panels, config)));
}

TEST(SequencePicture, PanelsShareTheCamera) {
  const TipOnTriangle scene(2);
  const std::vector<PicturePanel> panels{{scene.path(), 0, "", ""}, {scene.path(), 0, "", ""}};
  PictureConfig config;
  config.width = 404;
  config.height = 150;
  config.text = false;
  const Image image = draw_sequences(panels, config);
  ASSERT_EQ(image.width(), 404);
  ASSERT_EQ(image.height(), 150);
  for (int y = 0; y < 150; ++y)
    for (int x = 0; x < 200; ++x) ASSERT_EQ(image.at(x, y), image.at(x + 204, y));
}

TEST(SequencePicture, CutShowsTheSection) {
  const test::ScratchFolder folder;
  const std::string file = folder / "block.vtkhdf";
  const Shape shape = block(ElementType::tetrahedron, 2, 2, 2);
  {
    std::vector<std::int64_t> ids(shape.positions.size());
    std::iota(ids.begin(), ids.end(), 0);
    SequenceWriter writer(file, ids);
    writer.write_frame(0, shape.positions, cells_of_shape(shape));
    writer.finish();
  }
  const PicturePanel panel{file, 0, "", ""};
  PictureConfig config;
  config.width = config.height = 100;
  config.view = front();
  config.text = false;
  config.render = plain();
  const Image whole = draw_sequences({&panel, 1}, config);
  config.cuts = {"y=50%"};
  const Image section = draw_sequences({&panel, 1}, config);
  config.cuts = {"y=1"};
  EXPECT_EQ(section, draw_sequences({&panel, 1}, config));
  // The same square in one colour, which is paler than the surface.
  for (int y = 0; y < 100; ++y)
    for (int x = 0; x < 100; ++x) {
      ASSERT_EQ(section.at(x, y) == kWhite, whole.at(x, y) == kWhite);
      if (section.at(x, y) != kWhite) {
        ASSERT_EQ(section.at(x, y), section.at(50, 50));
      }
    }
  EXPECT_NE(section.at(50, 50), whole.at(50, 50));
  for (const char* bad : {"", "y", "y=", "w=1", "y=1x", "y=%", "y=nan"}) {
    config.cuts = {bad};
    EXPECT_THROW(draw_sequences({&panel, 1}, config), ConfigError) << bad;
  }
  config.cuts = {"y=-1"};
  EXPECT_NO_THROW(draw_sequences({&panel, 1}, config = PictureConfig{.width = 100, .cuts = {"x=1"}}));
}

TEST(SequencePicture, RefusesWhatIsNotThere) {
  const TipOnTriangle scene(2);
  const auto refuses = [&](int step, const PictureConfig& config) {
    const PicturePanel panel{scene.path(), step, "", ""};
    EXPECT_THROW(draw_sequences({&panel, 1}, config), ConfigError);
  };
  refuses(2, {});
  refuses(-1, {});
  refuses(0, {.width = 5});
  refuses(0, {.width = 100, .height = 50000});
  refuses(0, {.width = 100, .objects = "3"});
  refuses(0, {.width = 100, .without = "nobody"});
  refuses(0, {.width = 100, .without = "1,2"});
  refuses(0, {.width = 100, .colours = {"1=red"}});
  const PicturePanel panel{"/nonexistent.vtkhdf", 0, "", ""};
  EXPECT_THROW(draw_sequences({&panel, 1}, {}), InputError);
  const PicturePanel flat{scene.path(), 0, "", ""};
  PictureConfig solid;
  solid.width = 100;
  solid.shells = ShellModel::solid;
  EXPECT_THROW(draw_sequences({&flat, 1}, solid), InputError);  // no thickness in the file
}

}  // namespace
}  // namespace volccd
