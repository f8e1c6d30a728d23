// The C interface refuses bad arguments with a code and a message that names the argument; nothing is changed then.
#include <functional>
#include <limits>
#include <stdexcept>
#include <thread>

#include <gtest/gtest.h>

#include "capi/support.hpp"

namespace volccd::capi_test {
namespace {

/// Two tetrahedra, of which the second falls onto the first.
struct Scene {
  std::vector<std::uint8_t> types = {10, 10};
  std::vector<std::int64_t> offsets = {0, 4, 8}, connectivity = {0, 1, 2, 3, 4, 5, 6, 7};
  std::vector<std::int32_t> objects = {0, 1};
  std::vector<Vec3> x0 = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, 0, 1}, {-1, -1, 2}, {2, -1, 2}, {-1, 2, 2}, {0, 0, 3}};
  std::vector<Vec3> x1 = x0;

  Scene() {
    for (std::size_t v = 4; v < 8; ++v) x1[v].z() -= 2;
  }
  volccd_cells cells() const {
    volccd_cells cells{};
    cells.count = 2;
    cells.types = types.data();
    cells.offsets = offsets.data();
    cells.connectivity = connectivity.data();
    cells.connectivity_size = 8;
    cells.objects = objects.data();
    return cells;
  }
};

/// The code is the expected one, and the message contains the text.
void expect_error(int expected, const std::string& text, int code) {
  EXPECT_EQ(code, expected) << text;
  EXPECT_NE(std::string(volccd_last_error()).find(text), std::string::npos) << volccd_last_error() << "\nnot: " << text;
}

TEST(CErrors, OfCells) {
  const Scene scene;
  const auto refuse = [&](int code, const std::string& text, const std::function<void(volccd_cells&)>& change) {
    volccd_cells cells = scene.cells();
    change(cells);
    volccd_detector* detector = nullptr;
    expect_error(code, text, volccd_create(8, &cells, nullptr, &detector));
    EXPECT_EQ(detector, nullptr) << "output is unchanged";
  };
  const int argument = VOLCCD_ERROR_ARGUMENT, input = VOLCCD_ERROR_INPUT;
  refuse(argument, "cells.count: -1 is negative", [](auto& c) { c.count = -1; });
  refuse(argument, "cells.count: 9223372036854775807 is more",
         [](auto& c) { c.count = std::numeric_limits<std::int64_t>::max(); });
  refuse(argument, "cells.types is NULL, for 2 values", [](auto& c) { c.types = nullptr; });
  refuse(argument, "cells.offsets is NULL, for 3 values", [](auto& c) { c.offsets = nullptr; });
  refuse(argument, "cells.connectivity is NULL, for 8 values", [](auto& c) { c.connectivity = nullptr; });
  refuse(argument, "cells.connectivity_size: -8", [](auto& c) { c.connectivity_size = -8; });
  refuse(argument, "cells.faces is NULL, for 3 values", [](auto& c) { c.faces_size = 3; });
  refuse(argument, "cells.faces_size: -1", [](auto& c) { c.faces_size = -1; });
  refuse(input, "offsets", [](auto& c) { c.connectivity_size = 7; });
  const std::uint8_t types[] = {10, 11};
  refuse(input, "types[1]", [&](auto& c) { c.types = types; });
  const std::int64_t connectivity[] = {0, 1, 2, 3, 4, 5, 6, 8}, ids[] = {5, 5}, negative[] = {0, 1, 2, 3, 4, 5, 6, -1};
  refuse(input, "8", [&](auto& c) { c.connectivity = connectivity; });
  refuse(input, "connectivity[7]", [&](auto& c) { c.connectivity = negative; });
  refuse(input, "5", [&](auto& c) { c.ids = ids; });
  const double thickness[] = {0.1, -0.1};
  const std::uint8_t shells[] = {9, 9};
  refuse(input, "thickness[1]", [&](auto& c) { c.types = shells, c.thickness = thickness; });
}

