// Which contacts a picture marks, and where.
#pragma once

#include <array>
#include <cstdint>
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
  Vec3 point;                     ///< where the features meet, at the time of contact
  bool inter = false;             ///< no part has elements at both features
};

/// Contacts of the motion motion -> motion + 1 of a sequence, found by the pipeline VolCCD+. Solid shells: slots of the
/// solid mesh. Throws what reading and the pipeline throw.
std::vector<PictureContact> find_contacts(SequenceReader& reader, int motion, ShellModel shells, unsigned threads);

/// Those that a file has for this motion. `ids`: of the vertex slots, ascending. Throws InputError for a bad file and
/// for ids that are not there.
std::vector<PictureContact> contacts_from_csv(const std::string& file, int motion, std::span<const std::int64_t> ids);

/// Sets `inter`. A feature belongs to the parts that have an element at each of its vertices. O(cells + c log c).
void classify(std::vector<PictureContact>& contacts, const SequenceCells& cells, Index vertex_count);

}  // namespace volccd
