// Scenes: synthetic sequences that are computed frame by frame, and the list of them that the program, the tests and
// the experiments share.
#pragma once

#include <functional>
#include <memory>
#include <string>
#include <vector>

#include <volccd/core/options.hpp>
#include <volccd/io/sequence/cells.hpp>
#include <volccd/io/sequence/metadata.hpp>
#include <volccd/io/step_text.hpp>
#include <volccd/oracle/cases/shapes.hpp>

namespace volccd {

/// A sequence that is computed on demand. Vertices have ids 0, 1, 2, ..; every frame has all of them, whether elements
/// use them or not, while elements may differ from frame to frame. The frames do not depend on the order of calls.
/// Immutable and thread-safe.
class Scene {
 public:
  virtual ~Scene() = default;

  virtual const SequenceMetadata& metadata() const = 0;
  /// Number of frames, at least 2 (the ends of the first step).
  virtual int frames() const = 0;
  /// Time of a frame; ascending.
  virtual double time(int frame) const = 0;
  virtual Index vertex_count() const = 0;
  /// Replaces the contents of `out` by [vertex_count()] positions.
  virtual void positions(int frame, std::vector<Vec3>& out) const = 0;
  /// Replaces the contents of `out` by the live elements.
  virtual void cells(int frame, SequenceCells& out) const = 0;
};

/// Writes all frames to a sequence file, one at a time. `go_on` is called before each frame; if it returns false, the
/// file has the frames so far and is marked as incomplete (no file is written if there are none). Throws the exceptions
/// of SequenceWriter.
StepsDone write_scene(const Scene& scene, const std::string& file, const std::function<bool(int done)>& go_on = {});

/// The elements of a frame as a mesh: element i of cells() in slot i.
Mesh scene_mesh(const Scene& scene, int frame);

/// Frame `frame` of a sequence file as a shape from which scenes can be made. Vertices that no element uses are left
/// out, and the others are renumbered in ascending order; elements keep their ids and objects. Throws the exceptions of
/// SequenceReader, and ConfigError if the file has no such frame.
Shape shape_from_file(const std::string& file, int frame = 0);

/// Entry of the list of scenes.
struct SceneDescriptor {
  std::string name;
  std::string description;  ///< one line
  bool needs_mesh;          ///< whether `make` requires a mesh
  std::vector<OptionInfo> options;
  /// Makes the scene. `mesh` is used during the call only, and may be null if the scene needs none. Throws ConfigError.
  std::function<std::unique_ptr<Scene>(const OptionValues& values, const Shape* mesh)> make;
};

/// All scenes, in the order of `volccd scene list`.
const std::vector<SceneDescriptor>& scenes();

/// Makes the scene of this name. Throws ConfigError for an unknown name (with a list of the known ones), an invalid
/// option, and a mesh that is missing or not used by the scene.
std::unique_ptr<Scene> make_scene(const std::string& name, const OptionValues& values, const Shape* mesh = nullptr);

}  // namespace volccd
