// Pictures of steps of sequences: parts in colours, contacts marked, captions and a legend.
#pragma once

#include <array>
#include <functional>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include <volccd/mesh/sequence/stepper.hpp>
#include <volccd/pictures/camera.hpp>
#include <volccd/pictures/image.hpp>
#include <volccd/pictures/renderer.hpp>

namespace volccd {

/// One step of one file.
struct PicturePanel {
  std::string file;
  int step = 0;
  std::string caption;   ///< empty: the sequence's title
  std::string contacts;  ///< contacts.csv to take the contacts from; empty: they are computed
};

struct PictureConfig {
  int width = 1600;
  int height = 0;   ///< 0: as high as what is to be seen needs
  int columns = 0;  ///< of panels; 0: all in a row
  View view = {};
  /// The camera shows vertices_of_bodies() of all panels together; all vertices in use; or the box (min x, max x,
  /// min y, ..) if there is one.
  bool fit_fragments = false;
  std::optional<std::array<double, 6>> box = {};
  ShellModel shells = ShellModel::surface;
  /// "axis=value": takes away the side of the viewer. "axis=50%": in the middle of all vertices in use.
  std::vector<std::string> cuts = {};
  /// Part ids or names (any case), separated by commas, or by semicolons where a name has a comma. Empty `parts`: all
  /// of them.
  std::string parts = {}, without = {};
  /// "part=#rrggbb", part an id or a name: in place of the palette's.
  std::vector<std::string> colours = {};
  bool contacts = true;    ///< of motion step -> step + 1; of the motion before for the last step
  bool text = true;        ///< captions and legend
  double mark_radius = 0;  ///< pixels; 0: by the size of the picture and the number of contacts
  double crease = 50;      ///< degrees: sharper edges are not shaded as round
  unsigned threads = 0;  ///< for the contacts; 0: as many as the machine has
  /// Called from time to time with the number of panels that are done; may throw to stop.
  std::function<void(double panels)> progress = {};
  RenderOptions render = {};
};

/// Draws the panels side by side with one camera; the colour of a part is the same in all of them. Deterministic.
/// Throws InputError for bad files, ConfigError for what cannot be drawn: a step or a part that a file does not have, a
/// size out of range, nothing left to draw.
Image draw_sequences(std::span<const PicturePanel> panels, const PictureConfig& config);

}  // namespace volccd
