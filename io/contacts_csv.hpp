// Contacts as a CSV file: a header, then one row for each contact.
//
//     step,kind,a,b,c,d,toi,nx,ny,nz,px,py,pz,at_start,object_1,object_2,element_1,element_2
//
// step is k for the step from frame k to frame k+1. Kind VF: a = vertex, b < c < d = triangle; kind EE: a < b, c < d,
// (a,b) < (c,d); all are vertex ids. toi, normal and point have 17 significant digits, so that reading them gives the
// same doubles. at_start is 1 or 0, as Contact::at_start. object_1 and element_1 are the ContactSide of the first
// feature (vertex, edge a b), object_2 and element_2 that of the second. If a file ends before the last requested step,
// its last line begins with kIncompleteMark and says which steps are complete, and why the others are missing.
#pragma once

#include <array>
#include <cstdint>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include <volccd/io/contact_sides.hpp>
#include <volccd/io/step_text.hpp>
#include <volccd/mesh/mesh.hpp>
#include <volccd/query/contact.hpp>

namespace volccd {

/// One row. `normal` and `point` are zero, `at_start` is false, and `sides` are those of no element, if the file does
/// not have these columns.
struct ContactRow {
  std::int64_t step = 0;
  FeatureKind kind = FeatureKind::vf;
  std::array<std::int64_t, 4> ids{};
  double toi = 0;
  Vec3 normal = Vec3::Zero(), point = Vec3::Zero();
  bool has_geometry = false;  ///< `normal` and `point` are given
  bool at_start = false;
  std::array<ContactSide, 2> sides{};

  friend bool operator==(const ContactRow&, const ContactRow&) = default;
};

/// Canonical order: step, kind (VF first), ids.
bool canonical_less(const ContactRow& x, const ContactRow& y);

/// The row of a contact in this step.
ContactRow contact_row(int step, const Contact& contact, const Mesh& mesh);

/// The first line of the file, and a row of it, both with the end of the line. Throws InputError that names `file` for
/// a number that is not finite.
std::string contacts_csv_header();
void append_csv_row(const ContactRow& row, const std::string& file, std::string& text);

/// Writes the file step by step, with the rows of each step in canonical order. Behaves as StepTextWriter; also throws
/// InputError for a number that is not finite.
class ContactsCsvWriter {
 public:
  explicit ContactsCsvWriter(const std::string& file);
  ContactsCsvWriter(ContactsCsvWriter&&) noexcept;
  ~ContactsCsvWriter();

  /// Contacts of this step on `mesh`, in any order. `step` is greater than before.
  void write_step(int step, std::span<const Contact> contacts, const Mesh& mesh);
  void finish();
  StepsDone finish_incomplete(const StepsDone& steps);

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

/// The rows in the order of the file. The last columns may be missing: those after at_start, pz or toi. A file marked
/// as incomplete is an error, unless `incomplete` is given, which receives the text of that line, or an empty text.
/// Throws InputError (file, "line", number of the line from 1) for a different header, a wrong number of fields, a
/// field that is not a number, an unknown kind, ids not in the order above or with a common vertex, toi outside [0, 1],
/// a number that is not finite, at_start neither 0 nor 1, an element below -1, and a last line without a line break.
std::vector<ContactRow> read_contacts_csv(const std::string& file, std::string* incomplete = nullptr);

}  // namespace volccd
