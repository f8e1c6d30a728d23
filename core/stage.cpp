#include <volccd/core/stage.hpp>

namespace volccd {

const char* to_string(Guarantee guarantee) {
  switch (guarantee) {
    case Guarantee::exact: return "exact";
    case Guarantee::conservative: return "conservative";
    case Guarantee::approximate: return "approximate";
  }
  return "?";
}

}  // namespace volccd
