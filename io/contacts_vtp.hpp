// Contacts as points for ParaView: VTK XML PolyData (.vtp).
#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include <volccd/io/contacts_csv.hpp>
#include <volccd/io/step_text.hpp>
#include <volccd/mesh/mesh.hpp>
#include <volccd/query/contact.hpp>

namespace volccd {

/// A point per contact of all steps, at Contact::point, in the order of contacts.csv. Point data: Normal (3), Step (k
/// of the step k -> k+1), TimeOfImpact (in [0, 1] of the step), Time (of the sequence), Kind (0: VF, 1: EE),
/// AtStart, Object1, Object2, Element1, Element2 (ContactSide), VertexIds (4). Written at the end: the contacts are
/// kept in memory until then, about 200 bytes each.
class ContactsVtpWriter {
 public:
  /// Throws InputError if the file cannot be written.
  explicit ContactsVtpWriter(const std::string& file);

  /// Contacts of this step, from `begin_time` to `end_time`, in any order. `step` is greater than before.
  void write_step(int step, double begin_time, double end_time, std::span<const Contact> contacts, const Mesh& mesh);
  /// Writes the file by the rules of OutputFile.
  void finish();
  /// Keeps the complete steps and a comment with steps.text() in the second line.
  StepsDone finish_incomplete(const StepsDone& steps);

 private:
  void write(const std::string& comment);

  OutputFile output_;
  std::vector<ContactRow> rows_;
  std::vector<double> times_;
};

}  // namespace volccd