TEST(CErrors, OfCreate) {
  const Scene scene;
  const volccd_cells cells = scene.cells();
  volccd_detector* detector = nullptr;
  expect_error(VOLCCD_ERROR_ARGUMENT, "cells is NULL", volccd_create(8, nullptr, nullptr, &detector));
  expect_error(VOLCCD_ERROR_ARGUMENT, "detector is NULL", volccd_create(8, &cells, nullptr, nullptr));
  expect_error(VOLCCD_ERROR_ARGUMENT, "vertex_count: -1", volccd_create(-1, &cells, nullptr, &detector));
  expect_error(VOLCCD_ERROR_ARGUMENT, "vertex_count", volccd_create(1LL << 32, &cells, nullptr, &detector));
  expect_error(VOLCCD_ERROR_INPUT, "7", volccd_create(7, &cells, nullptr, &detector));
  volccd_cells none{};
  ASSERT_EQ(volccd_create(0, &none, nullptr, &detector), VOLCCD_OK) << volccd_last_error();
  const Handle empty(detector);
  EXPECT_EQ(volccd_step(detector, 0, nullptr, nullptr, 0, 1), VOLCCD_OK) << volccd_last_error();
}

TEST(CErrors, OfOptions) {
  const Scene scene;
  const volccd_cells cells = scene.cells();
  const auto refuse = [&](int code, const std::string& text, const std::function<void(volccd_options&)>& change) {
    volccd_options options{};
    change(options);
    volccd_detector* detector = nullptr;
    expect_error(code, text, volccd_create(8, &cells, &options, &detector));
    EXPECT_EQ(detector, nullptr);
  };
  const int argument = VOLCCD_ERROR_ARGUMENT, config = VOLCCD_ERROR_CONFIG;
  const char* const hole[] = {"csat.axis=optimal", nullptr};
  const char* const unknown[] = {"csat.nonsense=1"};
  refuse(argument, "options.settings is NULL", [](auto& o) { o.setting_count = 1; });
  refuse(argument, "options.settings[1] is NULL", [&](auto& o) { o.settings = hole, o.setting_count = 2; });
  refuse(argument, "options.setting_count: -1", [](auto& o) { o.setting_count = -1; });
  refuse(argument, "options.threads: -1", [](auto& o) { o.threads = -1; });
  refuse(argument, "options.pairs: 3", [](auto& o) { o.pairs = 3; });
  refuse(argument, "options.edges: 2", [](auto& o) { o.edges = 2; });
  refuse(argument, "options.lists: 3", [](auto& o) { o.lists = 3; });
  refuse(argument, "options.excluded is NULL", [](auto& o) { o.excluded_count = 1; });
  refuse(argument, "options.excluded_count: -1", [](auto& o) { o.excluded_count = -1; });
  refuse(config, "Vol", [](auto& o) { o.pipeline = "Vol"; });
  refuse(config, "nonsense", [&](auto& o) { o.settings = unknown, o.setting_count = 1; });
  refuse(config, "threads", [](auto& o) { o.threads = 100000; });
  refuse(config, "separation", [](auto& o) { o.separation = -1; });
  refuse(config, "budget", [](auto& o) { o.lists = VOLCCD_LISTS_ALWAYS, o.list_budget = -1; });
}

TEST(CErrors, OfSteps) {
  const Scene scene;
  const Handle d = create(8, scene.cells());
  const double *x0 = values(scene.x0), *x1 = values(scene.x1);
  const int argument = VOLCCD_ERROR_ARGUMENT;
  ASSERT_EQ(volccd_step(d.get(), 8, x0, x1, 0, 1), VOLCCD_OK);
  ASSERT_FALSE(take(volccd_contacts, d).empty());
  expect_error(argument, "x1 is NULL", volccd_step(d.get(), 8, x0, nullptr, 0, 1));
  EXPECT_TRUE(take(volccd_contacts, d).empty()) << "after an error there are no results";
  EXPECT_TRUE(take(volccd_statistics, d).empty());
  expect_error(argument, "detector is NULL", volccd_step(nullptr, 8, x0, x1, 0, 1));
  expect_error(argument, "x0 is NULL", volccd_step(d.get(), 8, nullptr, x1, 0, 1));
  expect_error(argument, "xm is NULL", volccd_step_quadratic(d.get(), 8, x0, nullptr, x1, 0, 1));
  expect_error(argument, "vertex_count: -8", volccd_step(d.get(), -8, x0, x1, 0, 1));
  expect_error(argument, "flags: 8", volccd_step(d.get(), 8, x0, x1, 8, 1));
  expect_error(VOLCCD_ERROR_INPUT, "7 positions for 8 vertices", volccd_step(d.get(), 7, x0, x1, 0, 1));
  expect_error(VOLCCD_ERROR_CONFIG, "t_max", volccd_step(d.get(), 8, x0, x1, 0, 1.5));
  std::vector<Vec3> broken = scene.x1;
  broken[5].y() = std::numeric_limits<double>::infinity();
  expect_error(VOLCCD_ERROR_INPUT, "x1[5]", volccd_step(d.get(), 8, x0, values(broken), 0, 1));
  volccd_contact contact;
  std::int32_t found;
  expect_error(argument, "contact is NULL", volccd_first(d.get(), 8, x0, x1, nullptr, &found));
  expect_error(argument, "found is NULL", volccd_first(d.get(), 8, x0, x1, &contact, nullptr));
  ASSERT_EQ(volccd_step(d.get(), 8, x0, x1, 0, 1), VOLCCD_OK) << "errors do no harm";
  EXPECT_FALSE(take(volccd_contacts, d).empty());
}

