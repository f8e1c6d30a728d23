// What every interchangeable stage has in common: a declared guarantee, state that the caller owns, and a descriptor
// under which the registry lists and makes it.
#pragma once

#include <cstddef>
#include <functional>
#include <memory>
#include <string>
#include <vector>

#include <volccd/core/options.hpp>

namespace volccd {

/// What a stage promises about the pairs that it keeps or reports. A pipeline's guarantee is the weakest of its
/// stages'.
enum class Guarantee {
  exact,         ///< decides exactly, on the given doubles
  conservative,  ///< never loses a contact; may keep what does not touch
  approximate    ///< rounding or a tolerance may lose or invent a contact
};

const char* to_string(Guarantee guarantee);

/// The weaker of the two.
constexpr Guarantee weakest(Guarantee a, Guarantee b) { return a < b ? b : a; }

/// What a stage keeps from one step to the next (a tree, an O-Set) and its scratch memory; a stage that keeps nothing
/// has a state of this type. Owned by the Workspace, made by Stage::make_state(), given back to the stage at every
/// call.
class StageState {
 public:
  virtual ~StageState() = default;
  /// Heap bytes held, for `stats.json`.
  virtual std::size_t bytes() const { return 0; }
};

/// How the registry knows a stage of interface `Stage`.
template <class Stage>
struct StageDescriptor {
  std::string name;         ///< as typed by a user: lower case, hyphens
  std::string description;  ///< one line
  Guarantee guarantee;
  std::vector<OptionInfo> options;
  std::function<std::unique_ptr<Stage>(const OptionValues&)> make;  ///< throws ConfigError
};

/// Descriptor of a stage `T : Stage` that has `struct T::Config`, `static Options<Config> T::options()` and a
/// constructor from Config.
template <class Stage, class T>
StageDescriptor<Stage> describe_stage(std::string name, std::string description, Guarantee guarantee) {
  return {std::move(name), std::move(description), guarantee, T::options().describe(),
          [](const OptionValues& values) -> std::unique_ptr<Stage> {
            return std::make_unique<T>(T::options().parse(values));
          }};
}

}  // namespace volccd
