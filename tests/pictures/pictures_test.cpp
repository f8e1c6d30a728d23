#include <volccd/pictures/sequence_picture.hpp>

#include <gtest/gtest.h>

#include <cmath>
#include <filesystem>
#include <fstream>
#include <numeric>

#include <png.h>
#include <unistd.h>
#include <Eigen/Geometry>

#include <volccd/core/error.hpp>
#include <volccd/core/random.hpp>
#include <volccd/mesh/sequence/writer.hpp>
#include <volccd/oracle/cases/shapes.hpp>
#include <volccd/pictures/palette.hpp>
#include <volccd/pictures/surface.hpp>
#include <volccd/pictures/text.hpp>

/// Fontconfig keeps data about fonts until the process ends, and the leak sanitizer reports a part of them.
extern "C" const char* __lsan_default_suppressions();
const char* __lsan_default_suppressions() { return "leak:libfontconfig\n"; }

namespace volccd {
namespace {

constexpr Colour kWhite{255, 255, 255};

/// A file name of this test alone; the file goes with it.
class PictureFile {
 public:
  explicit PictureFile(const std::string& name)
      : path_(std::filesystem::temp_directory_path() / ("volccd-" + std::to_string(getpid()) + "-" + name)) {}
  ~PictureFile() {
    std::error_code ignored;
    std::filesystem::remove(path_, ignored);
  }
  std::string path() const { return path_.string(); }

