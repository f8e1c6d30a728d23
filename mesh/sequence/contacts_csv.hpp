// Contacts as text: a header, then a row per contact.
//
//     step,kind,a,b,c,d,toi,nx,ny,nz,px,py,pz
//
// step is the index k of the motion k -> k+1. Kind VF: a = vertex, b < c < d = triangle; kind EE: a < b, c < d, (a,b) <
// (c,d); all are vertex ids. toi, normal and point have 17 significant digits, which give back the same double.
#pragma once

#include <array>
#include <cstdint>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include <volccd/mesh/mesh.hpp>
#include <volccd/mesh/types.hpp>

namespace volccd {

/// A row. `normal` and `point` are zero where the file has none.
struct ContactRow {
  std::int64_t step = 0;
  FeatureKind kind = FeatureKind::vf;
  std::array<std::int64_t, 4> ids{};
  double toi = 0;
  Vec3 normal = Vec3::Zero(), point = Vec3::Zero();

  friend bool operator==(const ContactRow&, const ContactRow&) = default;
};

/// Canonical order: step, kind (VF first), ids.
bool canonical_less(const ContactRow& x, const ContactRow& y);

/// Row of a contact on `mesh`.
ContactRow contact_row(int step, const Contact& contact, const Mesh& mesh);

/// Writes step by step, each step's rows in canonical order. Atomic: the file appears under its name at finish();
/// without it nothing is left behind. Throws InputError naming the file if the system refuses, steps do not ascend, or
/// a number is not finite. One thread at a time.
class ContactsCsvWriter {
 public:
  explicit ContactsCsvWriter(const std::string& file);
  ContactsCsvWriter(ContactsCsvWriter&&) noexcept;
  ~ContactsCsvWriter();

  /// Contacts of motion `step` on `mesh`, in any order. `step` is greater than before.
  void write_step(int step, std::span<const Contact> contacts, const Mesh& mesh);
  void finish();

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

/// Rows in the order of the file, which is also read without the columns nx .. pz. Throws InputError (file, "line",
/// number of the line from 1): another header, wrong number of fields, not a number, an unknown kind, ids not in the
/// order above or a common vertex, toi outside [0, 1], a number that is not finite, a last line without its end.
std::vector<ContactRow> read_contacts_csv(const std::string& file);

}  // namespace volccd
