// What all interchangeable stages have in common: a declared guarantee, a state that the caller owns, and a descriptor
// under which the registry lists and creates the stage.
#pragma once

#include <cstddef>
#include <functional>
#include <memory>
#include <string>
#include <type_traits>
#include <vector>

#include <volccd/core/options.hpp>

namespace volccd {

/// What a stage guarantees about the pairs that it keeps or reports. The guarantee of a pipeline is the weakest
/// guarantee among its stages.
enum class Guarantee {
  exact,         ///< exact decision for the given doubles
  conservative,  ///< never loses a contact; may keep pairs that do not touch
  approximate    ///< rounding or a tolerance may lose or invent a contact
};

const char* to_string(Guarantee guarantee);

/// The weaker of two guarantees.
constexpr Guarantee weakest(Guarantee a, Guarantee b) { return a < b ? b : a; }

/// What a stage keeps from one step to the next (for example a tree or an O-Set), and its scratch memory. The state of
/// a stage that keeps nothing has this base type. Stage::make_state() creates the state, the Workspace owns it, and
/// each call of the stage receives it.
class StageState {
 public:
  virtual ~StageState() = default;
  /// Bytes of heap memory, for `stats.json`.
  virtual std::size_t bytes() const { return 0; }
};

/// What the registry stores about a stage of interface `Stage`.
template <class Stage>
struct StageDescriptor {
  std::string name;         ///< as users type it: lower case, with hyphens
  std::string description;  ///< one line
  Guarantee guarantee;
  std::vector<OptionInfo> options;
  std::function<std::unique_ptr<Stage>(const OptionValues&)> make;  ///< throws ConfigError
};

/// T::options(), or no options if the stage T has no such function.
template <class T>
const Options<typename T::Config>& options_of() {
  if constexpr (requires { T::options(); }) {
    return T::options();
  } else {
    static const Options<typename T::Config> none;
    return none;
  }
}

/// Descriptor of a stage `T : Stage` that has `struct T::Config`. If there are options, it has a constructor with a
/// Config parameter and `static const Options<Config>& T::options()`.
template <class Stage, class T>
StageDescriptor<Stage> describe_stage(std::string name, std::string description, Guarantee guarantee) {
  return {std::move(name), std::move(description), guarantee, options_of<T>().describe(),
          [](const OptionValues& values) -> std::unique_ptr<Stage> {
            const auto config = options_of<T>().parse(values);
            if constexpr (std::is_constructible_v<T, const typename T::Config&>) {
              return std::make_unique<T>(config);
            } else {
              static_assert(std::is_empty_v<typename T::Config>, "a stage with options is made from its Config");
              return std::make_unique<T>();
            }
          }};
}

}  // namespace volccd
