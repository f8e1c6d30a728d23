// The contacts that a picture marks, and the positions of the marks.
#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include <volccd/io/sequence/reader.hpp>
#include <volccd/io/sequence/stepper.hpp>
#include <volccd/query/contact.hpp>

namespace volccd {

/// The data of a contact that a picture needs.
struct PictureContact {
  FeatureKind kind;
  std::array<Index, 4> vertices;  ///< slots, as in Contact
  /// Where the features meet, at the time of contact; empty for a contact of a file without points.
  std::optional<Vec3> point;
  bool inter = false;  ///< no object has elements at both features
};

/// Contacts in step `step` of a sequence, from frame `step` to frame `step` + 1, found by the pipeline VolCCD+. With
/// ShellModel::solid, vertices are slots of the solid mesh. Throws the exceptions of the reader and of the pipeline.
std::vector<PictureContact> find_contacts(SequenceReader& reader, int step, ShellModel shells, unsigned threads);

/// Contacts of this step from a contacts.csv file. `ids`: the vertex ids, by slot, ascending. Throws InputError for
/// an invalid file and for unknown ids.
std::vector<PictureContact> contacts_from_csv(const std::string& file, int step, std::span<const std::int64_t> ids);

/// The contact's point; without one, where the first feature is: its vertex (VF) or the middle of its edge (EE).
Vec3 mark_place(const PictureContact& contact, std::span<const Vec3> points);

/// Sets `inter`. A feature belongs to the objects that have an element at each of its vertices. O(cells + c log c).
void classify(std::vector<PictureContact>& contacts, const SequenceCells& cells, Index vertex_count);

}  // namespace volccd
