// Scenes: made-up sequences, frame by frame, and the list of them that the program, the tests and the experiments
// share.
#pragma once

#include <functional>
#include <memory>
#include <string>
#include <vector>

#include <volccd/core/options.hpp>
#include <volccd/mesh/sequence/cells.hpp>
#include <volccd/mesh/sequence/metadata.hpp>
#include <volccd/core/step_text.hpp>
#include <volccd/oracle/cases/shapes.hpp>

namespace volccd {

/// A sequence that is computed when asked for. Vertices have ids 0, 1, 2, ..; all frames have all of them, whether
/// elements use them or not, while elements come and go. The same scene gives the same frames, bit for bit, in any
/// order of asking. Immutable; concurrent calls allowed.
class Scene {
 public:
  virtual ~Scene() = default;

  virtual const SequenceMetadata& metadata() const = 0;
  /// At least 2: the ends of the first motion.
  virtual int frames() const = 0;
  /// Ascends with the frame.
  virtual double time(int frame) const = 0;
  virtual Index vertex_count() const = 0;
  /// Replaces the contents of `out` by [vertex_count()] positions.
  virtual void positions(int frame, std::vector<Vec3>& out) const = 0;
  /// Replaces the contents of `out` by the live elements.
  virtual void cells(int frame, SequenceCells& out) const = 0;
};

/// Writes all frames as a sequence file, a frame at a time. `go_on` is asked before each frame; where it says false,
/// the frames so far are kept, marked as incomplete, or nothing if there is none. Throws what SequenceWriter throws.
StepsDone write_scene(const Scene& scene, const std::string& file, const std::function<bool(int done)>& go_on = {});

/// The elements of a frame as a mesh: element i of cells() in slot i.
Mesh scene_mesh(const Scene& scene, int frame);

/// Step `step` of a sequence file as a shape that scenes can be made from: vertices that no element uses are left out,
/// the rest renumbered in ascending order; elements keep their ids and parts. Throws what SequenceReader throws, and
/// ConfigError if the file has no such step.
Shape shape_from_file(const std::string& file, int step = 0);

/// How the list knows a scene.
struct SceneDescriptor {
  std::string name;
  std::string description;  ///< one line
  bool needs_mesh;          ///< whether `make` wants a mesh to work on
  std::vector<OptionInfo> options;
  /// `mesh` is looked at during the call only, and may be null if the scene needs none. Throws ConfigError.
  std::function<std::unique_ptr<Scene>(const OptionValues& values, const Shape* mesh)> make;
};

/// All scenes, in the order of `volccd scene list`.
const std::vector<SceneDescriptor>& scenes();

/// Makes the scene of this name. Throws ConfigError: unknown name (naming the known ones), bad option, mesh missing or
/// not wanted.
std::unique_ptr<Scene> make_scene(const std::string& name, const OptionValues& values, const Shape* mesh = nullptr);

}  // namespace volccd
