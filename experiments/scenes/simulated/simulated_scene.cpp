#include <volccd/experiments/scenes/simulated/simulated_scene.hpp>

#include <volccd/experiments/scenes/simulated/airbag.hpp>
#include <volccd/experiments/scenes/simulated/bullet.hpp>
#include <volccd/experiments/scenes/simulated/crash.hpp>
#include <volccd/experiments/scenes/simulated/liver.hpp>
#include <volccd/experiments/scenes/simulated/octopi.hpp>
#include <volccd/experiments/scenes/simulated/weld.hpp>

namespace volccd {

namespace {

SimulatedScene bullet() {
  return {.name = "bullet",
          .description = "a copper bullet perforates a steel plate, which breaks; hexahedra",
          .model = bullet_model,
          .default_elements = kBulletElements,
          .quick_elements = kBulletQuickElements,
          .frames = kBulletFrames,
          .duration = kBulletDuration,
          .version = 8};
}

SimulatedScene bullet_with(const char* name, const char* description, simulation::ContactFeatures features) {
  SimulatedScene scene = bullet();
  scene.name = name;
  scene.description = description;
  scene.options.features = features;
  scene.variant_of = "bullet";
  scene.version = 7;
  return scene;
}

}  // namespace

const std::vector<SimulatedScene>& simulated_scenes() {
  static const std::vector<SimulatedScene> all = {
      {.name = "octopi",
       .description = "three soft octopi are thrown at each other and entangle in a funnel; tetrahedra",
       .model = octopi_model,
       .default_elements = kOctopiElements,
       .quick_elements = kOctopiQuickElements,
       .frames = kOctopiFrames,
       .duration = kOctopiDuration,
       .version = 7},
      bullet(),
      {.name = "airbag",
       .description = "a folded airbag inflates in front of a steering wheel; shells",
       .model = airbag_model,
       .default_elements = kAirbagElements,
       .quick_elements = kAirbagQuickElements,
       .frames = kAirbagFrames,
       .begin = kAirbagBegin,
       .duration = kAirbagDuration,
       .version = 7},
      {.name = "crash",
       .description = "the front of a car of thin sheet hits a rigid wall; shells",
       .model = crash_model,
       .default_elements = kCrashElements,
       .quick_elements = kCrashQuickElements,
       .frames = kCrashFrames,
       .duration = kCrashDuration,
       .version = 7},
      {.name = "liver",
       .description = "a liver that hangs from its sides is cut from below by a scalpel; tetrahedra",
       .model = liver_model,
       .default_elements = kLiverElements,
       .quick_elements = kLiverQuickElements,
       .frames = kLiverFrames,
       .begin = kLiverBegin,
       .duration = kLiverDuration,
       .version = 7},
      {.name = "weld",
       .description = "a plate is shot at another, welds to it, and cracks it inside; hexahedra",
       .model = weld_model,
       .default_elements = kWeldElements,
       .quick_elements = kWeldQuickElements,
       .frames = kWeldFrames,
       .duration = kWeldDuration,
       .version = 3},
      bullet_with("bullet-boundary", "bullet; of contacts only those between features of the boundary are resisted",
                  simulation::ContactFeatures::boundary),
      bullet_with("bullet-surface", "bullet; only those between features of the surface as it was before it broke",
                  simulation::ContactFeatures::surface),
  };
  return all;
}

const SimulatedScene* find_simulated_scene(const std::string& name) {
  for (const SimulatedScene& scene : simulated_scenes())
    if (scene.name == name) return &scene;
  return nullptr;
}

}  // namespace volccd