 private:
  std::filesystem::path path_;
};

SequenceCells cells_of_shape(const Shape& shape) {
  SequenceCells cells;
  for (const ElementSpec& element : shape.elements) cells.add(element);
  return cells;
}

Surface surface_of_shape(const Shape& shape) {
  const SequenceCells cells = cells_of_shape(shape);
  const std::vector<std::uint16_t> colours(cells.size(), 0);
  return surface_of(cells, shape.positions, colours);
}

double area(const Surface& surface, bool sections) {
  double sum = 0;
  for (const SurfaceTriangle& t : surface.triangles) {
    const Vec3 &a = surface.points[t.corners[0]], &b = surface.points[t.corners[1]], &c = surface.points[t.corners[2]];
    if (!sections || t.section) sum += 0.5 * (b - a).cross(c - a).norm();
  }
  return sum;
}

RenderOptions plain() {
  RenderOptions options;
  options.samples = 1;
  options.lines = options.occlusion = false;
  return options;
}

View front() {
  View view;
  parse_view("front", view);
  view.orthographic = true;
  return view;
}

std::vector<Vec3> box_corners(const Vec3& low, const Vec3& high) {
  std::vector<Vec3> corners;
  for (int i = 0; i < 8; ++i)
    corners.emplace_back(i & 1 ? high.x() : low.x(), i & 2 ? high.y() : low.y(), i & 4 ? high.z() : low.z());
  return corners;
}

TEST(Pictures, CubeCoversItsSquareAndNothingElse) {
  const Surface surface = surface_of_shape(block(ElementType::hexahedron, 1, 1, 1));
  const std::vector<Colour> colours{part_colour(0)};
  const Camera camera = Camera::fit(surface.points, front(), 120, 100, 0.1);
  const Image image = render(surface, colours, {}, camera, 120, 100, plain());
  for (int y = 0; y < 100; ++y)
    for (int x = 0; x < 120; ++x)
      ASSERT_EQ(image.at(x, y) != kWhite, x >= 20 && x < 100 && y >= 10 && y < 90) << x << ' ' << y;
}

/// The first element that a ray through the middle of the pixel hits, by Cramer's rule on all triangles; -1: nothing;
/// -2: undecided because of rounding.
int first_hit(const Surface& surface, const Camera& camera, double x, double y) {
  const bool flat = camera.orthographic();
  const Vec3 p = camera.from_picture(x, y, flat ? -1 : 1), q = camera.from_picture(x, y, flat ? -2 : 0.5);
  double nearest = 1e300;
  int hit = -1;
  for (std::size_t i = 0; i < surface.triangles.size(); ++i) {
    const auto& corners = surface.triangles[i].corners;
    const Vec3 a = camera.to_view(surface.points[corners[0]]);
    Eigen::Matrix3d m;
    m << camera.to_view(surface.points[corners[1]]) - a, camera.to_view(surface.points[corners[2]]) - a, p - q;
    const Vec3 s = m.inverse() * (p - a);  // weights, and the depth beyond p
    const double inside = std::min({s[0], s[1], 1 - s[0] - s[1]});
    if (std::abs(inside) < 1e-6 || (inside > 0 && std::abs(s[2] - nearest) < 1e-5)) return -2;
    if (inside < 0 || s[2] > nearest) continue;
    nearest = s[2];
    hit = surface.triangles[i].colour;
  }
  return hit;
}

TEST(Pictures, NearerHidesFartherAsRaysSay) {
  const std::vector<Colour> colours{{255, 0, 0}, {0, 255, 0}, {0, 0, 255}, {255, 255, 0}, {255, 0, 255}, {0, 255, 255}};
  std::size_t compared = 0;
  for (std::uint64_t seed = 0; seed < 8; ++seed) {
    Shape shape;
    shape.positions = jittered(std::vector<Vec3>(36, Vec3::Zero()), 1, seed);
    for (Index i = 0; i < 12; ++i)
      shape.elements.push_back({ElementType::triangle, {3 * i, 3 * i + 1, 3 * i + 2}, {}, 0, i});
    const SequenceCells cells = cells_of_shape(shape);
    std::vector<std::uint16_t> colour_of(12);
    for (std::size_t i = 0; i < 12; ++i) colour_of[i] = static_cast<std::uint16_t>(i % 6);
    const Surface surface = surface_of(cells, shape.positions, colour_of);
    View view;
    view.azimuth = 40.0 * static_cast<double>(seed);
    view.orthographic = seed % 2 == 0;
    const Camera camera = Camera::fit(shape.positions, view, 90, 70);
    const Image image = render(surface, colours, {}, camera, 90, 70, plain());
    for (int y = 0; y < 70; ++y)
      for (int x = 0; x < 90; ++x) {
        const int hit = first_hit(surface, camera, x + 0.5, y + 0.5);
        if (hit == -2) continue;
        ++compared;
        const Colour seen = image.at(x, y);
        if (hit == -1) {
          ASSERT_EQ(seen, kWhite);
          continue;
        }
        const Colour own = colours[static_cast<std::size_t>(hit)];
        const int high = std::max({seen.r, seen.g, seen.b});
        ASSERT_TRUE((seen.r > high / 2) == (own.r > 0) && (seen.g > high / 2) == (own.g > 0) &&
                    (seen.b > high / 2) == (own.b > 0))
            << "seed " << seed << ", pixel " << x << ' ' << y;
      }
  }
  EXPECT_GT(compared, 45000u);
}

TEST(Pictures, CameraSeesAllItsPoints) {
  const std::vector<Vec3> points = jittered(std::vector<Vec3>(200, Vec3(50, -3, 7)), 4, 1);
  for (const char* name : {"front", "back", "left", "right", "side", "top", "bottom", "iso", "12.5,-33"})
    for (const char up : {'x', 'y', 'z'})
      for (const bool flat : {false, true}) {
        View view;
        parse_view(name, view);
        view.up = up;
        view.orthographic = flat;
        const Camera camera = Camera::fit(points, view, 300, 200, 0.05);
        double nearest_border = 1e9;
        for (const Vec3& point : points) {
          const Camera::Projected p = camera.project(point);
          nearest_border = std::min({nearest_border, p.x, p.y, 300 - p.x, 200 - p.y});
          EXPECT_LT((camera.from_picture(p.x, p.y, p.nearness) - camera.to_view(point)).norm(), 1e-9);
        }
        EXPECT_NEAR(nearest_border, 10, 1) << name << ' ' << up << ' ' << flat;
      }
}

TEST(Pictures, ViewsLookWhereTheySay) {
  const auto pixel_of = [](const char* name, char up, const Vec3& point) {
    View view;
    parse_view(name, view);
    view.up = up;
    const Camera::Projected p =
        Camera::fit(box_corners(Vec3::Constant(-1), Vec3::Constant(1)), view, 100, 100).project(point);
    return Eigen::Vector2d(p.x - 50, 50 - p.y);
  };
  EXPECT_GT(pixel_of("front", 'z', {1, 0, 0}).x(), 10);  // x to the right
  EXPECT_GT(pixel_of("front", 'z', {0, 0, 1}).y(), 10);  // z upwards
  EXPECT_LT(pixel_of("back", 'z', {1, 0, 0}).x(), -10);
  EXPECT_GT(pixel_of("side", 'z', {0, 1, 0}).x(), 10);
  EXPECT_GT(pixel_of("top", 'z', {0, 1, 0}).y(), 10);
  EXPECT_GT(pixel_of("top", 'z', {1, 0, 0}).x(), 10);
  EXPECT_GT(pixel_of("front", 'y', {0, 1, 0}).y(), 10);
  EXPECT_GT(pixel_of("front", 'y', {1, 0, 0}).x(), 10);
  EXPECT_GT(pixel_of("front", 'x', {1, 0, 0}).y(), 10);
  View view;
  for (const char* bad : {"", "above", "1", "1,", "1,2,3", "0,91", "nan,0"})
    EXPECT_THROW(parse_view(bad, view), ConfigError);
}

TEST(PictureSurface, IsTheBoundaryOfVolumes) {
  for (const ElementType type : {ElementType::tetrahedron, ElementType::pyramid, ElementType::wedge,
                                 ElementType::hexahedron, ElementType::polytope}) {
    const Surface surface = surface_of_shape(permuted(block(type, 3, 2, 4), 5));
    EXPECT_NEAR(area(surface, false), 2 * (6 + 8 + 12), 1e-9) << to_string(type);
  }
  EXPECT_NEAR(area(surface_of_shape(block(ElementType::quad, 5, 3, 1)), false), 15, 1e-9);
}

TEST(PictureSurface, CutsCloseWithTheSectionOfTheBody) {
  const Shape whole = [] {
    Shape shape = block(ElementType::hexahedron, 1, 1, 1);
    for (Vec3& p : shape.positions) p = p.cwiseProduct(Vec3(3, 2, 4));
    return shape;
  }();
  const std::vector<CuttingPlane> planes{{Vec3(1, 2, 0.7).normalized(), 1.9}, {Vec3(-1, 0.3, 0.2).normalized(), -0.4}};
  const auto cut_of = [&](const Shape& shape, std::size_t count) {
    Surface surface = surface_of_shape(shape);
    const std::vector<std::uint16_t> colours(shape.elements.size(), 0);
    cut(surface, cells_of_shape(shape), shape.positions, colours, std::span(planes).first(count));
    for (const SurfaceTriangle& t : surface.triangles)
      for (const Index corner : t.corners)
        for (std::size_t i = 0; i < count; ++i)
          EXPECT_LT(planes[i].normal.dot(surface.points[corner]) - planes[i].offset, 1e-9);
    EXPECT_EQ(surface.normals.size(), surface.triangles.size());
    return surface;
  };
  for (std::size_t count : {1, 2}) {
    const Surface expected = cut_of(whole, count);
    EXPECT_GT(area(expected, true), 1);
    for (const ElementType type : {ElementType::tetrahedron, ElementType::pyramid, ElementType::wedge,
                                   ElementType::hexahedron, ElementType::polytope}) {
      const Surface surface = cut_of(block(type, 3, 2, 4), count);
      EXPECT_NEAR(area(surface, true), area(expected, true), 1e-9) << to_string(type) << ' ' << count;
      EXPECT_NEAR(area(surface, false), area(expected, false), 1e-9) << to_string(type) << ' ' << count;
    }
  }
}

TEST(PictureSurface, CutAlongFacesOfElementsIsClosedToo) {
  const Shape shape = block(ElementType::hexahedron, 2, 2, 2);
  Surface surface = surface_of_shape(shape);
  const std::vector<std::uint16_t> colours(shape.elements.size(), 0);
  const std::vector<CuttingPlane> planes{{Vec3::UnitX(), 1}};
  cut(surface, cells_of_shape(shape), shape.positions, colours, planes);
  EXPECT_NEAR(area(surface, true), 4, 1e-12);
  EXPECT_NEAR(area(surface, false), 16, 1e-12);
}

TEST(PictureSurface, NormalsAreSharedAcrossFlatEdgesAndNotAcrossCreases) {
  const Surface cube = surface_of_shape(block(ElementType::tetrahedron, 2, 2, 2));
  for (std::size_t i = 0; i < cube.triangles.size(); ++i)
    for (const Eigen::Vector3f& n : cube.normals[i]) EXPECT_NEAR(n.cwiseAbs().maxCoeff(), 1, 1e-6);
  Shape roof = block(ElementType::quad, 2, 1, 1);  // bent by 2 * 10 degrees
  for (Vec3& p : roof.positions) p.z() = -std::abs(p.x() - 1) * std::tan(std::numbers::pi / 18);
  std::swap(roof.elements[1].vertices[1], roof.elements[1].vertices[3]);  // numbered the other way round
  const Surface bent = surface_of_shape(roof);
  int ridge = 0;
  for (std::size_t i = 0; i < bent.triangles.size(); ++i)
    for (int k = 0; k < 3; ++k)
      if (bent.points[bent.triangles[i].corners[k]].x() == 1) {
        ++ridge;
        EXPECT_LT(std::abs(bent.normals[i][k].x()), 0.1);
      }
  EXPECT_EQ(ridge, 6);
}

TEST(PictureSurface, FragmentsAreNoBodies) {
  Shape shape;
  shape.append(block(ElementType::hexahedron, 4, 4, 4), 1);
  shape.append(block(ElementType::hexahedron, 1, 1, 1).translate({500, 0, 0}), 1);  // a fragment
  shape.append(block(ElementType::quad, 1, 1, 1).translate({-30, 0, 0}), 2);        // small, but the whole of part 2
  const SequenceCells cells = cells_of_shape(shape);
  double low = 0, high = 0;
  for (const Index v : vertices_of_bodies(cells, shape.positions.size())) {
    low = std::min(low, shape.positions[v].x());
    high = std::max(high, shape.positions[v].x());
  }
  EXPECT_EQ(low, -30);
  EXPECT_EQ(high, 4);
  EXPECT_EQ(vertices_of_bodies(cells, shape.positions.size(), 0).size(), shape.positions.size());
}

TEST(PictureFiles, LibpngReadsWhatWasDrawn) {
  const PictureFile file("picture.png");
  Image image(37, 23);
  for (int y = 0; y < 23; ++y)
    for (int x = 0; x < 37; ++x)
      image.set(
          x, y,
          {static_cast<std::uint8_t>(7 * x), static_cast<std::uint8_t>(11 * y), static_cast<std::uint8_t>(x * y)});
  write_png(image, file.path());
  png_image header{};
  header.version = PNG_IMAGE_VERSION;
  ASSERT_TRUE(png_image_begin_read_from_file(&header, file.path().c_str()));
  EXPECT_EQ(header.width, 37u);
  EXPECT_EQ(header.height, 23u);
  header.format = PNG_FORMAT_RGB;
  std::vector<Colour> read(PNG_IMAGE_SIZE(header) / 3);
  ASSERT_TRUE(png_image_finish_read(&header, nullptr, read.data(), 0, nullptr));
  EXPECT_TRUE(std::equal(read.begin(), read.end(), image.pixels().begin(), image.pixels().end()));
  EXPECT_THROW(write_png(image, "/nonexistent/picture.png"), InputError);
  EXPECT_THROW(Image(0, 5), ConfigError);
  EXPECT_THROW(Image(20000, 20000), ConfigError);
}

TEST(PictureText, FillsTheWidthItSays) {
  Image image(400, 60);
  const std::string text = "Plate 12.5 (m/s)";
  draw_text(image, text, 20, 40, 18, {0, 0, 0});
  int left = 400, right = 0, top = 60, bottom = 0;
  for (int y = 0; y < 60; ++y)
    for (int x = 0; x < 400; ++x)
      if (image.at(x, y).r < 128) {
        left = std::min(left, x);
        right = std::max(right, x);
        top = std::min(top, y);
        bottom = std::max(bottom, y);
      }
  EXPECT_NEAR(left, 20, 2);
  EXPECT_NEAR(right, 20 + text_width(text, 18), 5);
  EXPECT_NEAR(top, 40 - 18 - 1, 2);  // the parentheses
  EXPECT_NEAR(bottom, 40 + 3, 2);
  EXPECT_EQ(text_width("\xC3\xA4", 12), text_width("a", 12));  // a with dots
  EXPECT_EQ(text_width("\xFF\xE0\x80", 12), text_width("???", 12));
}

TEST(PictureText, LosesNothingAtTheEndsOfLines) {
  EXPECT_EQ(wrap_text("short", 12, 1000), std::vector<std::string>{"short"});
  EXPECT_EQ(wrap_text("", 12, 1000), std::vector<std::string>{""});
  const std::string text = "rather a long text with an extraordinarilylongword";
  const std::vector<std::string> lines = wrap_text(text, 12, 60);
  EXPECT_GT(lines.size(), 5u);
  std::string letters, all;
  for (const std::string& line : lines) {
    EXPECT_LE(text_width(line, 12), 60) << line;
    all += line;
  }
  for (const char c : text)
    if (c != ' ') letters += c;
  std::erase(all, ' ');
  EXPECT_EQ(all, letters);
}

/// The tip of a tetrahedron passes through a triangle: one contact, of vertex 3 (id 13).
class TipOnTriangle {
 public:
  /// `remade`: at the end, another triangle, of other vertices at the same places, takes its place.
  explicit TipOnTriangle(std::int32_t part_of_triangle, bool remade = false) : file_("tip.vtkhdf") {
    const std::vector<std::int64_t> ids{10, 11, 12, 13, 14, 15, 16, 17, 18, 19};
    std::vector<Vec3> points{{-1, -1, 2}, {1, -1, 2}, {0, 1, 2}, {0, 0, 0.5}, {-3, -2, 0}, {3, -2, 0}, {0, 4, 0}};
    for (std::size_t v = 4; v < 7; ++v) points.push_back(points[v]);
    const auto cells_with = [&](const std::vector<Index>& triangle, std::int64_t id) {
      SequenceCells cells;
      cells.add({ElementType::tetrahedron, {0, 1, 2, 3}, {}, 1, 0});
      cells.add({ElementType::triangle, triangle, {}, part_of_triangle, id});
      return cells;
    };
    const SequenceCells cells = cells_with({4, 5, 6}, 1), end = remade ? cells_with({7, 8, 9}, 2) : cells;
    SequenceMetadata metadata;
    metadata.part_names = {{1, "Tip, steel"}};
    SequenceWriter writer(file_.path(), ids, metadata);
    writer.write_step(0, points, cells);
    for (int v = 0; v < 4; ++v) points[v].z() -= 1;
    writer.write_step(1, points, end);
    writer.finish();
  }

