// Contacts as text: reading gives the same bits as were written, and errors name the line.
#include <algorithm>
#include <clocale>
#include <cmath>
#include <cstdlib>
#include <cstring>
#include <fstream>
#include <limits>
#include <optional>
#include <random>
#include <set>

#include <gtest/gtest.h>

#include <volccd/core/error.hpp>
#include <volccd/io/contacts_csv.hpp>

#include "support/scratch_folder.hpp"
#include "support/test_data.hpp"

namespace volccd::test {
namespace {

Mesh vertices_of_ids(std::vector<std::int64_t> ids) {
  Mesh mesh;
  mesh.add_vertices(ids);
  return mesh;
}

/// Two tetrahedra with a common triangle (slots 1 2 3), of parts 7 and -2, and a separate one. Vertex ids are 10 times
/// the slots.
Mesh three_tetrahedra() {
  Mesh mesh;
  mesh.add_vertices(std::vector<std::int64_t>{0, 10, 20, 30, 40, 50, 60, 70, 80});
  mesh.add_element({.type = ElementType::tetrahedron, .vertices = {0, 1, 2, 3}, .object = 7, .id = 500});
  mesh.add_element({.type = ElementType::tetrahedron, .vertices = {1, 2, 3, 4}, .object = -2, .id = 400});
  mesh.add_element({.type = ElementType::tetrahedron, .vertices = {5, 6, 7, 8}, .object = 3, .id = 900});
  return mesh;
}

TEST(ContactsCsv, ExactText) {
  const ScratchFolder folder;
  const Mesh mesh = vertices_of_ids({10, 20, 30, 40, 50});
  const std::vector<Contact> contacts = {
      {FeatureKind::ee, {0, 2, 1, 3}, 0.5, Vec3(0, 0, 1), {}, Vec3(1, 2, 3)},
      {FeatureKind::vf, {4, 0, 1, 2}, 0.1, Vec3(-1, 0, 0), {}, Vec3(1e-300, 1e20, -0.0)},
      {FeatureKind::ee, {0, 1, 2, 3}, 0, Vec3(0, 0, 0), {}, Vec3(0.25, 0, 0), true}};
  ContactsCsvWriter writer(folder / "c.csv");
  writer.write_step(3, contacts, mesh);
  writer.write_step(4, {}, mesh);
  EXPECT_FALSE(std::filesystem::exists(folder / "c.csv"));
  writer.finish();
  EXPECT_EQ(text_of(folder / "c.csv"),
            "step,kind,a,b,c,d,toi,nx,ny,nz,px,py,pz,at_start,object_1,object_2,element_1,element_2\n"
            "3,VF,50,10,20,30,0.10000000000000001,-1,0,0,1e-300,1e+20,-0,0,-1,-1,-1,-1\n"
            "3,EE,10,20,30,40,0,0,0,0,0.25,0,0,1,-1,-1,-1,-1\n"
            "3,EE,10,30,20,40,0.5,0,0,1,1,2,3,0,-1,-1,-1,-1\n");
  EXPECT_EQ(folder.entries(), 1u);
}

/// A contact between two elements of three_tetrahedra(), by slot.
Contact contact_of(FeatureKind kind, std::array<Index, 4> vertices, std::array<Index, 2> elements, double toi = 0.5) {
  Contact contact{kind, vertices, toi, Vec3::Zero(), {}, Vec3::Zero()};
  contact.elements = elements;
  return contact;
}

TEST(ContactsCsv, ObjectsAndElementsOfBothFeatures) {
  const Mesh mesh = three_tetrahedra();
  const ScratchFolder folder;
  ContactsCsvWriter writer(folder / "c.csv");
  writer.write_step(0, std::vector{contact_of(FeatureKind::vf, {5, 1, 2, 3}, {2, 1})}, mesh);
  writer.finish();
  EXPECT_NE(text_of(folder / "c.csv").find(",0,3,-2,900,400\n"), std::string::npos);
  EXPECT_EQ(read_contacts_csv(folder / "c.csv").at(0).sides, (std::array<ContactSide, 2>{{{3, 900}, {-2, 400}}}));
}

TEST(ContactsCsv, PairsOfObjects) {
  const Mesh mesh = three_tetrahedra();
  ObjectPairs pairs;
  count_object_pairs(2, {}, mesh, pairs);
  count_object_pairs(3,
                     std::vector{contact_of(FeatureKind::vf, {5, 0, 1, 2}, {2, 0}, 0.75),
                                 contact_of(FeatureKind::ee, {0, 1, 5, 6}, {0, 2}, 0.5)},
                     mesh, pairs);
  count_object_pairs(4,
                     std::vector{contact_of(FeatureKind::vf, {0, 6, 7, 8}, {0, 2}, 0.25),
                                 contact_of(FeatureKind::ee, {1, 2, 3, 4}, {1, 1}, 0.125)},
                     mesh, pairs);
  ASSERT_EQ(pairs.size(), 2u);
  const ObjectPairCount& between = pairs.at({3, 7});
  EXPECT_EQ(between.vf, 2u);
  EXPECT_EQ(between.ee, 1u);
  EXPECT_EQ(between.first_step, 3);
  EXPECT_EQ(between.first_toi, 0.5);
  const ObjectPairCount& within = pairs.at({-2, -2});
  EXPECT_EQ(within.vf + within.ee, 1u);
  EXPECT_EQ(within.first_step, 4);
  EXPECT_EQ(within.first_toi, 0.125);
}

/// Doubles with random bits, and ids up to the largest one.
TEST(ContactsCsv, ThereAndBackToTheLastBit) {
  const ScratchFolder folder;
  std::mt19937_64 random(3);
  std::vector<std::int64_t> ids;
  for (std::int64_t i = 0; i < 40; ++i) ids.push_back(i * i * i);
  ids.push_back(std::numeric_limits<std::int64_t>::max());
  const Mesh mesh = vertices_of_ids(ids);
  const auto real = [&] {
    for (;;) {
      const std::uint64_t bits = random();
      double value;
      std::memcpy(&value, &bits, sizeof value);
      if (std::isfinite(value)) return value;
    }
  };
  std::vector<ContactRow> expected;
  ContactsCsvWriter writer(folder / "c.csv");
  for (int step = 0; step < 20; step += 3) {
    std::vector<Contact> contacts;
    std::set<std::array<Index, 4>> seen;
    for (int i = 0; i < 50; ++i) {
      std::array<Index, 4> v{};
      for (Index& x : v) x = static_cast<Index>(random() % ids.size());
      const bool vf = random() % 2;
      if (vf)
        std::sort(v.begin() + 1, v.end());
      else
        std::sort(v.begin(), v.end());
      const std::set<Index> distinct(v.begin(), v.end());
      if (distinct.size() < 4 || !seen.insert(v).second) continue;
      contacts.push_back({vf ? FeatureKind::vf : FeatureKind::ee,
                          v,
                          static_cast<double>(random() >> 11) * 0x1p-53,
                          Vec3(real(), real(), real()),
                          {},
                          Vec3(real(), real(), real())});
      expected.push_back(contact_row(step, contacts.back(), mesh));
    }
    writer.write_step(step, contacts, mesh);
  }
  writer.finish();
  std::sort(expected.begin(), expected.end(), [](const auto& x, const auto& y) { return canonical_less(x, y); });
  EXPECT_EQ(read_contacts_csv(folder / "c.csv"), expected);
}

/// A German locale for numbers is compiled into a folder of the test, so that the test does not depend on the locales
/// of the machine. If this fails, an installed locale is used.
class GermanNumbers {
 public:
  GermanNumbers() {
    const std::string command = "localedef -i de_DE -f UTF-8 '" + (folder_ / "de_DE.UTF-8") + "' >/dev/null 2>&1";
    // localedef warns even if it succeeds; the test below shows whether the locale works.
    [[maybe_unused]] const int code = std::system(command.c_str());
    if (const char* path = std::getenv("LOCPATH")) before_ = path;
    ::setenv("LOCPATH", (folder_ / "").c_str(), 1);
    is_set_ = std::setlocale(LC_NUMERIC, "de_DE.UTF-8") != nullptr;
    restore_path();
    is_set_ = is_set_ || std::setlocale(LC_NUMERIC, "de_DE.UTF-8") != nullptr;
  }
  ~GermanNumbers() { std::setlocale(LC_NUMERIC, "C"); }

