// Errors that reach a caller. Programmer errors are assertions. Degenerate geometry is not an error: it gets a
// conservative answer and is counted. Exceptions are thrown where data or configuration enters the library.
#pragma once

#include <cstdint>
#include <stdexcept>
#include <string>

namespace volccd {

/// Base class of all exceptions that this library throws deliberately.
class Error : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

/// Bad input data. The message names the file (or other source), the dataset in it, and the index. Exit code 2 of the
/// program.
class InputError : public Error {
 public:
  static constexpr std::int64_t kNoIndex = -1;

  /// `source` is a file name or, for data in memory, a word such as "mesh"; `dataset` may be empty.
  InputError(std::string source, std::string dataset, std::int64_t index, const std::string& problem);
  InputError(std::string source, std::string dataset, const std::string& problem)
      : InputError(std::move(source), std::move(dataset), kNoIndex, problem) {}

  const std::string& source() const { return source_; }
  const std::string& dataset() const { return dataset_; }
  std::int64_t index() const { return index_; }

 private:
  std::string source_, dataset_;
  std::int64_t index_;
};

/// A stage, option or combination that does not exist, or whose completeness argument does not hold. Exit code 2.
class ConfigError : public Error {
 public:
  using Error::Error;
};

}  // namespace volccd
