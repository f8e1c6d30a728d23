// Which contacts a picture marks, and where.
#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include <volccd/mesh/sequence/reader.hpp>
#include <volccd/mesh/sequence/stepper.hpp>
#include <volccd/query/contact.hpp>

namespace volccd {

/// A contact as far as a picture needs it.
struct PictureContact {
  FeatureKind kind;
  std::array<Index, 4> vertices;  ///< slots, as in Contact
  /// Where the features meet, at the time of contact; empty for a contact of a file without points.
  std::optional<Vec3> point;
  bool inter = false;             ///< no part has elements at both features
};

/// Contacts of the motion motion -> motion + 1 of a sequence, found by the pipeline VolCCD+. Solid shells: slots of the
/// solid mesh. Throws what reading and the pipeline throw.
std::vector<PictureContact> find_contacts(SequenceReader& reader, int motion, ShellModel shells, unsigned threads);

/// Those that a file has for this motion. `ids`: of the vertex slots, ascending. Throws InputError for a bad file and
/// for ids that are not there.
std::vector<PictureContact> contacts_from_csv(const std::string& file, int motion, std::span<const std::int64_t> ids);

/// The contact's point; without one, where the first feature is: its vertex (VF) or the middle of its edge (EE).
Vec3 mark_place(const PictureContact& contact, std::span<const Vec3> points);

/// Sets `inter`. A feature belongs to the parts that have an element at each of its vertices. O(cells + c log c).
void classify(std::vector<PictureContact>& contacts, const SequenceCells& cells, Index vertex_count);

}  // namespace volccd
