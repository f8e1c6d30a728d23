// What a panel of a picture shows: a frame of a sequence, with the contacts of a step.
#pragma once

#include <cstddef>
#include <cstdint>
#include <map>
#include <set>
#include <string>
#include <vector>

#include <volccd/io/sequence/cells.hpp>
#include <volccd/pictures/contact_marks.hpp>
#include <volccd/pictures/sequence_picture.hpp>

namespace volccd::detail {

struct PanelData {
  std::string caption, subtitle;
  SequenceCells all, drawn;  ///< of the frame; of the objects that are drawn, which the reader leaves empty
  std::vector<Vec3> points;
  std::vector<PictureContact> contacts;
  std::size_t inter = 0, intra = 0;  ///< numbers of contacts
  std::map<std::int32_t, std::string> object_names;
  std::set<std::int32_t> objects;  ///< of this frame and of the first one
};

/// Throws ConfigError if the file does not have the frame, and the exceptions of the reader and of the contacts.
PanelData read_panel(const PicturePanel& panel, const PictureConfig& config);

}  // namespace volccd::detail