TEST(CErrors, OfEdits) {
  const Scene scene;
  const Handle d = create(8, scene.cells());
  const std::int64_t unknown[] = {0, 9}, none = 0;
  const volccd_cells cells = scene.cells();
  expect_error(VOLCCD_ERROR_INPUT, "removed[1]", volccd_edit(d.get(), unknown, 2, 0, nullptr));
  expect_error(VOLCCD_ERROR_ARGUMENT, "removed is NULL", volccd_edit(d.get(), nullptr, 1, 0, nullptr));
  expect_error(VOLCCD_ERROR_ARGUMENT, "removed_count: -1", volccd_edit(d.get(), &none, -1, 0, nullptr));
  expect_error(VOLCCD_ERROR_ARGUMENT, "new_vertices: -1", volccd_edit(d.get(), nullptr, 0, -1, nullptr));
  expect_error(VOLCCD_ERROR_ARGUMENT, "new_vertices: a mesh with 4294967295 vertices",
               volccd_edit(d.get(), nullptr, 0, (1LL << 32) - 9, nullptr));
  expect_error(VOLCCD_ERROR_INPUT, "0", volccd_edit(d.get(), nullptr, 0, 0, &cells));
  std::int64_t vertices = 0, elements = 0;
  ASSERT_EQ(volccd_size(d.get(), &vertices, &elements), VOLCCD_OK);
  EXPECT_EQ(vertices, 8);
  EXPECT_EQ(elements, 2);
}

TEST(CErrors, OfResults) {
  const Scene scene;
  const Handle d = create(8, scene.cells());
  const volccd_contact* contacts = nullptr;
  std::int64_t count = 77;
  double value = 77;
  const int argument = VOLCCD_ERROR_ARGUMENT;
  expect_error(argument, "detector is NULL", volccd_contacts(nullptr, &contacts, &count));
  expect_error(argument, "contacts is NULL", volccd_contacts(d.get(), nullptr, &count));
  expect_error(argument, "count is NULL", volccd_contacts(d.get(), &contacts, nullptr));
  expect_error(argument, "ends is NULL", volccd_contact_ends(d.get(), nullptr, &count));
  expect_error(argument, "pairs is NULL", volccd_initial_overlaps(d.get(), nullptr, &count));
  expect_error(argument, "entries is NULL", volccd_statistics(d.get(), nullptr, &count));
  expect_error(argument, "name is NULL", volccd_statistic_value(d.get(), nullptr, &value));
  expect_error(argument, "value is NULL", volccd_statistic_value(d.get(), "contacts", nullptr));
  expect_error(argument, "no statistic 'nonsense'", volccd_statistic_value(d.get(), "nonsense", &value));
  expect_error(argument, "guarantee is NULL", volccd_guarantee(d.get(), nullptr));
  expect_error(argument, "detector is NULL", volccd_size(nullptr, nullptr, nullptr));
  expect_error(VOLCCD_ERROR_CONFIG, "separation", volccd_set_separation(d.get(), -1));
  EXPECT_EQ(count, 77) << "output is unchanged";
  EXPECT_EQ(value, 77);
  volccd_free(nullptr);
}

TEST(CErrors, HaveMessagesByThread) {
  expect_error(VOLCCD_ERROR_ARGUMENT, "detector is NULL", volccd_set_separation(nullptr, 0));
  std::thread([] {
    EXPECT_STREQ(volccd_last_error(), "");
    volccd_contacts(nullptr, nullptr, nullptr);
    volccd_create(0, nullptr, nullptr, nullptr);
  }).join();
  EXPECT_STREQ(volccd_last_error(), "detector is NULL");
}

}  // namespace
}  // namespace volccd::capi_test