  bool is_set() const { return is_set_; }

 private:
  void restore_path() {
    if (before_)
      ::setenv("LOCPATH", before_->c_str(), 1);
    else
      ::unsetenv("LOCPATH");
  }

  ScratchFolder folder_;
  std::optional<std::string> before_;
  bool is_set_ = false;
};

TEST(ContactsCsv, PointsNotCommasInEveryLocale) {
  const GermanNumbers locale;
  if (!locale.is_set()) GTEST_SKIP() << "no locale with a decimal comma: localedef and package locales are missing";
  ASSERT_STREQ(std::localeconv()->decimal_point, ",");
  const ScratchFolder folder;
  ContactsCsvWriter writer(folder / "c.csv");
  const std::vector<Contact> contacts = {{FeatureKind::vf, {0, 1, 2, 3}, 0.5, Vec3::Zero(), {}, Vec3::Zero()}};
  writer.write_step(0, contacts, vertices_of_ids({0, 1, 2, 3}));
  writer.finish();
  EXPECT_EQ(text_of(folder / "c.csv").find("0,5"), std::string::npos);
  EXPECT_EQ(read_contacts_csv(folder / "c.csv").at(0).toi, 0.5);
}

TEST(ContactsCsv, WriterRefuses) {
  const ScratchFolder folder;
  for (const std::string& file : {folder / "no/such/folder/c.csv", folder / "", std::string("/proc/c.csv")})
    EXPECT_THROW(ContactsCsvWriter{file}, InputError);
  const Mesh mesh = vertices_of_ids({0, 1, 2, 3});
  {
    ContactsCsvWriter writer(folder / "c.csv");
    const std::vector<Contact> bad = {
        {FeatureKind::vf, {0, 1, 2, 3}, std::numeric_limits<double>::quiet_NaN(), Vec3::Zero(), {}, Vec3::Zero()}};
    EXPECT_THROW(writer.write_step(0, bad, mesh), InputError);
    writer.write_step(1, {}, mesh);
    EXPECT_THROW(writer.write_step(1, {}, mesh), InputError);
  }
  EXPECT_EQ(folder.entries(), 0u);
  ContactsCsvWriter writer(folder / "c.csv");
  writer.finish();
  EXPECT_THROW(writer.finish(), InputError);
  EXPECT_THROW(writer.write_step(5, {}, mesh), InputError);
  EXPECT_TRUE(read_contacts_csv(folder / "c.csv").empty());
}

TEST(ContactsCsv, BadLinesByNumber) {
  const ScratchFolder folder;
  const std::string file = folder / "c.csv", good = "0,VF,1,2,3,4,0.5\n";
  const std::string header = "step,kind,a,b,c,d,toi\n", full = "step,kind,a,b,c,d,toi,nx,ny,nz,px,py,pz\n";
  const auto line_of = [&](const std::string& text) -> std::int64_t {
    std::ofstream(file) << text;
    try {
      read_contacts_csv(file);
    } catch (const InputError& error) {
      EXPECT_EQ(error.source(), file);
      EXPECT_EQ(error.dataset(), "line");
      return error.index();
    }
    return 0;
  };
  EXPECT_EQ(line_of(header + good), 0);
  EXPECT_EQ(line_of("step,kind,a,b,c,d,toi\r\n0,VF,1,2,3,4,0.5\r\n"), 0);
  EXPECT_EQ(line_of(full + "0,VF,1,2,3,4,0.5,0,0,1,1e3,-2,3\n"), 0);
  EXPECT_EQ(line_of(""), 1);
  const std::string flagged = full.substr(0, full.size() - 1) + ",at_start\n";
  EXPECT_EQ(line_of(flagged + "0,VF,1,2,3,4,0.5,0,0,1,1e3,-2,3,0\n0,VF,1,2,3,5,0,0,0,1,1e3,-2,3,1\n"), 0);
  const std::string sided = flagged.substr(0, flagged.size() - 1) + ",object_1,object_2,element_1,element_2\n";
  const std::string former = flagged.substr(0, flagged.size() - 1) + ",part_1,part_2,element_1,element_2\n";
  for (const char* some : {",0,1,-2,3,0", ",1,-1,-1,-1,-1"})
    for (const std::string& head : {sided, former})
      EXPECT_EQ(line_of(head + "0,VF,1,2,3,4,0,0,0,1,1e3,-2,3" + some + "\n"), 0) << some;
  for (const char* bad : {",0", ",0,1,2,3", ",0,1,2,3,-2", ",0,1,2,3,", ",0,1,2,3,4,5", ",0,1,x,3,4"})
    EXPECT_EQ(line_of(sided + "0,VF,1,2,3,4,0,0,0,1,1e3,-2,3" + bad + "\n"), 2) << bad;
  for (const char* bad : {"", ",", ",2", ",01", ",true", ",1,0"})
    EXPECT_EQ(line_of(flagged + "0,VF,1,2,3,4,0,0,0,1,1e3,-2,3" + bad + "\n"), 2) << bad;
  EXPECT_EQ(line_of("a,b\n"), 1);
  EXPECT_EQ(line_of(good), 1);
  for (const char* bad : {"",
                          "0",
                          "0,VF,1,2,3,4",
                          "0,VF,1,2,3,4,0.5,1",
                          "0,XY,1,2,3,4,0.5",
                          "0,vf,1,2,3,4,0.5",
                          "x,VF,1,2,3,4,0.5",
                          "-1,VF,1,2,3,4,0.5",
                          "0,VF,1,2,3,4.5,0.5",
                          "0,VF,1,2,3,99999999999999999999,0.5",
                          "0,VF,1,2,4,3,0.5",
                          "0,VF,2,2,3,4,0.5",
                          "0,VF,1,2,2,3,0.5",
                          "0,VF,-1,2,3,4,0.5",
                          "0,EE,2,1,3,4,0.5",
                          "0,EE,1,2,4,3,0.5",
                          "0,EE,3,4,1,2,0.5",
                          "0,EE,1,2,1,2,0.5",
                          "0,EE,1,2,2,3,0.5",
                          "0,VF,1,2,3,4,nan",
                          "0,VF,1,2,3,4,1.0000001",
                          "0,VF,1,2,3,4,-1e-9",
                          "0,VF,1,2,3,4,",
                          "0,VF,1,2,3,4,0.5x",
                          "0, VF,1,2,3,4,0.5",
                          "0,VF,,2,3,4,0.5"})
    EXPECT_EQ(line_of(header + good + bad + "\n"), 3) << bad;
  EXPECT_EQ(line_of(full + "0,VF,1,2,3,4,0.5,0,0,inf,1,2,3\n"), 2);
  EXPECT_EQ(line_of(full + good), 2);
  EXPECT_EQ(line_of(header + good + "0,VF,1,2,3,4,0.5"), 3) << "no end of line: cut short";
  EXPECT_THROW(read_contacts_csv(folder / "absent"), InputError);
}

TEST(ContactsCsv, SharedReferenceFiles) {
  VOLCCD_NEEDS_DATA(projectile, "reference/ls-dyna-projectile.csv");
  const std::vector<ContactRow> rows = read_contacts_csv(projectile);
  EXPECT_EQ(rows.size(), static_cast<std::size_t>(std::ranges::count(text_of(projectile), '\n')) - 1);
  EXPECT_EQ(rows[0], (ContactRow{0, FeatureKind::ee, {1, 4, 5000, 5001}, 0.99328541121212766}));
  std::set<std::int64_t> steps;
  for (const ContactRow& row : rows) steps.insert(row.step);
  EXPECT_LE(*steps.rbegin(), 13);
  EXPECT_TRUE(read_contacts_csv(shared_data("reference/openradioss-airbag.csv")).empty());
  EXPECT_FALSE(read_contacts_csv(shared_data("reference/openradioss-bullet.csv")).empty());
  EXPECT_FALSE(read_contacts_csv(shared_data("reference/openradioss-crash.csv")).empty());
}

}  // namespace
}  // namespace volccd::test
