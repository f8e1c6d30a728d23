// FCL compared with the reference contacts of real runs: two judges without common code, on meshes that deform and
// erode.
#include <volccd/oracle/overlap_oracle.hpp>

#include <gtest/gtest.h>

#include <algorithm>
#include <fstream>
#include <map>
#include <sstream>

#include <volccd/io/sequence/reader.hpp>

#include "support/test_data.hpp"

namespace volccd {
namespace {

/// Contacts of the reference file by motion; vertices as slots.
std::map<int, std::vector<Contact>> read_reference(const std::string& file, std::span<const std::int64_t> point_ids) {
  std::map<int, std::vector<Contact>> contacts;
  std::ifstream in(file);
  std::string line;
  std::getline(in, line);
  while (std::getline(in, line)) {
    std::replace(line.begin(), line.end(), ',', ' ');
    std::istringstream row(line);
    int step = 0;
    std::string kind;
    Contact contact{};
    row >> step >> kind;
    for (Index& v : contact.vertices) {
      std::int64_t id = 0;
      row >> id;
      v = static_cast<Index>(std::lower_bound(point_ids.begin(), point_ids.end(), id) - point_ids.begin());
    }
    row >> contact.toi;
    EXPECT_FALSE(row.fail()) << line;
    contact.kind = kind == "VF" ? FeatureKind::vf : FeatureKind::ee;
    contacts[step].push_back(contact);
  }
  return contacts;
}

struct Totals {
  std::uint64_t confirmed = 0, initial = 0, surface_only = 0, violations_without_contacts = 0;
};

/// Runs the motions k -> k+1 of a sequence. Each must pass, and must have contacts if any pair has come to overlap.
Totals check_motions(SequenceReader& reader, const std::string& reference, const std::vector<int>& motions) {
  const auto contacts = read_reference(reference, reader.point_ids());
  const auto executor = make_executor(0);
  Totals totals;
  for (const int k : motions) {
    SequenceCells cells;
    std::vector<Vec3> x0, x1;
    reader.read_cells(k + 1, cells);
    reader.read_points(k, x0);
    reader.read_points(k + 1, x1);
    const Topology topology(mesh_of(reader.point_ids(), cells));
    const Motion motion = Motion::linear(x0, x1);
    const ObjectFilter filter;
    const Step step{topology, motion, filter};
    const auto found = contacts.find(k);
    const std::vector<Contact> known = found == contacts.end() ? std::vector<Contact>() : found->second;
    const OverlapReport report = check_against_fcl(step, known, std::vector{0.3, 0.7, 1.0}, *executor);
    for (const OverlapViolation& v : report.violations)
      ADD_FAILURE() << "motion " << k << ", elements " << topology.mesh().element_id(v.pair.a) << " and "
                    << topology.mesh().element_id(v.pair.b) << " at t = " << v.time << ", depth " << v.depth
                    << ", first contact " << v.first_contact;
    EXPECT_EQ(report.hits, report.confirmed + report.initial + report.shallow + report.violations.size());
    totals.confirmed += report.confirmed;
    totals.initial += report.initial;
    totals.surface_only += report.surface_only;
    if (k == motions.front()) {
      const OverlapReport without = check_against_fcl(step, {}, std::vector{1.0}, *executor);
      totals.violations_without_contacts += without.violations.size();
    }
  }
  return totals;
}

TEST(LongFclOnSharedData, ProjectileAgreesWithTheReferenceContacts) {
  VOLCCD_NEEDS_DATA(path, "ls-dyna-projectile.vtkhdf");
  VOLCCD_NEEDS_DATA(reference, "reference/ls-dyna-projectile.csv");
  SequenceReader reader(path);
  const Totals totals = check_motions(reader, reference, {0, 1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11, 12, 13});
  EXPECT_GT(totals.confirmed, 300u);
  EXPECT_GT(totals.violations_without_contacts, 20u);
}

TEST(LongFclOnSharedData, BulletAgreesWithTheReferenceContacts) {
  VOLCCD_NEEDS_DATA(path, "openradioss-bullet.vtkhdf");
  VOLCCD_NEEDS_DATA(reference, "reference/openradioss-bullet.csv");
  SequenceReader reader(path);
  const Totals totals = check_motions(reader, reference, {10, 40, 80});
  EXPECT_GT(totals.confirmed, 100u);
  EXPECT_GT(totals.surface_only, 0u);
}

TEST(LongFclOnSharedData, CrashShellsAgreeWithTheReferenceContacts) {
  VOLCCD_NEEDS_DATA(path, "openradioss-crash.vtkhdf");
  VOLCCD_NEEDS_DATA(reference, "reference/openradioss-crash.csv");
  SequenceReader reader(path);
  const Totals totals = check_motions(reader, reference, {45});
  EXPECT_GT(totals.confirmed, 10u);
}

}  // namespace
}  // namespace volccd
