// Pictures of frames of sequences: objects in colours, contacts marked, captions and a legend.
#pragma once

#include <array>
#include <functional>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include <volccd/io/sequence/stepper.hpp>
#include <volccd/pictures/camera.hpp>
#include <volccd/pictures/image.hpp>
#include <volccd/pictures/renderer.hpp>

namespace volccd {

/// One frame of one file.
struct PicturePanel {
  std::string file;
  int frame = 0;
  std::string caption;   ///< empty: the sequence's title
  std::string contacts;  ///< contacts.csv file with the contacts; empty: they are computed
};

struct PictureConfig {
  int width = 1600;
  int height = 0;   ///< 0: chosen to fit what the camera shows
  int columns = 0;  ///< columns of panels; 0: all panels in a row
  View view = {};
  /// The camera shows the vertices_of_bodies() of all panels together; with `fit_fragments` all vertices in use; or, if
  /// given, the box (min x, max x, min y, ..).
  bool fit_fragments = false;
  std::optional<std::array<double, 6>> box = {};
  ShellModel shells = ShellModel::surface;
  /// Section planes, as "axis=value" or "axis=50%" (a position within the bounding box of all vertices in use). The
  /// viewer's side of each plane is removed.
  std::vector<std::string> cuts = {};
  /// Ids or names of objects to draw and to leave out (case-insensitive), separated by commas, or by semicolons if a
  /// name has a comma. Empty `objects`: all of them.
  std::string objects = {}, without = {};
  /// "object=#rrggbb", with the id or name of an object: replaces the colour of the palette.
  std::vector<std::string> colours = {};
  bool contacts = true;    ///< of the step from `frame` to `frame` + 1; at the last frame, of the step before
  bool text = true;        ///< captions and legend
  double mark_radius = 0;  ///< pixels; 0: by the size of the picture and the number of contacts
  double crease = 50;      ///< degrees: edges with a greater angle are shaded as sharp
  unsigned threads = 0;    ///< for the contacts; 0: as many as the machine has
  /// Called from time to time with the number of panels that are done; may throw to stop.
  std::function<void(double panels)> progress = {};
  RenderOptions render = {};
};

/// Draws the panels side by side with one camera; the colour of an object is the same in all of them. Deterministic.
/// Throws InputError for invalid files, and ConfigError if a frame or an object is not in a file, a size is out of
/// range, or nothing is left to draw.
Image draw_sequences(std::span<const PicturePanel> panels, const PictureConfig& config);

}  // namespace volccd