  std::string path() const { return file_.path(); }

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
  PictureFile file_;
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
  const PictureFile csv("contacts.csv");
  PicturePanel panel{scene.path(), 0, "", ""};
  const Image computed = draw_sequences({&panel, 1}, TipOnTriangle::config());
  panel.contacts = csv.path();
  std::ofstream(csv.path()) << "step,kind,a,b,c,d,toi,nx,ny,nz,px,py,pz\n0,VF,13,14,15,16,0.5,0,0,1,0,0,0\n"
                               "1,VF,10,14,15,16,0.5,0,0,1,0,0,0\n";
  EXPECT_EQ(draw_sequences({&panel, 1}, TipOnTriangle::config()), computed);
  // Without a point of contact, the mark is at the vertex.
  std::ofstream(csv.path()) << "step,kind,a,b,c,d,toi\n0,VF,13,14,15,16,0.5\n";
  const auto [count, middle] = find_colour(draw_sequences({&panel, 1}, TipOnTriangle::config()), kInterColour);
  EXPECT_GT(count, 40);
  EXPECT_LT((middle - TipOnTriangle::pixel({0, 0, 0.5})).norm(), 1);
  std::ofstream(csv.path()) << "step,kind,a,b,c,d,toi\n0,VF,99,114,115,116,0.5\n";
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
  config.parts = "2";
  EXPECT_EQ(count(true), 0);
  EXPECT_GT(count(false), 500);
  for (const char* both : {"1,2", "1; 2", " tip, STEEL ; 2"}) {
    config.parts = both;
    EXPECT_GT(count(true), 500) << both;
    EXPECT_GT(count(false), 500) << both;
  }
  config.parts = "Tip, steel";
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
  const PictureFile file("block.vtkhdf");
  const Shape shape = block(ElementType::tetrahedron, 2, 2, 2);
  {
    std::vector<std::int64_t> ids(shape.positions.size());
    std::iota(ids.begin(), ids.end(), 0);
    SequenceWriter writer(file.path(), ids);
    writer.write_step(0, shape.positions, cells_of_shape(shape));
    writer.finish();
  }
  const PicturePanel panel{file.path(), 0, "", ""};
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
  refuses(0, {.width = 100, .parts = "3"});
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
