#include <volccd/core/error.hpp>

namespace volccd {

namespace {
std::string describe(const std::string& source, const std::string& dataset, std::int64_t index,
                     const std::string& problem) {
  std::string text = source;
  if (!dataset.empty()) text += (text.empty() ? "" : ": ") + dataset;
  if (index != InputError::kNoIndex) text += "[" + std::to_string(index) + "]";
  return text + ": " + problem;
}
}  // namespace

InputError::InputError(std::string source, std::string dataset, std::int64_t index, const std::string& problem)
    : Error(describe(source, dataset, index, problem)),
      source_(std::move(source)),
      dataset_(std::move(dataset)),
      index_(index) {}

}  // namespace volccd
